"""The checks that every effect must pass, on small lattices that take a second or two together.

Each takes an effect, or its class to be checked with its defaults, and raises AssertionError with a sentence that says
what to mend. Each looks for one fault: where another one is in its way, it raises NotJudged. What an effect does not
bring is not checked. A plugin's whole test is `check_effect(MyEffect(...))`.
"""

from __future__ import annotations

from collections.abc import Callable

from springopt.lattice import SpringLattice
from springopt.testing.declaration_checks import (
    check_acts,
    check_constant_forces_fit_the_nodes,
    check_masses_are_linear_in_the_parameters,
    check_options_are_documented,
    check_parameters_are_rows_of_numbers,
    check_rest_lengths_fit_the_springs,
    check_runs_or_refuses_in_a_sentence,
    check_says_the_same_twice,
    check_travels_to_other_processes,
)
from springopt.testing.effect_trial import (
    EffectSubject,
)
from springopt.testing.kernel_checks import (
    check_is_finite_everywhere,
    check_keeps_to_its_places,
    check_lanes_are_independent,
)
from springopt.testing.motion_checks import (
    check_dissipation_blocks_are_derivatives,
    check_dissipation_takes_power,
    check_rigid_motions_cost_nothing,
)
from springopt.testing.potential_checks import (
    check_blocks_are_the_forces_derivatives,
    check_depends_on_the_stiffness_as_claimed,
    check_derivatives_by_parameters,
    check_expands_at_rest_as_claimed,
    check_fitting_changes_no_force,
    check_forces_are_the_energys_derivatives,
)
from springopt.testing.verdict import Finding, find

EffectCheck = Callable[..., None]


def check_effect(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """All checks, on a lattice or on small ones with cells of every kind that the effect does not refuse."""
    for check in EFFECT_CHECKS:
        check(effect, lattice)


def examine_effect(effect: EffectSubject, lattice: SpringLattice | None = None) -> list[Finding]:
    """What each check finds, in their order: to be read, where `check_effect` raises the first fault."""
    return [find(check, effect, lattice) for check in EFFECT_CHECKS]


EFFECT_CHECKS: tuple[EffectCheck, ...] = (
    check_options_are_documented,
    check_runs_or_refuses_in_a_sentence,
    check_parameters_are_rows_of_numbers,
    check_constant_forces_fit_the_nodes,
    check_rest_lengths_fit_the_springs,
    check_masses_are_linear_in_the_parameters,
    check_keeps_to_its_places,
    check_says_the_same_twice,
    check_travels_to_other_processes,
    check_lanes_are_independent,
    check_is_finite_everywhere,
    check_acts,
    check_forces_are_the_energys_derivatives,
    check_blocks_are_the_forces_derivatives,
    check_expands_at_rest_as_claimed,
    check_depends_on_the_stiffness_as_claimed,
    check_derivatives_by_parameters,
    check_fitting_changes_no_force,
    check_rigid_motions_cost_nothing,
    check_dissipation_takes_power,
    check_dissipation_blocks_are_derivatives,
)
