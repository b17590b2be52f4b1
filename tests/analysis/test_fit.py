"""A fit in given seconds: what it finds, from where, and what ends it."""

import json

import numpy as np
import pytest

from springopt.analysis import fit as module
from springopt.analysis.fit import fit
from springopt.scene import Scene


def setup(encoding):
    """Nine nodes whose springs have a stiffness of 5."""
    tables = {
        "name": "nine",
        "title": "Nine nodes",
        "lattice": {"grid": [3, 3]},
        "reference": {"kind": "spring", "stiffness": 5.0},
        "encoding": encoding,
        "load_cases": {
            "train": [
                {"name": "pull", "hold": "left", "push": {"on": "right", "force": [0.3, 0.0]}},
                {"name": "shear", "hold": "bottom", "push": {"on": "top", "force": [0.1, 0.0]}},
            ]
        },
    }
    return Scene.from_json(json.dumps(tables)).build()


@pytest.mark.parametrize("names", [["gauss-newton"], ["random-search"]])
def test_a_reference_in_the_box_is_found_with_a_plugin_and_without(names, monkeypatch):
    monkeypatch.setattr(module, "installed", lambda: names)
    found = fit(setup({"kind": "homogeneous", "upper": 8.0}), 20.0)
    assert found.point == pytest.approx([5.0], abs=1e-5)
    assert found.method == ("gauss-newton" if names == ["gauss-newton"] else "descents")
    assert not found.is_cut


def test_large_ones_go_down_by_gradients(monkeypatch):
    monkeypatch.setattr(module, "LEAST_LARGE", 0)
    monkeypatch.setattr(module, "LARGE", 0)
    found = fit(setup({"kind": "homogeneous", "upper": 8.0}), 20.0)
    assert found.method == "L-BFGS-B"
    assert found.point == pytest.approx([5.0], abs=1e-3)


def test_a_start_is_never_lost():
    bits = setup({"kind": "binary", "stiffness": 5.0})
    found = fit(bits, 0.0, start=np.ones(bits.encoding.size))
    assert found.value == pytest.approx(0.0, abs=1e-6)
    assert found.method in module.BINARY


def test_without_time_there_is_a_point_all_the_same(monkeypatch):
    monkeypatch.setattr(module, "LEAST_SECONDS", 1e-9)
    found = fit(setup({"kind": "real", "upper": 8.0}), 0.0)
    assert found.is_cut
    assert np.isfinite(found.value)
