"""Every effect of the core keeps the contract, as a stranger's is asked to."""

import pytest

import springopt as so
from springopt.testing import check_effect

EFFECTS = [
    so.Bending(2.0),
    so.Damping(springs=0.1, nodes=0.3),
    so.ExponentialStiffening(2.0),
    so.Gravity((0.0, -9.81)),
    so.Inertia(density=2.0),
    so.Inertia(mass=0.5),
    so.PlaneContact(2.0, (0.5, 0.5), (1.0, 2.0)),
    so.Prestress(scale=0.9),
    so.SphereContact(2.0, (0.0, 0.0), 1.0),
    so.Stiffening(quadratic=1.0, cubic=4.0),
    so.TensionOnly(),
    so.Volume(2.0),
    so.Gravity((0.0, 0.0, -9.81), density=0.5),
    so.PlaneContact(2.0, (0.5, 0.5, 0.5), (1.0, 2.0, 3.0)),
    so.SphereContact(2.0, (0.5, 0.5, 0.5), 1.0, inside=True),
]


@pytest.mark.parametrize("effect", EFFECTS, ids=repr)
def test_it_keeps_the_contract(effect):
    check_effect(effect)
