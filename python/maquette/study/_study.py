"""A study: its trials, how they are fitted, and where the results go."""

from __future__ import annotations

import pathlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from ..errors import OptionError
from ._task import Task

if TYPE_CHECKING:
    import pandas as pd

#: What one fit is of.
Unit = Literal["trial", "session"]

#: Columns that say what a trial is; columns of options have a dot, and all others describe the person or the trial.
TRIAL, RECORDING, SESSION = "trial", "recording", "session"
#: Options that may be files, which are seen from the study's folder.
_FILES = ("body", "norm")


@dataclass(frozen=True)
class Study:
    """What :func:`read` has read.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    results : str
        Folder for the results, or an address that fsspec knows, such as ``s3://bucket/study``.
    unit : {"trial", "session"}
        Whether each trial has a body of its own, or the trials of a session share one.
    table : pandas.DataFrame
        A row for each trial; its index is the name.
    options, gait : dict
        Options of :meth:`maquette.Recording.fit` (or :func:`maquette.session`) and of :meth:`maquette.Fit.gait`.
    """

    path: pathlib.Path
    results: str
    unit: Unit
    table: pd.DataFrame
    options: dict[str, Any]
    gait: dict[str, Any]

    @property
    def names(self) -> list[str]:
        """Names of the tasks: of the trials, or of the sessions."""
        return list(dict.fromkeys(self._column))

    def tasks(self) -> Iterator[Task]:
        """What is to be done, in the order of the table."""
        if self.unit == "session":
            for name in self.names:
                yield self.task(name)
        else:
            yield from (self._task(str(row[TRIAL]), [row]) for row in _rows(self.table))

    def task(self, name: str) -> Task:
        """The task of this name."""
        rows = list(_rows(self.table[self._column == name]))
        if not rows:
            raise OptionError(f"{self.path}: no {self.unit} named {name!r}")
        return self._task(name, rows)

    def task_of(self, trial: str) -> Task:
        """The task that a trial belongs to."""
        return self.task(str(self._column[trial]))

    @property
    def _column(self) -> pd.Series[str]:
        """Of each trial the name of its task."""
        return self.table[SESSION] if self.unit == "session" else self.table.index.to_series()

    def _task(self, name: str, rows: list[dict[str, Any]]) -> Task:
        recordings = [absolute(self.path.parent, row[RECORDING]) for row in rows]
        return Task(
            name=name,
            trials=tuple(zip((str(row[TRIAL]) for row in rows), recordings, strict=True)),
            options=self._located(self.options | _options_of(name, rows, "fit.")),
            gait=self._located(self.gait | _options_of(name, rows, "gait.")),
            is_session=self.unit == "session",
            results=self.results,
        )

    def _located(self, options: dict[str, Any]) -> dict[str, Any]:
        """Options whose files are found from everywhere."""
        files = {name: value for name, value in options.items() if name in _FILES and str(value).endswith(".toml")}
        return options | {name: absolute(self.path.parent, file) for name, file in files.items()}

    @property
    def described(self) -> pd.DataFrame:
        """What the table says of each trial beside its recording and options."""
        kept = [column for column in self.table.columns if column != RECORDING and "." not in column]
        return self.table[kept]


def absolute(folder: pathlib.Path, place: str) -> str:
    """A path seen from a folder; an address as it is."""
    return place if "://" in place else str((folder / place).absolute())


def _rows(table: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Row by row, for a study may have a million; what is empty is left out."""
    columns = [TRIAL, *table.columns]
    for row in table.itertuples(name=None):
        # a value that is not a number is unlike itself
        yield {
            column: value for column, value in zip(columns, row, strict=True) if value is not None and value == value
        }


def _options_of(name: str, rows: list[dict[str, Any]], prefix: str) -> dict[str, Any]:
    """Options that the table states; the trials of one task have the same."""
    options: dict[str, Any] = {}
    for row in rows:
        for column, value in row.items():
            if not column.startswith(prefix):
                continue
            # whole numbers become fractions in a column with gaps
            option, stated = column.removeprefix(prefix), _whole(value)
            if options.setdefault(option, stated) != stated:
                raise OptionError(f"{name}: {column} is not the same for all its trials: {options[option]}, {stated}")
    return options


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value
