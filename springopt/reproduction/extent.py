"""How much is run: all of it, or so much that it ends while one waits."""

from __future__ import annotations

from dataclasses import dataclass

from springopt.scene import Scene


@dataclass(frozen=True)
class Extent:
    """Seeds, and the share of a whole run. No reading of the paper was chosen on seeds from 100 on."""

    name: str
    seeds: tuple[int, ...]
    baseline_seeds: tuple[int, ...]
    share: float
    least: int = 2_000  #: evaluations: a shorter search is not cut

    def evaluations(self, scene: Scene) -> int:
        """Of one run on a scene."""
        whole = scene.budget.evaluations or self.least
        return max(round(self.share * whole), min(self.least, whole))


FULL = Extent("full", tuple(range(100, 107)), tuple(range(100, 103)), 1.0)
QUICK = Extent("quick", (100, 101), (100,), 0.1, least=500)
