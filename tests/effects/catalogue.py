"""Every effect with a potential, on lattices that it fits: what joins the list is tested."""

import numpy as np

import springopt as so


def body(shape, cell=None, seed=1):
    """A grid with nodes out of place, and every spring with another rest length, in tension."""
    grid, rng = so.SpringLattice.grid(shape, cell=cell), np.random.default_rng(seed)
    nodes = grid.nodes + 0.1 * rng.uniform(-1, 1, grid.nodes.shape)
    lengths = np.linalg.norm(nodes[grid.springs[:, 1]] - nodes[grid.springs[:, 0]], axis=1)
    rest = lengths * rng.uniform(0.9, 1.0, grid.spring_count)
    return so.SpringLattice(nodes, grid.springs, rest, grid.cells, grid.cell_type)


SHAPES = {2: (4, 3), 3: (3, 3, 2)}
BODIES = {
    "2D": body((4, 3)),
    "2D, triangles": body((4, 3), "triangle"),
    "3D": body((3, 3, 2)),
    "3D, tetrahedra": body((3, 2, 2), "tetra"),
}


def bent(lattice):
    """Some triples, in line or not."""
    rng = np.random.default_rng(2)
    return [rng.choice(lattice.node_count, 3, replace=False).tolist() for _ in range(12)]


#: name -> (the effect for a lattice, which of its parameters are fitted)
POTENTIALS = {
    "stiffening": (lambda body: so.Stiffening(quadratic=0.7, cubic=2.0), ()),
    "exponential": (lambda body: so.ExponentialStiffening(3.0), ()),
    "tension-only": (lambda body: so.TensionOnly(), ()),
    "prestress": (lambda body: so.Prestress(scale=0.9), ("scale",)),
    "prestress of each": (lambda body: so.Prestress(scale=np.linspace(0.8, 1.1, body.spring_count)), ("scale",)),
    "prestress of classes": (
        lambda body: so.Prestress(classes={"boundary straight": 0.9, "diagonal": 0.95}),
        ("scale",),
    ),
    "volume": (lambda body: so.Volume(3.0), ()),
    "volume of each": (lambda body: so.Volume(np.linspace(1.0, 5.0, len(body.cells))), ()),
    "bending": (lambda body: so.Bending(2.0, triples=bent(body)), ()),
    "bending of each": (lambda body: so.Bending(np.linspace(1.0, 2.0, 12), triples=bent(body)), ()),
    "plane": (lambda body: so.PlaneContact(5.0, body.nodes.mean(axis=0), np.arange(1.0, 1 + body.dimension)), ()),
    "sphere": (lambda body: so.SphereContact(5.0, body.nodes[4] + 0.2, 1.0), ()),
    "inside a sphere": (lambda body: so.SphereContact(5.0, body.nodes[4] + 0.2, 1.0, inside=True), ()),
}
