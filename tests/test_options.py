from dataclasses import dataclass
from typing import Literal

import pytest

from springopt.errors import PluginError, UserError
from springopt.optimizer import Optimizer
from springopt.options import make_optimizer, options_of


@dataclass(frozen=True)
class Tunable(Optimizer):
    """Has an option of every type."""

    name = "tunable"
    count: int = 3  #: how many
    #: how fast, in a sentence that
    #: goes over two lines
    rate: float = 0.5
    strict: bool = False
    label: str = "a"  #: what it says
    choice: Literal["cut", "clip", 2] = "cut"  #: which of them
    limit: float | None = None  #: none for no limit
    widths: tuple[float, ...] = (1.0, 2.0)  #: one for each

    def minimize(self, problem, rng):
        pass


@dataclass(frozen=True)
class Inheriting(Tunable):
    name = "inheriting"
    count: int = 4  #: how many, told otherwise


def explanations(optimizer):
    return {option.name: option.explanation for option in options_of(optimizer)}


def test_the_explanation_of_an_option_stands_behind_it_or_above_it():
    assert explanations(Tunable) == {
        "count": "how many",
        "rate": "how fast, in a sentence that goes over two lines",
        "strict": "",
        "label": "what it says",
        "choice": "which of them",
        "limit": "none for no limit",
        "widths": "one for each",
    }


def test_options_are_inherited_with_their_explanations():
    assert explanations(Inheriting) == explanations(Tunable) | {"count": "how many, told otherwise"}
    assert make_optimizer(Inheriting).count == 4


def test_types_are_told_in_the_users_words():
    assert [option.type_name for option in options_of(Tunable)] == [
        "a whole number",
        "a number",
        "true or false",
        "text",
        "'cut' or 'clip' or 2",
        "a number or none",
        "a list, each a number",
    ]


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("count", 7, 7),
        ("count", "7", 7),
        ("rate", 1, 1.0),
        ("rate", "1e-3", 1e-3),
        ("strict", "True", True),
        ("strict", False, False),
        ("label", "7", "7"),
        ("choice", "clip", "clip"),
        ("choice", "2", 2),
        ("limit", "none", None),
        ("limit", None, None),
        ("limit", "2", 2.0),
        ("widths", [1, 2.5], (1.0, 2.5)),
        ("widths", "1,2.5", (1.0, 2.5)),
    ],
)
def test_a_value_and_its_text_are_read_by_the_type(name, given, wanted):
    value = getattr(make_optimizer(Tunable, {name: given}), name)
    assert value == wanted
    assert type(value) is type(wanted)


@pytest.mark.parametrize(
    ("name", "given", "sentence"),
    [
        ("count", 2.0, "option count of tunable is a whole number, not 2.0"),
        ("count", True, "option count of tunable is a whole number, not True"),
        ("count", "many", "option count of tunable is a whole number, not 'many'"),
        ("rate", "nan", "option rate of tunable is a number, not 'nan'"),
        ("rate", False, "option rate of tunable is a number, not False"),
        ("rate", [1.0], r"option rate of tunable is a number, not \[1.0\]"),
        ("strict", 1, "option strict of tunable is true or false, not 1"),
        ("label", 7, "option label of tunable is text, not 7"),
        ("choice", "cot", "option choice of tunable is 'cut' or 'clip' or 2, not 'cot'"),
        ("choice", 2.0, "not 2.0"),
        ("limit", "soon", "option limit of tunable is a number or none, not 'soon'"),
        ("widths", 3, "option widths of tunable is a list, each a number, not 3"),
        ("widths", ["x"], "option widths of tunable is a list, each a number"),
        ("cuont", 3, "tunable has no option 'cuont'; it has count, .* Did you mean 'count'"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_sentence(name, given, sentence):
    with pytest.raises(UserError, match=sentence):
        make_optimizer(Tunable, {name: given})


def test_an_option_without_a_default_is_the_plugin_authors_mistake():
    @dataclass(frozen=True)
    class Bare(Optimizer):
        count: int
        name = "bare"

        def minimize(self, problem, rng):
            pass

    with pytest.raises(PluginError, match="option count of optimizer bare has no default"):
        options_of(Bare)


@pytest.mark.parametrize("annotation", [dict, list[int], tuple[int, int]])
def test_an_option_of_another_type_is_the_plugin_authors_mistake(annotation):
    @dataclass(frozen=True)
    class Odd(Optimizer):
        name = "odd"
        table: annotation = None

        def minimize(self, problem, rng):
            pass

    with pytest.raises(PluginError, match="an option can't have the type"):
        make_optimizer(Odd, {"table": "x"})
