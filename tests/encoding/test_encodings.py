"""What every encoding promises, and what each one means."""

import numpy as np
import pytest

from springopt.encoding import ENCODINGS, Binary, Encoding, Grouped, Homogeneous, Real, ThreeClass, TwoClass
from springopt.errors import UserError
from springopt.lattice import SpringLattice

LATTICE = SpringLattice.grid((5, 5))
STIFFNESS = np.linspace(1.0, 8.0, LATTICE.spring_count)


def _encodings() -> list[Encoding]:
    return [
        Binary(LATTICE, stiffness=STIFFNESS),
        Real(LATTICE, lower=0.0, upper=10.0, threshold=0.5),
        Homogeneous(LATTICE),
        TwoClass(LATTICE, lower=1.0, upper=6.0),
        ThreeClass(LATTICE),
    ]


every_encoding = pytest.mark.parametrize("encoding", _encodings(), ids=lambda encoding: encoding.name)


def test_every_encoding_is_listed_and_none_is_untested() -> None:
    assert [encoding.name for encoding in _encodings()] == list(ENCODINGS)


@every_encoding
def test_samples_fill_the_box_and_stay_inside(encoding: Encoding) -> None:
    points = encoding.sample(np.random.default_rng(0), 200)
    assert points.shape == (200, encoding.size)
    assert (points >= encoding.lower).all()
    assert (points <= encoding.upper).all()
    middle = (encoding.lower + encoding.upper) / 2
    assert np.allclose(points.mean(axis=0), middle, atol=0.15 * (encoding.upper - encoding.lower))


@every_encoding
def test_stiffness_of_a_batch_is_that_of_its_points(encoding: Encoding) -> None:
    points = encoding.sample(np.random.default_rng(1), 7)
    stiffness = encoding.decode(points)
    assert stiffness.shape == (7, LATTICE.spring_count)
    assert np.array_equal(stiffness, [encoding.decode(point) for point in points])


@every_encoding
def test_pull_back_is_the_transposed_derivative_of_decode(encoding: Encoding) -> None:
    rng = np.random.default_rng(2)
    point = np.where(encoding.kind == "binary", 1.0, encoding.sample(rng, 1)[0])
    columns = np.eye(encoding.size) * 1e-3
    if encoding.kind == "binary":
        jacobian = encoding.stiffness * np.eye(encoding.size)  # type: ignore[attr-defined]
    else:
        jacobian = (encoding.decode(point + columns) - encoding.decode(point - columns)).T / 2e-3
    gradient = rng.normal(size=(3, LATTICE.spring_count))
    assert np.allclose(encoding.pull_back(point, gradient), gradient @ jacobian, atol=1e-9)
    assert np.allclose(encoding.pull_back(point, gradient[0]), gradient[0] @ jacobian, atol=1e-9)


@every_encoding
def test_encode_finds_a_point_again_and_otherwise_the_closest_of_the_box(encoding: Encoding) -> None:
    rng = np.random.default_rng(3)
    point, wanted = encoding.sample(rng, 1)[0], rng.uniform(-4.0, 14.0, LATTICE.spring_count)
    assert np.allclose(encoding.encode(encoding.decode(point)), point, atol=1e-12)
    closest = encoding.encode(wanted)
    others = np.concatenate([encoding.sample(rng, 50), _neighbours(encoding, closest)])
    assert (
        np.square(encoding.decode(closest) - wanted).sum() <= np.square(encoding.decode(others) - wanted).sum(1).min()
    )


def _neighbours(encoding: Encoding, point: np.ndarray) -> np.ndarray:
    """Points that differ in one number: by a little, or in its bit."""
    if encoding.kind == "binary":
        return np.abs(point - np.eye(encoding.size))
    steps = 1e-3 * np.concatenate([np.eye(encoding.size), -np.eye(encoding.size)])
    return np.clip(point + steps, encoding.lower, encoding.upper)


@every_encoding
def test_points_of_another_size_are_refused_in_one_sentence(encoding: Encoding) -> None:
    with pytest.raises(UserError, match=rf"points of the {encoding.name} encoding have shape"):
        encoding.decode(np.zeros(encoding.size + 1))


def test_bits_switch_springs_on_at_their_stiffness() -> None:
    encoding = Binary(LATTICE, stiffness=STIFFNESS)
    bits = np.zeros(72)
    bits[[3, 70]] = 1
    stiffness = encoding.decode(bits)
    assert np.flatnonzero(stiffness).tolist() == [3, 70]
    assert stiffness[70] == STIFFNESS[70]


def test_a_bit_is_zero_or_one() -> None:
    with pytest.raises(UserError, match="zeros and ones"):
        Binary(LATTICE).decode(np.full(72, 0.5))


def test_a_number_up_to_the_threshold_is_reported_as_an_absent_spring() -> None:
    encoding = Real(LATTICE, lower=0.0, upper=10.0, threshold=0.5)
    numbers = np.full(72, 4.0)
    numbers[:3] = 0.0, 0.5, np.nextafter(0.5, 1.0)
    assert encoding.present(numbers)[:4].tolist() == [False, False, True, True]
    assert encoding.decode(numbers)[:4].tolist() == [0.0, 0.5, numbers[2], 4.0]


def test_classes_of_the_paper_s_grid_have_their_known_sizes() -> None:
    counts = {name: row["springs"] for name, row in ThreeClass(LATTICE).describe([7.6, 3.3, 3.7]).items()}
    assert counts == {"inner straight": 24, "boundary straight": 16, "diagonal": 32}


def test_a_class_shares_its_stiffness() -> None:
    stiffness = TwoClass(LATTICE).decode([4.8, 3.3])
    assert np.unique(stiffness[LATTICE.straight]).tolist() == [4.8]
    assert np.unique(stiffness[~LATTICE.straight]).tolist() == [3.3]


def test_describe_counts_present_springs_and_averages_them_alone() -> None:
    numbers = np.where(LATTICE.straight, 6.0, 2.0)
    numbers[np.flatnonzero(LATTICE.straight)[0]] = 0.1
    rows = Real(LATTICE, lower=0.0, upper=10.0, threshold=0.5).describe(numbers)
    assert list(rows) == ["all springs", "inner straight", "boundary straight", "diagonal"]
    assert rows["all springs"]["present"] == 71
    assert rows["boundary straight"] == {"springs": 16, "present": 15, "mean": 6.0, "spread": 0.0}
    assert rows["diagonal"]["mean"] == pytest.approx(2.0)


def test_describe_of_no_springs_is_zero_and_not_nan() -> None:
    assert Binary(LATTICE).describe(np.zeros(72))["all springs"]["mean"] == 0.0


def test_a_lattice_without_cells_is_described_by_direction() -> None:
    bare = SpringLattice(LATTICE.nodes, LATTICE.springs)
    assert list(Real(bare).describe(np.ones(72))) == ["all springs", "straight", "diagonal"]


@pytest.mark.parametrize("name", ENCODINGS)
def test_a_lattice_without_springs_is_refused(name: str) -> None:
    bare = SpringLattice(LATTICE.nodes, [], cells=LATTICE.cells, cell_type=LATTICE.cell_type)  # type: ignore[arg-type]
    with pytest.raises(UserError, match=f"the {name} encoding needs springs, but this lattice has none; give it"):
        ENCODINGS[name](bare)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Real(LATTICE, lower=3.0, upper=3.0), "0 <= lower < upper"),
        (lambda: Real(LATTICE, lower=-1.0, upper=3.0), "0 <= lower < upper"),
        (lambda: Real(LATTICE, upper=np.inf), "finite"),
        (lambda: Real(LATTICE, upper=np.nan), "bounds of unknown 0 are"),
        (lambda: Real(LATTICE, upper=[1.0, 2.0]), r"must have the shape \(72,\)"),
        (lambda: Real(LATTICE, upper=5.0, threshold=5.0), "threshold"),
        (lambda: Real(LATTICE, upper=5.0, threshold=np.nan), "threshold"),
        (lambda: Binary(LATTICE, stiffness=0.0), r"stiffness\[0\] is 0, but it must be positive"),
        (lambda: Binary(LATTICE, stiffness=[1.0]), r"must have the shape \(72,\)"),
        (lambda: TwoClass(SpringLattice.grid((3, 3), neighbourhood="von-neumann")), "no diagonal springs"),
        (lambda: Grouped({}), "the grouped encoding needs springs"),
        (lambda: Grouped({"a": LATTICE.straight}), "every spring in exactly one class"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(make, sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        make()
