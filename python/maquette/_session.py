"""Several walks of one person, and what changed between two days."""

from __future__ import annotations

import json
import os
import pathlib
import warnings
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from . import _maquette, _tables
from ._fit import Fit, load
from ._folder import written_page
from ._optional import imported
from ._progress import ProgressChoice, listening, news
from ._recording import Existing
from ._words import Path, words
from .errors import MaquetteWarning, ResultError

if TYPE_CHECKING:
    import pandas as pd


class Session:
    """Several trials of one person with one body, as a folder holds them.

    Parameters
    ----------
    folder
        What ``maquette session`` or :func:`session` has written.
    body
        Its body model, if it is not a shipped one.

    Raises
    ------
    ResultError
        If it holds no session.
    """

    def __init__(self, folder: Path, *, body: str | None = None) -> None:
        self.folder: pathlib.Path = pathlib.Path(folder)
        self._body = body
        if not (self.folder / "session.json").is_file():
            raise ResultError(f"{self.folder}: expected the folder of a finished `maquette session`")

    @cached_property
    def result(self) -> dict[str, Any]:
        """All of ``session.json``."""
        result: dict[str, Any] = json.loads((self.folder / "session.json").read_text(encoding="utf-8"))
        return result

    @property
    def lengths(self) -> pd.DataFrame:
        """The lengths of the one body: ``length`` and ``sd``, m, by name."""
        return _tables.session_lengths(self.result)

    @property
    def names(self) -> list[str]:
        """Names of the trials."""
        return [part["name"] for part in self.result["trials"]]

    def trial(self, name: str) -> Fit:
        """One trial's fit with the one body."""
        folders = {part["name"]: part["folder"] for part in self.result["trials"]}
        if name not in folders:
            raise ResultError(f"{self.folder}: no trial named {name!r}: there are {', '.join(folders)}")
        return load(self.folder / folders[name], body=self._body)

    @property
    def notes(self) -> list[str]:
        """What a person should know: trials of somebody else first."""
        return [part["line"] for part in self.result["disagreements"]] + list(self.result["notes"])

    def report(self, path: Path, *, language: Literal["en", "de"] | None = None) -> pathlib.Path:
        """Write the page of all trials, in English unless asked otherwise: one HTML file that needs nothing else."""
        return written_page(path, _maquette.session_page(words(self.folder, body=self._body, language=language)))

    def compare(
        self,
        after: Session,
        *,
        norm: Path | Literal["none"] | None = None,
        language: Literal["en", "de"] | None = None,
    ) -> Comparison:
        """Tell what has changed from this session to a later one of the same person.

        Parameters
        ----------
        after
            The later one.
        norm
            Healthy people to compare with; default the shipped norm of the age.
        language
            Of the page; default English.
        """
        # the words ask for a folder, and nothing is written
        given = words(out=os.devnull, norm=norm, body=self._body, language=language)
        both = ["--", str(self.folder), str(after.folder)]
        return Comparison(*_maquette.compare([*given, *both]))

    def compare_conditions(
        self,
        conditions: tuple[str, str] | None = None,
        *,
        norm: Path | Literal["none"] | None = None,
        language: Literal["en", "de"] | None = None,
    ) -> Comparison:
        """Tell what differs between two conditions of the trials, which have one body: surer than between two sessions.

        Parameters
        ----------
        conditions
            Which, the earlier one first; default the only two.
        norm
            Healthy people to compare with; default the shipped norm of the age.
        language
            Of the page; default English.
        """
        given = words(out=os.devnull, norm=norm, body=self._body, language=language)
        named = [] if conditions is None else ["--conditions", *conditions]
        return Comparison(*_maquette.compare([*given, *named, "--", str(self.folder)]))

    def compare_sides(
        self,
        *,
        norm: Path | Literal["none"] | None = None,
        language: Literal["en", "de"] | None = None,
    ) -> Comparison:
        """Tell how the right side differs from the left, trial by trial; ``before`` is the left side.

        Parameters
        ----------
        norm
            Healthy people to compare with; default the shipped norm of the age.
        language
            Of the page; default English.
        """
        given = words(out=os.devnull, norm=norm, body=self._body, language=language)
        return Comparison(*_maquette.compare([*given, "--sides", "--", str(self.folder)]))

    def __repr__(self) -> str:
        """The folder and the trials."""
        return f"<Session {str(self.folder)!r}: {len(self.names)} trials>"


class Comparison:
    """What has changed between two sessions, or differs between conditions or sides of one; see docs/session.md."""

    def __init__(self, result: str, page: str) -> None:
        self._page = page
        self.result: dict[str, Any] = json.loads(result)

    @property
    def changes(self) -> pd.DataFrame:
        """Every number of both.

        Returns
        -------
        pandas.DataFrame
            By ``number`` and ``side``: ``before``, ``after``, ``change``, the ``low`` and ``high`` end of its 95 %
            interval, the minimal detectable change ``mdc``, ``beyond_mdc``, and the ``unit``.
        """
        rows = [
            {key: part[key] for key in ("number", "side", "before", "after", "change")}
            | dict(zip(("low", "high"), part["interval_95"] or (None, None), strict=True))
            | {key: part[key] for key in ("mdc", "beyond_mdc", "unit")}
            for part in self.result["changes"]
        ]
        table: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows)
        return table.astype(dict.fromkeys(("low", "high", "mdc"), float)).set_index(["number", "side"])

    @property
    def notes(self) -> list[str]:
        """What a person should know."""
        return list(self.result["notes"])

    def report(self, path: Path) -> pathlib.Path:
        """Write the comparison as one HTML file that needs nothing else."""
        return written_page(path, self._page)


def session(
    trials: Sequence[Path],
    *,
    out: Path,
    without: Sequence[str] = (),
    fps: float | None = None,
    body: str | None = None,
    threads: int | None = None,
    existing: Existing = "refuse",
    progress: ProgressChoice = None,
) -> Session:
    """Fit several trials of one person with one body.

    This is ``maquette session``; it runs as :meth:`Recording.fit` does.

    Parameters
    ----------
    trials
        Folders of recordings, one folder that holds them, or a ``session.toml``.
    out
        Folder for the result.
    without
        Names of trials that are left out.
    fps
        Frames per second, where neither a video nor a file states them.
    body, threads, existing, progress
        As of :meth:`Recording.fit`.
    """
    given = words(
        out=out,
        fps=fps,
        body=body,
        threads=threads,
        resume=existing == "resume",
        overwrite=existing == "overwrite",
    )
    left_out = [f"--without={name}" for name in without]
    paths = [os.fspath(path) for path in trials]
    with listening(progress) as told:
        verdict = _maquette.session([*given, *left_out, "--", *paths], (told, news))
    if verdict is not None:
        warnings.warn(verdict, MaquetteWarning, stacklevel=2)
    return Session(out, body=body)
