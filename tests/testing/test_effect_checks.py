"""The checks that authors of effects import find what they are for: each rogue here fails the one check of its kind."""

import ctypes
from dataclasses import dataclass
from itertools import count
from typing import Any, NamedTuple

import numpy as np
import pytest

from springopt.effects.effect import Effect, Kernel
from springopt.effects.gravity import Gravity
from springopt.lattice import SpringLattice
from springopt.testing import NotJudged, check_effect, examine_effect

POINTER, INTEGERS = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int64)
C_KERNEL = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, ctypes.c_int64, POINTER, INTEGERS, *[POINTER] * 3, INTEGERS, *[POINTER] * 5
)
SQUARE = SpringLattice.grid((2, 2))


class Lanes(NamedTuple):
    """What a kernel finds, eight lanes last."""

    lattice: SpringLattice
    stiffness: Any  # (s, 8)
    pull: Any  # (8,)
    places: Any  # (q,)
    tangent: Any  # (rows, 8)
    u: Any  # (n, d, 8), as the next two
    v: Any
    f: Any
    e: Any  # (8,)


class Callback:
    """A kernel that calls a function of `Lanes` back: slow, and nothing is compiled."""

    def __init__(self, function, lattice, count):
        def rows(pointer, size):
            return np.ctypeslib.as_array(pointer, (size, 8))

        def call(d, n, nodes, integers, numbers, stiffness, values, places, *arrays):
            (u, v, f), (k, e) = (rows(array, n * d).reshape(n, d, 8) for array in arrays[:3]), arrays[3:]
            places = np.ctypeslib.as_array(places, (count,))
            tangent = rows(k, max(places.max() >> 1, 0) + d * d)
            with np.errstate(all="ignore"):
                own = rows(stiffness, lattice.spring_count), rows(values, 1)[0]
                function(Lanes(lattice, *own, places, tangent, u, v, f, rows(e, 1)[0]))

        self.kept = C_KERNEL(call)

    @property
    def address(self):
        return ctypes.cast(self.kept, ctypes.c_void_p).value


@dataclass(frozen=True)
class Web(Effect):
    """A sound effect that brings a potential, a dissipation and masses. The rogues change it.

    Between the nodes of each spring the energy pull * r^4 / 4, and a dashpot that grows with r.
    """

    name = "web"
    pull: float = 2.0  #: [force / length^3]

    def parameters(self, lattice):
        return {"pull": np.array([self.pull])}

    def potential(self, lattice, fitted=frozenset()):
        return self.kernel(self.add, lattice)

    def dissipation(self, lattice):
        return self.kernel(self.damp, lattice)

    def masses(self, lattice, values):
        return values["pull"] * np.ones(lattice.node_count)

    def kernel(self, add, lattice):
        own = np.arange(lattice.node_count)[:, None].repeat(2, axis=1)
        pairs = np.concatenate([lattice.springs, own])
        return Kernel(Callback(add, lattice, len(pairs)), pairs, is_compiled=False)

    def law(self, x, r):
        """Energy, force over r, and what a block has along the spring, over r^2."""
        return x.pull * r**4 / 4, x.pull * r**2, 2 * x.pull

    def add(self, x):
        i, j = x.lattice.springs.T
        positions = x.lattice.nodes[:, :, None] + x.u
        along = positions[j] - positions[i]
        energy, pull, axial = self.law(x, np.linalg.norm(along, axis=1))
        x.e[:] += energy.sum(axis=0)
        self.add_forces(x, pull[:, None] * along)
        outer = along[:, :, None] * along[:, None]
        self.add_blocks(x, axial * outer + pull[:, None, None] * np.eye(along.shape[1])[None, :, :, None])

    def damp(self, x):
        i, j = x.lattice.springs.T
        positions = x.lattice.nodes[:, :, None] + x.u
        along = positions[j] - positions[i]
        speed = np.sum(along * (x.v[j] - x.v[i]), axis=1)
        x.e[:] += np.sum(speed**2, axis=0)
        self.add_forces(x, speed[:, None] * along)
        self.add_blocks(x, along[:, :, None] * along[:, None])

    def add_forces(self, x, pulls):
        i, j = x.lattice.springs.T
        np.add.at(x.f, j, pulls)
        np.subtract.at(x.f, i, pulls)

    def add_blocks(self, x, blocks):
        """Of the springs' second nodes by themselves, shape (s, d, d, 8)."""
        own = np.zeros((x.lattice.node_count, *blocks.shape[1:]))
        for ends in x.lattice.springs.T:
            np.add.at(own, ends, blocks)
        for place, block in zip(x.places, np.concatenate([-blocks, own]), strict=True):
            self.add_block(x, place, block)

    def add_block(self, x, place, block):
        if place >= 0:
            turned = block.swapaxes(0, 1) if place & 1 else block
            x.tangent[place >> 1 : (place >> 1) + turned[..., 0].size] += turned.reshape(-1, 8)


# Rogues against the declaration.


@dataclass(frozen=True)
class Mute(Web):
    factor: float = 1.0
    """Not the place for an explanation."""


@dataclass(frozen=True)
class Crashing(Web):
    def potential(self, lattice, fitted=frozenset()):
        raise ZeroDivisionError("no cell has a volume")


@dataclass(frozen=True)
class Whole(Web):
    def parameters(self, lattice):
        return {"pull": np.array([2])}


@dataclass(frozen=True)
class Dicing(Web):
    def masses(self, lattice, values):
        return super().masses(lattice, values) * (1 + next(dice) * 1e-15)


@dataclass(frozen=True)
class Homebound(Web):
    def __reduce__(self):
        raise TypeError("it holds an open file")


# Rogues that bring what does not fit.


@dataclass(frozen=True)
class Flat(Web):
    def constant_forces(self, lattice, fitted=frozenset()):
        return None if fitted else np.zeros(lattice.nodes.size)


@dataclass(frozen=True)
class Shrinking(Web):
    def rest_lengths(self, lattice, fitted=frozenset()):
        return None if fitted else -lattice.rest_lengths


@dataclass(frozen=True)
class Heavy(Web):
    def masses(self, lattice, values):
        return super().masses(lattice, values) ** 2


@dataclass(frozen=True)
class Absent(Effect):
    name = "absent"


# Rogues against their places.


@dataclass(frozen=True)
class Storing(Web):
    def add_forces(self, x, pulls):
        x.f[:] = 0.0
        super().add_forces(x, pulls)


@dataclass(frozen=True)
class Stray(Web):
    def add(self, x):
        super().add(x)
        x.u[:] += 1e-9


@dataclass(frozen=True)
class Upright(Web):
    def add_block(self, x, place, block):
        if not place & 1:
            super().add_block(x, place, block)


@dataclass(frozen=True)
class Keeping(Web):
    def add_block(self, x, place, block):
        super().add_block(x, max(place, 0), block)


# Rogues whose numbers are wrong.


@dataclass(frozen=True)
class Gossiping(Web):
    def add(self, x):
        super().add(x)
        x.e[:] += 1e-12 * np.roll(x.e, 1)


@dataclass(frozen=True)
class Collapsing(Web):
    def law(self, x, r):
        energy, pull, axial = super().law(x, r)
        return energy * r / r, pull, axial


@dataclass(frozen=True)
class Wasteful(Web):
    def law(self, x, r):
        energy, pull, axial = super().law(x, r)
        return 1.01 * energy, pull, axial


@dataclass(frozen=True)
class Softened(Web):
    def law(self, x, r):
        energy, pull, axial = super().law(x, r)
        return energy, pull, 0.99 * axial


@dataclass(frozen=True)
class Slack(Web):
    """Pulls alone, and says that small displacements may take its expansion at rest."""

    def law(self, x, r):
        r, rest = np.maximum(r, 1e-9), x.lattice.rest_lengths[:, None]
        longer = np.maximum(r - rest, 0.0)
        pull = x.pull * longer / r
        return x.pull * longer**2 / 2, pull, ((x.pull * (longer > 0) - pull) / r**2)[:, None, None]


@dataclass(frozen=True)
class Stiffened(Web):
    def law(self, x, r):
        energy, pull, axial = super().law(x, r)
        k = x.stiffness
        return k * energy, k * pull, (k * axial)[:, None, None]


@dataclass(frozen=True)
class Lawless(Web):
    scales_with_stiffness = True


@dataclass(frozen=True)
class Lawful(Stiffened):
    """Sound: a law of the springs."""

    scales_with_stiffness = True


@dataclass(frozen=True)
class Curved(Web):
    def law(self, x, r):
        return super().law(x._replace(pull=x.pull**2), r)


@dataclass(frozen=True)
class Untold(Curved):
    is_affine = False


@dataclass(frozen=True)
class Twice(Web):
    def potential(self, lattice, fitted=frozenset()):
        add = (lambda x: [self.add(x), self.add(x)]) if fitted else self.add
        return self.kernel(add, lattice)


@dataclass(frozen=True)
class Anchored(Web):
    def add(self, x):
        super().add(x)
        x.e[:] += x.pull * np.sum(x.u**2, axis=(0, 1)) / 2
        x.f[:] += x.pull * x.u
        for place in x.places[len(x.lattice.springs) :]:
            self.add_block(x, place, np.eye(x.u.shape[1])[:, :, None] * x.pull)


@dataclass(frozen=True)
class Spinning(Web):
    """Takes another direction for its dashpots than that of the spring."""

    def damp(self, x):
        i, j = x.lattice.springs.T
        speed = x.v[j] - x.v[i]
        x.e[:] += np.sum(speed**2, axis=(0, 1))
        self.add_forces(x, speed)
        self.add_blocks(
            x, np.broadcast_to(np.eye(speed.shape[1])[None, :, :, None], (len(i), *[speed.shape[1]] * 2, 8))
        )


# Rogues that dissipate.


@dataclass(frozen=True)
class Perpetual(Web):
    def damp(self, x):
        negative = x._replace(**{name: np.zeros_like(getattr(x, name)) for name in ("e", "f", "tangent")})
        super().damp(negative)
        for name in ("e", "f", "tangent"):
            getattr(x, name)[:] -= getattr(negative, name)


@dataclass(frozen=True)
class Doubled(Web):
    def damp(self, x):
        before = x.e.copy()
        super().damp(x)
        x.e[:] += x.e - before


@dataclass(frozen=True)
class Drifting(Web):
    def damp(self, x):
        before = x.tangent.copy()
        super().damp(x)
        x.tangent[:] = before + 0.99 * (x.tangent - before)


dice = count()


@pytest.mark.parametrize(
    "sound",
    [Web, Web(3.0), Lawful(), Gravity((0.0, -9.81)), Gravity((0.0, 1.0, 2.0), density=3.0)],
    ids=lambda sound: repr(sound)[:40],
)
def test_a_sound_effect_passes(sound):
    check_effect(sound)


@pytest.mark.parametrize(
    ("rogue", "check", "sentence"),
    [
        (Mute, "options are documented", "option factor of web has no explanation; put one behind #:."),
        (Crashing, "runs or refuses in a sentence", "(ZeroDivisionError: no cell has a volume); mend it, or refuse"),
        (Whole, "parameters are rows of numbers", "parameter 'pull' of web on the lattice that was given should be"),
        (Dicing, "says the same twice", "let what it brings depend on its options and the lattice alone."),
        (Homebound, "travels to other processes", "web can't be sent to workers (TypeError: it holds an open file)"),
        (Flat, "constant forces fit the nodes", "should be an array of finite numbers of shape (4, 2), but came as"),
        (Shrinking, "rest lengths fit the springs", "should not be negative; refuse what makes them so."),
        (Heavy, "masses are linear in the parameters", "should be linear in the parameters"),
        (Absent, "acts", "absent brings nothing to the lattice that was given; override a method."),
        (Storing, "keeps to its places", "does not add to what is there; use `add` and `add_to_block`"),
        (Stray, "keeps to its places", "writes to the displacements, which it may only read; keep to the pairs"),
        (Upright, "keeps to its places", "-1 drops a block, an odd place transposes it; let `add_to_block` do that."),
        (Keeping, "keeps to its places", "-1 drops a block, an odd place transposes it; let `add_to_block` do that."),
        (Gossiping, "lanes are independent", "answers otherwise beside other states; let every lane do the same"),
        (Collapsing, "is finite everywhere", "is not finite where all nodes are at one place; guard its quotients"),
        (Wasteful, "forces are the energys derivatives", "forces that are not the derivatives of its energy, by 0.0"),
        (Softened, "blocks are the forces derivatives", "blocks that are not the derivatives of its forces by the dis"),
        (Slack, "expands at rest as claimed", "its forces have a kink; say has_expansion_at_rest = False."),
        (Stiffened, "depends on the stiffness as claimed", "say scales_with_stiffness = True if it is a law of theirs"),
        (Lawless, "depends on the stiffness as claimed", "say scales_with_stiffness = False, or make it so."),
        (Curved, "derivatives by parameters", "it is not affine in them: say is_affine = False and override `force_d"),
        (Untold, "derivatives by parameters", "gives no derivatives by them; override `force_derivatives`."),
        (Twice, "fitting changes no force", "comes to other forces where pull is fitted; what is a constant force"),
        (Anchored, "rigid motions cost nothing", "has a net force, so that moving the body costs energy; say is_trans"),
        (Spinning, "rigid motions cost nothing", "say is_rotation_invariant = False"),
        (Perpetual, "dissipation takes power", "gives power, or acts where nothing moves; its forces act against"),
        (Doubled, "dissipation takes power", "adds another power than that of its forces; add velocity times force"),
        (
            Drifting,
            "dissipation blocks are derivatives",
            "blocks that are not the derivatives of its forces by the vel",
        ),
    ],
    ids=lambda value: value.__name__ if isinstance(value, type) else None,
)
def test_a_rogue_is_caught_by_the_one_check_of_its_kind_and_told_what_to_mend(rogue, check, sentence):
    failed = {
        finding.check: finding.sentence for finding in examine_effect(rogue, SQUARE) if finding.verdict == "failed"
    }
    assert list(failed) == [check]
    assert sentence in failed[check]


def test_what_another_fault_hides_is_not_judged():
    verdicts = {finding.check: finding for finding in examine_effect(Stray, SQUARE)}
    assert verdicts["options are documented"].verdict == "passed"
    assert verdicts["lanes are independent"].verdict == "not judged"
    assert "has another fault (writes to the displacements" in verdicts["lanes are independent"].sentence


def test_one_that_does_nothing_where_it_is_asked_is_not_judged():
    with pytest.raises(NotJudged, match="is zero in all states here; give check_effect options or a lattice where it"):
        check_effect(Web(0.0), SQUARE)


def test_one_that_fits_no_lattice_is_told_why():
    with pytest.raises(
        NotJudged, match=r"give check_effect one that it fits\. acceleration must have the shape \(2,\)"
    ):
        check_effect(Gravity((1.0,)))


def test_a_class_without_defaults_must_be_made_first():
    with pytest.raises(NotJudged, match="Gravity can't be made with its defaults"):
        check_effect(Gravity)
