"""Stress and moduli against differences of the energy, plane stress against space, and what the laws agree on."""

import numpy as np
import pytest

from springopt.errors import UserError
from springopt.reference.law import volume_strain
from springopt.reference.material import Material

LAWS = ["saint-venant-kirchhoff", "neo-hookean"]
MATERIALS = {
    "space": (3, Material(2.0, 0.3)),
    "plane strain": (2, Material(2.0, 0.3)),
    "plane stress": (2, Material(2.0, 0.3, is_plane_stress=True)),
    "incompressible plane stress": (2, Material(2.0, 0.5, is_plane_stress=True)),
    "auxetic plane stress": (2, Material(2.0, -0.2, is_plane_stress=True)),
    "space without contraction": (3, Material(2.0, 0.0)),
}
every_law = pytest.mark.parametrize("law", LAWS)
every_material = pytest.mark.parametrize(("d", "material"), MATERIALS.values(), ids=MATERIALS)


def differences(function, point, direction, step=1e-2):
    """The derivative along a direction: central differences of three steps, extrapolated."""

    def central(h):
        return (function(point + h * direction) - function(point - h * direction)) / (2 * h)

    coarse, middle, fine = (central(step / 2**k) for k in range(3))
    return (64 * fine - 20 * middle + coarse) / 45


def strains(d, count=5, size=0.25):
    return np.random.default_rng(d).uniform(-size, size, (count, d, d))


@every_law
@every_material
def test_stress_is_the_derivative_of_energy_and_moduli_that_of_stress(law, d, material):
    answer, h = material.law(law), strains(d)
    assert answer.is_admissible(h).all()
    for direction in np.eye(d * d).reshape(-1, d, d):
        stress = np.einsum("cij,ij", answer.stress(h), direction)
        np.testing.assert_allclose(stress, differences(answer.energy, h, direction), atol=1e-9)
        moduli = np.einsum("cijkl,kl", answer.moduli(h), direction)
        np.testing.assert_allclose(moduli, differences(answer.stress, h, direction), atol=1e-9)


@every_law
@every_material
def test_a_body_at_rest_is_without_stress_and_follows_hookes_law(law, d, material):
    answer, rest = material.law(law), np.zeros((d, d))
    assert answer.energy(rest) == 0.0
    np.testing.assert_array_equal(answer.stress(rest), 0.0)
    unit = np.eye(d)
    hooke = material.lame * np.einsum("ij,kl->ijkl", unit, unit) + material.shear * (
        np.einsum("ik,jl->ijkl", unit, unit) + np.einsum("il,jk->ijkl", unit, unit)
    )
    np.testing.assert_allclose(answer.moduli(rest), hooke, atol=1e-14)


@every_law
@pytest.mark.parametrize("d", [2, 3])
def test_energy_does_not_see_a_rotation(law, d):
    answer, (h, other) = Material(2.0, 0.3).law(law), strains(d, count=2)
    rotation = np.linalg.qr(np.eye(d) + other)[0]
    rotation *= np.sign(np.linalg.det(rotation))  # of d = 3; in 2D the determinant must be seen to
    if np.linalg.det(rotation) < 0:
        rotation[:, 0] *= -1
    turned = rotation @ (np.eye(d) + h) - np.eye(d)
    assert answer.energy(turned) == pytest.approx(answer.energy(h), rel=1e-12)


@every_law
def test_plane_strain_is_the_law_in_space_with_no_stretch_across(law):
    material, h = Material(2.0, 0.3), strains(2)
    space = np.zeros((len(h), 3, 3))
    space[:, :2, :2] = h
    answer = material.law(law)
    np.testing.assert_allclose(answer.energy(h), answer.energy(space), rtol=1e-13)
    np.testing.assert_allclose(answer.stress(h), answer.stress(space)[:, :2, :2], atol=1e-13)


@every_law
@pytest.mark.parametrize("poisson", [0.3, 0.0, -0.2, 0.49])
def test_plane_stress_is_the_law_in_space_without_stress_across(law, poisson):
    sheet, space = Material(2.0, poisson, is_plane_stress=True).law(law), Material(2.0, poisson).law(law)
    for h in strains(2):
        whole = np.zeros((3, 3))
        whole[:2, :2] = h
        for _ in range(40):
            whole[2, 2] -= space.stress(whole)[2, 2] / space.moduli(whole)[2, 2, 2, 2]
        assert abs(space.stress(whole)[2, 2]) < 1e-13
        np.testing.assert_allclose(sheet.stress(h), space.stress(whole)[:2, :2], atol=1e-12)
        assert sheet.energy(h) == pytest.approx(space.energy(whole), rel=1e-11)


def test_an_incompressible_sheet_keeps_its_volume():
    """Uniaxial stress of an incompressible neo-Hookean sheet: P = shear (l - 1 / l^2)."""
    stretch = 1.7
    stress = (
        Material(3.0, 0.5, is_plane_stress=True)
        .law("neo-hookean")
        .stress(np.diag([stretch, stretch**-0.5]) - np.eye(2))
    )
    np.testing.assert_allclose(stress, np.diag([stretch - stretch**-2, 0.0]), atol=1e-14)


@every_law
@pytest.mark.parametrize("d", [2, 3])
def test_a_volume_turned_inside_out_is_not_admissible(law, d):
    h = np.zeros((3, d, d))
    h[:, 0, 0] = [-0.5, -1.0, -1.5]
    assert Material(2.0, 0.3).law(law).is_admissible(h).tolist() == [True, False, False]
    assert Material(2.0, 0.3, is_plane_stress=True).law(law).is_admissible(h[:, :2, :2]).tolist() == [
        True,
        False,
        False,
    ]


def test_a_sheet_stretched_to_no_thickness_is_not_admissible():
    sheet = Material(2.0, 0.3, is_plane_stress=True)
    assert not sheet.law("saint-venant-kirchhoff").is_admissible(np.eye(2))
    assert sheet.law("neo-hookean").is_admissible(np.eye(2))


def test_a_sheet_that_thickens_without_end_is_not_admissible():
    """At nu = -0.9 and a large compression no thickness is in equilibrium."""
    sheet = Material(2.0, -0.9, is_plane_stress=True).law("neo-hookean")
    assert sheet.is_admissible(0.01 * np.eye(2))
    assert not sheet.is_admissible(-0.9 * np.eye(2))


@pytest.mark.parametrize("d", [2, 3])
def test_a_small_volume_strain_does_not_drown(d):
    h = 1e-12 * strains(d)
    np.testing.assert_allclose(volume_strain(h), np.einsum("...ii", h), rtol=1e-9)
    h = strains(d)
    np.testing.assert_allclose(1 + volume_strain(h), np.linalg.det(np.eye(d) + h), rtol=1e-13)


def test_an_unknown_law_is_refused():
    with pytest.raises(UserError, match=r"law must be one of linear, .*Did you mean 'neo-hookean'"):
        Material(1.0, 0.3).law("neohookean")
