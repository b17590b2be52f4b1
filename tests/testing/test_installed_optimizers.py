"""Every optimizer that is installed here keeps the contract; each distribution's own tests say so every time."""

import pytest

from springopt.registry import installed, load_optimizer
from springopt.testing import check_optimizer


@pytest.mark.slow
@pytest.mark.parametrize("name", installed())
def test_an_installed_optimizer_keeps_the_contract(name: str) -> None:
    check_optimizer(load_optimizer(name))
