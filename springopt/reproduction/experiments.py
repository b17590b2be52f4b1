"""The experiments, in the order of the paper."""

from __future__ import annotations

from springopt.reproduction import figure_1, topology_3d
from springopt.reproduction.experiment import Experiment

EXPERIMENTS: tuple[Experiment, ...] = (figure_1.EXPERIMENT, topology_3d.EXPERIMENT)
