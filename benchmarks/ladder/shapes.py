"""Lattices and load cases that several families use."""

import numpy as np

import springopt as so


def hold(lattice, name):
    return so.side(lattice, name)


def pull(lattice, force, *, on="right", held="left"):
    """The same force on every node of one side, another side held."""
    forces = np.zeros(lattice.nodes.shape)
    forces[so.side(lattice, on)] = force
    return so.LoadCase("pull", so.side(lattice, held), forces)


def on_nodes(supported, forces, *, node_count, dimension=2, prescribed=None):
    """A load case from the numbers of the held nodes and {node: force}."""
    supports = np.zeros(node_count, dtype=bool)
    supports[list(supported)] = True
    total = np.zeros((node_count, dimension))
    for node, force in forces.items():
        total[node] = force
    return so.LoadCase("load", supports, total, prescribed)


def chain(count, *, direction=(1.0, 0.0)):
    """Nodes in a row, one length apart, each tied to the next."""
    nodes = np.arange(count)[:, None] * np.asarray(direction, dtype=float)
    return so.SpringLattice(nodes, [[i, i + 1] for i in range(count - 1)])


def prescribe(node_count, dimension, moves):
    """An array of prescribed displacements with nan where nothing is prescribed."""
    total = np.full((node_count, dimension), np.nan)
    for node, by in moves.items():
        total[node] = by
    return total
