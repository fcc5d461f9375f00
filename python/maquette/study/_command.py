"""The command ``maquette study``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import NoReturn

from .._optional import imported
from ..errors import MaquetteError
from ._compute import compute
from ._dataset import gather
from ._report import report
from ._run import SNAKEFILE, outcomes, run
from ._table import read

_ABOUT = """\
Fit all trials of a study: `maquette study STUDY` does what is to be done and gathers the dataset.

What was done before, with the same inputs, options and version, is not done again. A trial that fails is a row with
its one line. docs/scale.md of the repository describes study.toml, clusters, and what a trial costs."""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong as the program does: in one line."""

    def error(self, message: str) -> NoReturn:
        """End with the line."""
        print(f"error: {message}", file=sys.stderr)
        sys.exit(2)


def main(words: Sequence[str]) -> int:
    """Do what the words after ``maquette study`` say, and give the exit code."""
    parsers = {"task": _task_words, "gather": _gather_words, "report": _report_words, "workflow": _workflow_words}
    name = words[0] if words else "--help"
    parser = _Parser(prog="maquette study", formatter_class=argparse.RawDescriptionHelpFormatter)
    if name in parsers:
        parser.prog += f" {name}"
        words = words[1:]
    parsers.get(name, _run_words)(parser)
    arguments = parser.parse_args(words)
    try:
        arguments.call(arguments)
    except MaquetteError as fault:
        print(f"error: {fault}", file=sys.stderr)
        return 2
    return 0


def _run_words(parser: argparse.ArgumentParser) -> None:
    parser.description = _ABOUT
    parser.epilog = (
        "more: maquette study report STUDY     a page about all trials\n"
        "      maquette study gather STUDY     the dataset of what is done\n"
        "      maquette study task STUDY NAME  one trial or session, as a workflow does it\n"
        "      maquette study workflow         where the workflow for Snakemake is"
    )
    _study(parser)
    parser.add_argument("--jobs", type=int, metavar="N", help="processes side by side [default: as many as cores]")
    parser.add_argument("--memory-gib", type=float, metavar="GIB", help="memory for all of them together")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="do it on the workers of this Dask scheduler instead")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(call=_run)


def _task_words(parser: argparse.ArgumentParser) -> None:
    parser.description = "Do one task of a study, and print what became of it as a line of JSON."
    _study(parser)
    parser.add_argument("name", metavar="NAME", help="name of the trial or session")
    parser.set_defaults(call=_task)


def _gather_words(parser: argparse.ArgumentParser) -> None:
    parser.description = "Write the dataset of what is done."
    _study(parser)
    parser.set_defaults(call=_gather)


def _report_words(parser: argparse.ArgumentParser) -> None:
    parser.description = "Write a page about all trials: how many can be used, why the others cannot, and who is odd."
    _study(parser)
    parser.add_argument("--out", metavar="FILE", default="study.html", help="the page [default: %(default)s]")
    parser.set_defaults(call=_report)


def _workflow_words(parser: argparse.ArgumentParser) -> None:
    parser.description = "Print where the workflow for Snakemake is."
    parser.set_defaults(call=_workflow)


def _workflow(_: argparse.Namespace) -> None:
    print(SNAKEFILE)


def _study(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", metavar="STUDY", help="a study.toml")


def _run(arguments: argparse.Namespace) -> None:
    study = read(arguments.study)
    client = arguments.scheduler and imported("distributed", "study").Client(arguments.scheduler)
    tally = run(study, client, jobs=arguments.jobs, memory_gib=arguments.memory_gib, progress=not arguments.quiet)
    for outcome in outcomes(study):
        if outcome.reason is not None:
            print(f"{outcome.name}: {outcome.status}: {outcome.reason}", file=sys.stderr)
    print(tally)
    print(gather(study))


def _task(arguments: argparse.Namespace) -> None:
    print(compute(read(arguments.study).task(arguments.name)).json())


def _gather(arguments: argparse.Namespace) -> None:
    print(gather(read(arguments.study)))


def _report(arguments: argparse.Namespace) -> None:
    print(report(read(arguments.study), arguments.out))
