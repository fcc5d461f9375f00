"""Doing one task of a study: from recordings to a folder with a fit and its rows."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import asdict, replace

from .._fit import Fit
from .._recording import Recording
from .._session import session
from ..errors import BodyError, FitError, MaquetteWarning, OptionError, RecordingError, ResultError
from . import _rows
from ._key import key_of
from ._store import Store, local
from ._task import Outcome, Status, Task

#: Faults of the input: the same input has them again. A disk that is full is none.
_OF_INPUT = (BodyError, FitError, OptionError, RecordingError, ResultError)

#: Does a task in a folder, and says what became of it and why.
Work = Callable[[Task, "list[pathlib.Path]", pathlib.Path], "tuple[Status, str | None]"]


def compute(task: Task, work: Work | None = None) -> Outcome:
    """Do a task, or find that it was done.

    Its folder appears below ``fits`` of the results, as a whole or not at all, under a name that is made of everything
    that it depends on. Two that do the same task at the same time write the same.

    Parameters
    ----------
    task
        What is to be done.
    work
        What does it; default the fit.

    Raises
    ------
    OSError
        If the results cannot be read or written.
    OutputError
        If there is no room for temporary files.
    """
    begin = time.perf_counter(), time.process_time()
    store = Store(task.results)
    with tempfile.TemporaryDirectory(prefix="maquette-") as scratch:
        try:
            recordings = [local(recording, pathlib.Path(scratch)) for _, recording in task.trials]
            key = key_of(task, recordings)
        except _OF_INPUT as fault:
            # without its inputs it has no name, and is tried again by the next run
            return Outcome(task.name, "failed", str(fault))
        if (done := store.outcome(key)) is not None:
            return replace(Outcome(**done), name=task.name, is_new=False)

        folder = pathlib.Path(scratch) / "fit"
        folder.mkdir()
        try:
            status, reason = (work or fitted)(task, recordings, folder)
        except _OF_INPUT as fault:
            status, reason = "failed", str(fault)
        wall_s, cpu_s = time.perf_counter() - begin[0], time.process_time() - begin[1]
        outcome = Outcome(task.name, status, reason, key, True, wall_s, cpu_s)
        store.publish(key, folder, asdict(outcome))
    return outcome


def lost(task: Task, fault: BaseException | str) -> Outcome:
    """What is said of a task whose process ended or could not do its work."""
    lines = [fault] if isinstance(fault, str) else traceback.format_exception_only(fault)
    return Outcome(task.name, "lost", lines[-1].strip())


def fitted(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """Fit the recordings, on one thread: a study has its tasks side by side."""
    with warnings.catch_warnings():
        # what they say stands in the rows
        warnings.simplefilter("ignore", MaquetteWarning)
        fits = _session(task, recordings, folder) if task.is_session else _trial(task, recordings[0], folder)
        _rows.write(folder, fits, task.gait)
    # where the recording is, seen from a folder that is about to move; the study's table knows
    for origin in list(folder.rglob("recording.toml")):
        origin.unlink()
    verdicts = [f"{name}: {fit.why_unusable}" if len(fits) > 1 else fit.why_unusable for name, fit in fits.items()]
    bad = [verdict for fit, verdict in zip(fits.values(), verdicts, strict=True) if not fit.usable]
    return ("unusable", "; ".join(map(str, bad))) if len(bad) == len(fits) else ("usable", None)


def _trial(task: Task, recording: pathlib.Path, folder: pathlib.Path) -> dict[str, Fit]:
    options = dict(task.options)
    opened = Recording(recording, fps=options.pop("fps", None))
    return {task.trials[0][0]: opened.fit(out=folder, threads=1, existing="resume", **options)}


def _session(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> dict[str, Fit]:
    # TOML's basic strings are written as JSON's
    trials = [
        f"[[trial]]\nname = {json.dumps(name)}\nrecording = {json.dumps(os.fspath(recording))}\n"
        for (name, _), recording in zip(task.trials, recordings, strict=True)
    ]
    manifest = folder.parent / "session.toml"
    manifest.write_text("".join(trials), encoding="utf-8")
    done = session([manifest], out=folder, threads=1, existing="resume", **task.options)
    return {name: done.trial(name) for name in done.names}
