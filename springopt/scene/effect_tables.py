"""[[effects]]: what acts on the body beside its springs.

`kind` is the name of any installed effect, and the other keys are its options: the fields of its dataclass, whoever
wrote it. Only the effects that a scene names are imported.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pydantic import Field, SerializationInfo, ValidationError, model_serializer, model_validator
from pydantic_core import InitErrorDetails

from springopt.errors import PluginError, did_you_mean
from springopt.lattice import SpringLattice
from springopt.option_types import read_exactly
from springopt.options import Option
from springopt.registry import effect_options, installed_effects, load_effect
from springopt.scene.table import FittingTable, fault

if TYPE_CHECKING:
    from springopt.effects.effect import Effect


class EffectTable(FittingTable):
    """An effect and its options, which are written beside its kind."""

    kind: str
    options: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _options_of_its_kind(cls, table: Any) -> Any:
        if not isinstance(table, dict):
            return table
        if not isinstance(table.get("kind"), str):
            return {key: table[key] for key in table if key == "kind"}  # nothing can be said of its options
        kind = table["kind"]
        given = {name: value for name, value in table.items() if name != "kind"}
        declared = _declared(kind)
        faults = list(_faults(kind, declared, given))
        if faults:
            raise ValidationError.from_exception_data(cls.__name__, faults)
        options = {
            option.name: read_exactly(option.type, given[option.name]) if option.name in given else option.default
            for option in declared
        }
        return {"kind": kind, "options": options}

    @model_serializer
    def _flat(self, info: SerializationInfo) -> dict[str, Any]:
        defaults = {option.name: option.default for option in _declared(self.kind)} if info.exclude_defaults else {}
        return {"kind": self.kind} | {
            name: value
            for name, value in self.options.items()
            if not (name in defaults and value == defaults[name]) and not (info.exclude_none and value is None)
        }

    def try_on(self, lattice: SpringLattice) -> object:
        from springopt.forward.terms import Terms

        return Terms.of(lattice, [self.build()])

    def build(self) -> Effect:
        return load_effect(self.kind)(**self.options)


def _declared(kind: str) -> tuple[Option, ...]:
    """The options of the effect of this name; a fault of the key `kind` where there is none."""
    names = installed_effects()
    try:
        if kind in names:
            return effect_options(load_effect(kind))
        sentence = f"should be one of {', '.join(names)}, but is {kind!r}.{did_you_mean(kind, names)}"
    except PluginError as error:
        sentence = str(error)
    raise ValidationError.from_exception_data("kind", [_at("kind", sentence, kind)])


def _faults(kind: str, declared: tuple[Option, ...], given: dict[str, Any]) -> Iterator[InitErrorDetails]:
    known = {option.name: option for option in declared}
    for name, value in given.items():
        if name not in known:
            yield _at(name, f"is not an option of {kind}; remove it.{did_you_mean(name, known)}", value)
            continue
        try:
            read_exactly(known[name].type, value)
        except ValueError:
            yield _at(name, f"should be {known[name].type_name}, but is {value!r}", value)
    for option in declared:
        if option.is_required and option.name not in given:
            yield InitErrorDetails(type="missing", loc=(option.name,), input=given)


def _at(key: str, sentence: str, value: Any) -> InitErrorDetails:
    return InitErrorDetails(type=fault(sentence), loc=(key,), input=value)
