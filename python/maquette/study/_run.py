"""All tasks of a study, one after the other or side by side, and what became of them."""

from __future__ import annotations

import os
import pathlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .._progress import ProgressChoice, listening
from . import _dask, _processes
from ._compute import Work
from ._store import Store
from ._study import Study
from ._task import Outcome, Status

if TYPE_CHECKING:
    from distributed import Client

#: Beside the fits: files with a line for each task.
OUTCOMES = "outcomes"
#: The workflow that Snakemake runs.
SNAKEFILE = pathlib.Path(__file__).with_name("Snakefile")
#: Lines that are written at once.
_LINES = 1000


@dataclass
class Tally:
    """How many tasks ended how.

    Attributes
    ----------
    of : collections.Counter
        How many are ``usable``, ``unusable``, ``failed`` and ``lost``.
    computed : int
        How many were computed now; the others were there.
    """

    of: Counter[Status] = field(default_factory=Counter[Status])
    computed: int = 0

    def add(self, outcome: Outcome) -> None:
        """Count one more."""
        self.of[outcome.status] += 1
        self.computed += outcome.is_new

    def __str__(self) -> str:
        """All of it in a line."""
        counts = ", ".join(f"{count} {status}" for status, count in sorted(self.of.items()))
        return f"{self.of.total()} tasks: {counts or 'none'}; {self.computed} computed now"


def run(
    study: Study,
    client: Client | None = None,
    *,
    jobs: int | None = None,
    memory_gib: float | None = None,
    progress: ProgressChoice = None,
    work: Work | None = None,
) -> Tally:
    """Do all tasks of a study that were not done.

    Parameters
    ----------
    study
        What :func:`read` has read.
    client
        A client of Dask, whose workers do it; default processes of this machine.
    jobs
        How many processes; default as many as there are cores.
    memory_gib
        Memory for all processes together, GiB; one that needs more than its share is ended. Default no bound.
    progress
        As of :meth:`maquette.Recording.fit`: the stage is ``"tasks"``.
    work
        What does a task; default the fit. With a client alone.

    Returns
    -------
    Tally
        A task that fails never ends the run: :func:`outcomes` has its one line.
    """
    if client is None:
        ended = _processes.outcomes(study.tasks(), os.cpu_count() or 1 if jobs is None else jobs, memory_gib)
    else:
        ended = _dask.outcomes(study.tasks(), client, work)
    tally, count = Tally(), len(study.names)
    with _Lines(study) as lines, listening(progress) as told:
        for outcome in ended:
            lines.add(outcome)
            tally.add(outcome)
            if told is not None:
                told("tasks", tally.of.total(), count)
    return tally


def outcomes(study: Study) -> Iterator[Outcome]:
    """What became of each task of the last run, in the order in which they ended."""
    store = Store(study.results)
    for path in store.paths(OUTCOMES, ".jsonl"):
        for line in store.content(path).splitlines():
            yield Outcome.of_json(line)


class _Lines:
    """What became of the tasks, written as files of many lines, each there as a whole or not at all."""

    def __init__(self, study: Study) -> None:
        self._store = Store(study.results)
        self._waiting: list[str] = []
        self._parts = 0

    def __enter__(self) -> _Lines:
        self._store.make(OUTCOMES)
        return self

    def add(self, outcome: Outcome) -> None:
        self._waiting.append(outcome.json() + "\n")
        if len(self._waiting) == _LINES:
            self._write()

    def _write(self) -> None:
        if self._waiting:
            part = self._store.path(OUTCOMES, f"part-{self._parts:06}.jsonl")
            self._store.put(part, "".join(self._waiting).encode())
            self._parts += 1
            self._waiting.clear()

    def __exit__(self, *_: object) -> None:
        self._write()
