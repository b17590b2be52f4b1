"""The stability ladder: is the forward solve ever silently wrong, and how often does it refuse what it could solve?

    ./run python benchmarks/stability.py [--rungs]

Every rung has one right answer or one right refusal; answers are checked against energy, residual and inertia in
extended precision (`ladder/extended.py`). With `--rungs`, every rung that was not climbed is named.
"""

import sys
from collections import Counter, defaultdict

from ladder import READINGS, RIGHT, RIGHTLY_REFUSED, climb


def main() -> None:
    verdicts = climb()
    families = defaultdict(list)
    for verdict in verdicts:
        families[verdict.family].append(verdict)
    print(f"{'family':24} {'rungs':>5}" + "".join(f"{reading:>31}" for reading in READINGS) + f"{'of solvable':>13}")
    for family, members in (*families.items(), ("all", verdicts)):
        readings = Counter(verdict.reading for verdict in members)
        solvable = [verdict for verdict in members if verdict.is_solvable]
        share = f"{sum(v.reading == RIGHT for v in solvable) / len(solvable):.1%}" if solvable else "-"
        print(f"{family:24} {len(members):5}" + "".join(f"{readings[r]:31}" for r in READINGS) + f"{share:>13}")
    if "--rungs" in sys.argv:
        for verdict in verdicts:
            if verdict.reading not in (RIGHT, RIGHTLY_REFUSED):
                print(f"{verdict.family}: {verdict.name}: {verdict.reading} ({verdict.reason})")


if __name__ == "__main__":
    main()
