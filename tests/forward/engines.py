"""The scenes on which engines must agree, and how to ask for one."""

from dataclasses import replace

import numpy as np

import springopt as so
from springopt.forward.batch import find
from springopt.forward.linear import LinearEngine
from springopt.forward.sparse import SparseEngine
from springopt.forward.superlu import SuperLUSolver

#: What is compared with lanes; superlu is what the sparse engine takes where a band would be too wide.
ENGINES = ("sparse", "superlu", "iterative")


def equilibria(model, engine, stiffness, cases, tolerance=1e-8):
    """The answers of one engine for candidates (m, s)."""
    asked = "sparse" if engine == "superlu" else engine
    groups = so.Model(model.lattice, model.effects, engine=asked).groups(cases)
    if engine == "superlu" and groups[0].choice.unknowns:
        groups = [replace(group, engine=SparseEngine(group.plan, SuperLUSolver(group.plan))) for group in groups]
    return find(groups, np.atleast_2d(stiffness), tolerance=tolerance)


def small_displacements(model, solver, stiffness, cases):
    """The answers for small displacements with one solver, for candidates (m, s)."""
    asked = "iterative" if solver == "iterative" else "sparse"
    groups = so.Model(model.lattice, model.effects, kinematics="linear", engine=asked).groups(cases)
    if solver == "superlu":
        engines = [LinearEngine(g.plan, g.engine.whole, SuperLUSolver(g.plan)) for g in groups]
        groups = [replace(group, engine=engine) for group, engine in zip(groups, engines, strict=True)]
    return find(groups, np.atleast_2d(stiffness), tolerance=1e-8)


def load(lattice, hold="left", on="right", force=None, supports=None, prescribed=None, name="load"):
    forces = np.zeros(lattice.nodes.shape)
    if force is not None:
        forces[so.side(lattice, on)] = force
    return so.LoadCase(name, so.side(lattice, hold) if supports is None else supports, forces, prescribed)


def _rollers(lattice):
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    supports[so.side(lattice, "left"), 0] = True
    supports[0] = True
    supports[so.side(lattice, "left") & so.side(lattice, "bottom"), -1] = True
    return load(lattice, supports=supports, force=np.linspace(0.2, 0.05, lattice.dimension))


def _moved(lattice):
    supports = so.side(lattice, "left") | so.side(lattice, "right")
    prescribed = np.where(so.side(lattice, "right")[:, None], np.linspace(0.3, 0.1, lattice.dimension), 0.0)
    return load(lattice, supports=supports, prescribed=prescribed)


def _on_a_plane(lattice):
    return so.Model(lattice, so.PlaneContact(50.0, np.full(lattice.dimension, -0.1), np.eye(lattice.dimension)[-1]))


def _in_a_sphere(lattice):
    center = lattice.nodes.mean(axis=0)
    radius = np.linalg.norm(lattice.nodes - center, axis=1).max()
    return so.Model(lattice, so.SphereContact(50.0, center, radius + 0.05, inside=True))


def scenes():
    """name -> (model, stiffness (s,), load cases)."""
    from ground_springs import GroundSprings

    flat, solid = so.SpringLattice.grid((6, 5)), so.SpringLattice.grid((4, 3, 4))
    tense = so.SpringLattice(flat.nodes, flat.springs, 0.9 * flat.rest_lengths)
    rng = np.random.default_rng(11)
    k = {id(lattice): rng.uniform(0.5, 10, lattice.spring_count) for lattice in (flat, solid, tense)}
    removed = k[id(solid)] * (rng.random(solid.spring_count) > 0.1)
    return {
        "2D": (so.Model(flat), k[id(flat)], [load(flat, force=(0.3, -0.2)), load(flat, "top", "bottom", (0.4, 0.1))]),
        "3D": (so.Model(solid), k[id(solid)], [load(solid, force=(0.3, 0.2, -0.1)), load(solid, force=(-0.5, 0.1, 0))]),
        "3D, springs removed": (so.Model(solid), removed, [load(solid, force=(0.3, 0.2, -0.1))]),
        "gravity": (so.Model(solid, [so.Gravity((0, 0, -0.1))]), k[id(solid)], [load(solid)]),
        "rollers": (so.Model(flat), k[id(flat)], [_rollers(flat)]),
        "rollers in 3D": (so.Model(solid), k[id(solid)], [_rollers(solid)]),
        "moved supports": (so.Model(solid), k[id(solid)], [_moved(solid)]),
        "prestress": (so.Model(tense), k[id(tense)], [load(tense), load(tense, force=(0.2, 0.1))]),
        "a stranger's effect": (so.Model(flat, [GroundSprings(2.0)]), k[id(flat)], [load(flat, force=(0.5, 0.3))]),
        "stiffening": (so.Model(flat, so.Stiffening(1.0, 5.0)), k[id(flat)], [load(flat, force=(0.5, 0.3))]),
        "exponential": (
            so.Model(solid, so.ExponentialStiffening(4.0)),
            k[id(solid)],
            [load(solid, force=(0.3, 0, 0.2))],
        ),
        "tension only": (so.Model(tense, so.TensionOnly()), k[id(tense)], [load(tense, force=(0.3, 0.1))]),
        "prestress by class": (so.Model(flat, so.Prestress(classes={"diagonal": 0.9})), k[id(flat)], [load(flat)]),
        "volume": (so.Model(solid, so.Volume(20.0)), k[id(solid)], [load(solid, force=(0.3, 0.2, -0.1))]),
        "volume in 2D": (so.Model(flat, so.Volume(20.0)), k[id(flat)], [load(flat, force=(0.3, 0.2))]),
        "stiff volume": (so.Model(solid, so.Volume(1e4)), k[id(solid)], [load(solid, force=(0.3, 0.2, -0.1))]),
        "bending": (so.Model(solid, so.Bending(5.0)), k[id(solid)], [load(solid, force=(0.3, 0.2, -0.1))]),
        "bending in 2D": (so.Model(flat, so.Bending(5.0)), k[id(flat)], [load(flat, force=(0.5, 0.3))]),
        "on a plane": (_on_a_plane(flat), k[id(flat)], [load(flat, force=(0.1, -0.2))]),
        "in a sphere": (_in_a_sphere(solid), k[id(solid)], [load(solid, force=(0.4, 0.2, 0.1))]),
        "everything held": (so.Model(flat), k[id(flat)], [load(flat, supports=np.ones(flat.node_count, dtype=bool))]),
    }


SCENES = scenes()
