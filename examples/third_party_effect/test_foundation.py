from foundation import Foundation

from springopt.testing import check_effect


def test_a_foundation_keeps_the_contract():
    check_effect(Foundation(modulus=2.0))
