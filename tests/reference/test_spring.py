"""A mass-spring model as reference."""

import numpy as np
import pytest

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.reference.spring import SpringReference

LATTICE = SpringLattice.grid((3, 2))
MODEL = Model(LATTICE)


def test_it_deforms_as_its_model_and_one_number_is_for_every_spring():
    pull = np.outer(side(LATTICE, "right"), [0.5, 0.0])
    case = LoadCase("pull", side(LATTICE, "left"), pull)
    expected = MODEL.solve(np.full(LATTICE.spring_count, 5.0), [case], 1e-10).positions[0]
    for stiffness in (5.0, np.full(LATTICE.spring_count, 5)):
        assert np.array_equal(SpringReference(MODEL, stiffness).deform(case), expected)


def test_a_load_that_nothing_resists_is_refused():
    push = np.outer(side(LATTICE, "right"), [0.5, 0.0])
    with pytest.raises(UserError, match="in load case 'push', but it ended as mechanism; add springs"):
        SpringReference(MODEL, 0.0).deform(LoadCase("push", side(LATTICE, "left"), push))


@pytest.mark.parametrize(
    ("stiffness", "tolerance", "sentence"),
    [
        ([1, 2], 1e-10, r"stiffness must have the shape \(11,\), not \(2,\)"),
        ([[5.0]], 1e-10, r"stiffness must have the shape \(11,\), not \(1, 1\)"),
        ("stiff", 1e-10, "stiffness must hold real numbers"),
        (-1.0, 1e-10, "stiffness is -1, but it must be finite and not negative"),
        (np.nan, 1e-10, "stiffness is nan"),
        (5.0, 0.0, "tolerance is 0, but it must be positive"),
    ],
)
def test_bad_input_is_refused_when_it_is_made(stiffness, tolerance, sentence):
    with pytest.raises(UserError, match=sentence):
        SpringReference(MODEL, stiffness, tolerance=tolerance)
