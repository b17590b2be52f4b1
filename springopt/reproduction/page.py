"""The page: every section in one order, what the paper says, what comes out here, where the difference is from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Page:
    """The page of one call."""

    extent: Extent
    only: tuple[str, ...]  #: the experiments that were asked for; all of them if there are none
    pictures: str  #: the folder of the pictures, as the page links it

    def text(self, sections: Mapping[Experiment, Section]) -> str:
        """The page as Markdown."""
        parts = [self._head(), *(self._section(*item) for item in sections.items()), self._colophon()]
        return "\n\n".join(parts) + "\n"

    def _head(self) -> str:
        extent = self.extent
        seeds = f"{len(extent.seeds)} seeds ({extent.seeds[0]} to {extent.seeds[-1]})"
        baselines = "one seed" if len(extent.baseline_seeds) == 1 else f"{len(extent.baseline_seeds)} seeds"
        parts = [
            "# The paper, reproduced",
            _flow(f"{PAPER}. Every table and picture on this page was made by one command, from nothing:"),
            _code(self._command(*self.only)),
            _flow(f"""Numbers are the median of {seeds}, on which no reading of the paper was chosen, and in brackets
                the least and the greatest. *Within the seeds' spread* says that the paper's number, as it is rounded in
                print, lies between these; where it does not, the readings of the paper that were tried stand beside it
                with what they give. The baselines in the same tables have {baselines} and the same budget of
                evaluations. Under each section is the command that repeats it alone."""),
        ]
        if extent.share < 1:
            quick = f"""**This is the quick page**: runs have {extent.share:.0%} of their evaluations, so that what
                comes late in a search is missing, and few seeds have a small spread. Leave out `--quick` for the
                whole."""
            parts.append(_flow(quick))
        return "\n\n".join(parts)

    def _section(self, experiment: Experiment, section: Section) -> str:
        parts = [
            f"## {experiment.title}",
            _flow(f"**The paper.** {section.paper}"),
            _flow(f"**Here.** {section.setting}"),
            *(_table(table) for table in section.tables),
            *(self._picture(picture) for picture in section.pictures),
            "\n".join(_flow(f"- {verdict}", indent="  ") for verdict in section.verdicts),
            _flow(section.explained),
            _code(f"{self._command(experiment.name)} --out {experiment.name}"),
        ]
        return "\n\n".join(part for part in parts if part)

    def _picture(self, picture: Picture) -> str:
        return f"![{picture.shows}]({self.pictures}/{picture.name}.png)\n\n*{picture.shows}.*"

    def _colophon(self) -> str:
        versions = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
        return f"---\n\nMade by `{self._command(*self.only)}` with {versions}."

    def _command(self, *only: str) -> str:
        quick = ["--quick"] if self.extent.share < 1 else []
        return " ".join([COMMAND, *quick, *(f"--only {name}" for name in only)])


def _table(table: Table) -> str:
    width = len(table.heads)
    rows = [table.heads, ("---",) * width, *(row + ("",) * (width - len(row)) for row in table.rows)]
    text = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    return f"{table.note}\n\n{text}" if table.note else text


def _flow(text: str, indent: str = "") -> str:
    """A paragraph in lines of the house's length."""
    return fill(" ".join(text.split()), 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _code(line: str) -> str:
    return f"```\n{line}\n```"


def names(experiments: Iterable[Experiment]) -> str:
    """Their names in a sentence."""
    return ", ".join(experiment.name for experiment in experiments)
