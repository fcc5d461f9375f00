"""The name of a result: what it depends on, as a number."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib

from .. import _maquette
from .._words import words
from ._task import Task

#: Raised where the rows of a fit change.
_ROWS = 1


def key_of(task: Task, recordings: list[pathlib.Path]) -> str:
    """160 bits of BLAKE2b, hexadecimal, of the version, the options, and every file that is read.

    Two tasks of one key have the same result. Names, places and times of files do not count, but those of a session's
    trials do, for they stand in its result.

    Raises
    ------
    MaquetteError
        If a recording cannot be read, or an option is none.
    """
    parts = {
        "version": _maquette.__version__,
        "rows": _ROWS,
        "options": task.options,
        "gait": task.gait,
        "session": [name for name, _ in task.trials] if task.is_session else None,
        "inputs": [_inputs(recording, task) for recording in recordings],
    }
    text = json.dumps(parts, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=20).hexdigest()


def _inputs(recording: pathlib.Path, task: Task) -> list[tuple[str, str]]:
    """Name and BLAKE3 of everything that a fit of the recording reads, its body model included."""
    that_decide = ("fps", "body", "stereo", "silhouettes", "fit_to")
    decided = {name: task.options.get(name) for name in that_decide}
    return _maquette.inputs(words(recording, out=os.devnull, **decided))
