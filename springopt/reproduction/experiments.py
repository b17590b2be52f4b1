"""The experiments, in the order of the paper."""

from __future__ import annotations

from springopt.reproduction import (
    figure_1,
    figure_3,
    figure_4,
    larger_meshes,
    load_sets,
    stiffness_recovery,
    table_1,
    topology_3d,
)
from springopt.reproduction.experiment import Experiment

EXPERIMENTS: tuple[Experiment, ...] = (
    figure_1.EXPERIMENT,
    topology_3d.EXPERIMENT,
    stiffness_recovery.EXPERIMENT,
    load_sets.EXPERIMENT,
    figure_3.EXPERIMENT,
    figure_4.EXPERIMENT,
    table_1.EXPERIMENT,
    larger_meshes.EXPERIMENT,
)
