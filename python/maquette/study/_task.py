"""What one task of a study is, and what became of it: small values that can be pickled, and written as JSON."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Literal

#: What became of a task. Nothing is known of one that is ``lost``: it is done again by the next run.
Status = Literal["usable", "unusable", "failed", "lost"]


@dataclass(frozen=True)
class Task:
    """What one fit needs. It can be pickled, and written as JSON.

    Attributes
    ----------
    name : str
        Name of the trial, or of the session.
    trials : tuple of (str, str)
        Name and recording of each trial; a recording is a path or an address that fsspec knows.
    options, gait : dict
        Options of :meth:`maquette.Recording.fit` or :func:`maquette.session`, and of :meth:`maquette.Fit.gait`.
    is_session : bool
        Whether the trials share one body.
    results : str
        Folder or address of the results.
    """

    name: str
    trials: tuple[tuple[str, str], ...]
    options: dict[str, Any]
    gait: dict[str, Any]
    is_session: bool
    results: str

    def json(self) -> str:
        """All of it as one line."""
        return json.dumps(asdict(self))

    @classmethod
    def of_json(cls, text: str) -> Task:
        """What :meth:`json` has written."""
        stated = json.loads(text)
        return cls(**stated | {"trials": tuple((name, path) for name, path in stated["trials"])})


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a task.

    Attributes
    ----------
    name : str
        Name of the task.
    status : {"usable", "unusable", "failed", "lost"}
        ``unusable`` is a fit that says so itself, ``failed`` an input that cannot be fitted, and ``lost`` a task whose
        process ended, so that nothing is known.
    reason : str or None
        The one line that says why.
    key : str or None
        Name of its folder below ``fits``.
    is_new : bool
        Whether it was computed now; otherwise it was there.
    wall_s, cpu_s : float
        Time that it took when it was computed, s.
    """

    name: str
    status: Status
    reason: str | None = None
    key: str | None = None
    is_new: bool = False
    wall_s: float = 0.0
    cpu_s: float = 0.0

    def json(self) -> str:
        """All of it as one line."""
        return json.dumps(asdict(self))

    @classmethod
    def of_json(cls, text: str | bytes) -> Outcome:
        """What :meth:`json` has written."""
        return cls(**json.loads(text))
