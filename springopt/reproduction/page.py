"""The page: every section in one order, what the paper says, what comes out here, where the difference is from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.metadata import version
from textwrap import fill

from springopt.reproduction.experiment import Experiment, Picture, Section, Table
from springopt.reproduction.extent import Extent

COMMAND = "springopt reproduce"
PAPER = (
    "G. Bianchi, B. Solenthaler, G. Székely, M. Harders, *Simultaneous Topology and Stiffness Identification for "
    "Mass-Spring Models Based on FEM Reference Deformations*, MICCAI 2004"
)
LIBRARIES = ("springopt", "numpy", "scipy", "scikit-fem", "numba")


def page(sections: Mapping[Experiment, Section], extent: Extent, *, pictures: str) -> str:
    """The page as Markdown; `pictures` is the folder of the pictures as the page links it."""
    parts = [_head(extent), *(_section(*item, extent, pictures) for item in sections.items()), _colophon(extent)]
    return "\n\n".join(parts) + "\n"


def _head(extent: Extent) -> str:
    seeds = f"{len(extent.seeds)} seeds ({extent.seeds[0]} to {extent.seeds[-1]})"
    baselines = "one seed" if len(extent.baseline_seeds) == 1 else f"{len(extent.baseline_seeds)} seeds"
    parts = [
        "# The paper, reproduced",
        _flow(f"{PAPER}. Every table and picture on this page was made by one command, from nothing:"),
        _code(_command(extent)),
        _flow(f"""Numbers are the median of {seeds}, on which no reading of the paper was chosen, and in brackets the
            least and the greatest. *Within the seeds' spread* says that the paper's number, as it is rounded in print,
            lies between these; where it does not, the readings of the paper that were tried stand beside it with what
            they give. The baselines in the same tables have {baselines} and the same budget of evaluations."""),
    ]
    if extent.share < 1:
        quick = f"""**This is the quick page**: runs have {extent.share:.0%} of their evaluations, so that what comes
            late in a search is missing, and few seeds have a small spread. Leave out `--quick` for the whole."""
        parts.append(_flow(quick))
    return "\n\n".join(parts)


def _section(experiment: Experiment, section: Section, extent: Extent, pictures: str) -> str:
    parts = [
        f"## {experiment.title}",
        _flow(f"**The paper.** {section.paper}"),
        _flow(f"**Here.** {section.setting}"),
        *(_table(table) for table in section.tables),
        *(_picture(picture, pictures) for picture in section.pictures),
        "\n".join(_flow(f"- {verdict}", indent="  ") for verdict in section.verdicts),
        _flow(section.explained),
        _code(_command(extent, experiment.name)),
    ]
    return "\n\n".join(part for part in parts if part)


def _table(table: Table) -> str:
    width = len(table.heads)
    rows = [table.heads, ("---",) * width, *(row + ("",) * (width - len(row)) for row in table.rows)]
    text = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    return f"{table.note}\n\n{text}" if table.note else text


def _picture(picture: Picture, folder: str) -> str:
    return f"![{picture.shows}]({folder}/{picture.name}.png)\n\n*{picture.shows}.*"


def _colophon(extent: Extent) -> str:
    versions = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return f"---\n\nMade by `{_command(extent)}` with {versions}."


def _command(extent: Extent, only: str = "") -> str:
    return " ".join([COMMAND, *(["--quick"] if extent.share < 1 else []), *([f"--only {only}"] if only else [])])


def _flow(text: str, indent: str = "") -> str:
    """A paragraph in lines of the house's length."""
    return fill(" ".join(text.split()), 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _code(line: str) -> str:
    return f"```\n{line}\n```"


def names(experiments: Iterable[Experiment]) -> str:
    """Their names in a sentence."""
    return ", ".join(experiment.name for experiment in experiments)
