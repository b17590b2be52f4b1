"""The best value, generation by generation."""

from springopt.reproduction.curves import best_values
from springopt.run import Improvement


def history(*steps: tuple[int, float]) -> list[Improvement]:
    return [Improvement(evaluations, evaluations, 0.0, 0.0, value) for evaluations, value in steps]


def test_a_generation_has_the_best_value_of_all_until_its_end() -> None:
    runs = [history((1, 9.0), (7, 4.0), (10, 3.0)), history((2, 8.0), (16, 1.0))]
    assert best_values(runs, population=5, generations=4).tolist() == [[9.0, 3.0, 3.0, 3.0], [8.0, 8.0, 8.0, 1.0]]
