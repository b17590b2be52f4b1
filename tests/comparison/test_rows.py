"""The comparison as rows: each number under its headings, once."""

import csv
import math
from pathlib import Path

from springopt.comparison.comparison import compare
from springopt.comparison.rows import rows, write_csv


def test_every_number_is_found_by_its_headings(two_scenes: Path) -> None:
    comparison = compare([two_scenes])
    found = list(rows(comparison))
    keys = [row[:6] for row in found]
    assert len(set(keys)) == len(keys)
    by_key = dict(zip(keys, found, strict=True))
    method = comparison.scenes[0].methods[0]
    gap = by_key["nine", method.method, None, "gap", None, None]
    assert (gap.value, gap.low, gap.high) == (method.gap.median, method.gap.lower_quartile, method.gap.upper_quartile)
    time = by_key["nine", method.method, None, "expected running time", 6, "solves"]
    assert time.value == method.targets[6].running_times["solves"].value
    assert by_key["nine", "stubborn", None, "refused", None, None].word == "bits"
    assert comparison.ranking is not None
    assert by_key[None, "wide", None, "mean rank", None, None].value == comparison.ranking.mean_ranks["wide"]


def test_the_file_reads_back(folder: Path, tmp_path: Path) -> None:
    comparison = compare([folder])
    write_csv(comparison, tmp_path / "all.csv")
    with (tmp_path / "all.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert len(read) == len(list(rows(comparison)))
    never = [row for row in read if row["quantity"] == "expected running time" and row["value"] == "inf"]
    assert all(math.isinf(float(row["high"])) for row in never)
