import dataclasses
from importlib.metadata import EntryPoint

import pytest

from springopt import registry
from springopt.effects.effect import Effect
from springopt.effects.gravity import Gravity
from springopt.errors import PluginError
from springopt.optimizer import Optimizer
from springopt.random_search import RandomSearch
from springopt.registry import distribution_of, effects, load_effect, load_optimizer, optimizers


def entry(name, value, distribution="springopt-strange"):
    """An entry point of a distribution that is not installed."""
    dist = type("Distribution", (), {"name": distribution})()
    point = EntryPoint(name=name, value=value, group=registry.GROUP)
    vars(point)["dist"] = dist
    return point


@pytest.fixture
def install(monkeypatch):
    def install(*entries):
        monkeypatch.setattr(registry, "entry_points", lambda group: entries)

    return install


RANDOM = entry("random-search", "springopt.random_search:RandomSearch", "springopt")


def test_the_core_brings_random_search_by_an_entry_point_of_its_own():
    assert optimizers()["random-search"] is RandomSearch
    assert load_optimizer("random-search") is RandomSearch


def test_an_unknown_name_is_refused_with_a_hint():
    with pytest.raises(PluginError, match=r"no optimizer 'random-serch'; installed: .*Did you mean 'random-search'"):
        load_optimizer("random-serch")


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("springopt_gone:Optimizer", "can't be loaded .ModuleNotFoundError"),
        ("springopt.random_search:Gone", "can't be loaded .AttributeError"),
        ("springopt.errors:UserError", "is no Optimizer with the name 'strange'"),
        ("springopt.random_search:RandomSearch", "is no Optimizer with the name 'strange'"),
    ],
)
def test_a_broken_plugin_is_left_out_with_a_warning_that_names_its_distribution(install, value, why):
    install(RANDOM, entry("strange", value))
    with pytest.warns(RuntimeWarning, match=rf"of springopt-strange {why}"):
        assert optimizers() == {"random-search": RandomSearch}
    with pytest.raises(PluginError, match="of springopt-strange"):
        load_optimizer("strange")


@pytest.mark.parametrize(
    ("annotation", "value", "why"),
    [("int", dataclasses.MISSING, "has no default"), ("list", (), "can't have the type"), ("Gone", 1, "'Gone'")],
)
def test_a_plugin_with_an_illegal_option_is_left_out_likewise(install, monkeypatch, annotation, value, why):
    body = {"name": "strange", "__annotations__": {"size": annotation}, "__module__": "springopt.random_search"}
    if value is not dataclasses.MISSING:
        body["size"] = value
    strange = dataclasses.dataclass(frozen=True)(type("Strange", (Optimizer,), body))
    monkeypatch.setattr("springopt.random_search.Strange", strange, raising=False)
    install(RANDOM, entry("strange", "springopt.random_search:Strange"))
    with pytest.warns(RuntimeWarning, match=rf"strange of springopt-strange states an illegal option .*{why}"):
        assert optimizers() == {"random-search": RandomSearch}


def test_a_broken_plugin_is_in_nobodys_way(install):
    install(RANDOM, entry("strange", "springopt_gone:Optimizer"))
    assert load_optimizer("random-search") is RandomSearch


def test_of_two_distributions_with_one_name_always_the_same_has_it(install):
    entries = [RANDOM, entry("random-search", "springopt_gone:Optimizer")]
    for order in (entries, entries[::-1]):
        install(*order)
        assert load_optimizer("random-search") is RandomSearch


def test_the_core_s_effects_are_entry_points_likewise():
    assert effects()["gravity"] is load_effect("gravity") is Gravity
    assert distribution_of(Gravity).name == "springopt"


def test_an_effect_is_refused_in_the_words_of_effects(install):
    install(entry("gravity", "springopt.effects.gravity:Gravity"), entry("strange", "springopt.errors:UserError"))
    with pytest.raises(PluginError, match=r"no effect 'gravty'; installed: gravity, strange. Did you mean 'gravity'"):
        load_effect("gravty")
    with pytest.raises(PluginError, match="is no Effect with the name 'strange'"):
        load_effect("strange")


def test_an_effect_may_not_have_an_option_that_is_called_kind(install, monkeypatch):
    body = {"name": "strange", "__annotations__": {"kind": "str"}, "__module__": "springopt.effects.gravity"}
    strange = dataclasses.dataclass(frozen=True)(type("Strange", (Effect,), body))
    monkeypatch.setattr("springopt.effects.gravity.Strange", strange, raising=False)
    install(entry("strange", "springopt.effects.gravity:Strange"))
    with pytest.raises(PluginError, match="an option can't be called kind"):
        load_effect("strange")
