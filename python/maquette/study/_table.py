"""A study: the table of its trials, how they are fitted, and where the results go."""

from __future__ import annotations

import inspect
import pathlib
import re
import sys
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from .._fit import Fit
from .._optional import imported
from .._recording import Recording
from .._session import session
from .._words import Path
from ..errors import OptionError
from ._rows import OWN_COLUMNS
from ._task import Task

if TYPE_CHECKING:
    import pandas as pd

#: What one fit is of.
Unit = Literal["trial", "session"]

#: Columns that say what a trial is; columns of options have a dot, and all others describe the person or the trial.
_TRIAL, _RECORDING, _SESSION = "trial", "recording", "session"
#: What a name may consist of: it becomes the name of a file.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
#: What a study decides by itself.
_OWN = {"self", "out", "existing", "progress", "threads", "overlays", "trials", "without"}
_KEYS = {"trials", "results", "unit", "fit", "gait"}


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
            yield from (self._task(str(row[_TRIAL]), [row]) for row in _rows(self.table))

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
        return self.table[_SESSION] if self.unit == "session" else self.table.index.to_series()

    def _task(self, name: str, rows: list[dict[str, Any]]) -> Task:
        recordings = [_absolute(self.path.parent, row[_RECORDING]) for row in rows]
        return Task(
            name=name,
            trials=tuple(zip((str(row[_TRIAL]) for row in rows), recordings, strict=True)),
            options=self.options | _options_of(name, rows, "fit."),
            gait=self.gait | _options_of(name, rows, "gait."),
            is_session=self.unit == "session",
            results=self.results,
        )

    @property
    def described(self) -> pd.DataFrame:
        """What the table says of each trial beside its recording and options."""
        kept = [column for column in self.table.columns if column != _RECORDING and "." not in column]
        return self.table[kept]


def read(path: Path) -> Study:
    """Read a study.

    Parameters
    ----------
    path
        A ``study.toml``; docs/scale.md of the repository describes it.

    Raises
    ------
    OptionError
        If the file or its table says what cannot be.
    """
    path = pathlib.Path(path)
    stated = _toml(path)
    _check_known(f"{path}", stated, _KEYS)
    unit = stated.get("unit", "trial")
    if unit not in ("trial", "session"):
        raise OptionError(f'{path}: unit: expected "trial" or "session", found {unit!r}')
    study = Study(
        path=path,
        results=_absolute(path.parent, stated.get("results", "results")),
        unit=unit,
        table=_table(path.parent / stated.get("trials", "trials.csv"), unit),
        options=stated.get("fit", {}),
        gait=stated.get("gait", {}),
    )
    _check_options(study)
    return study


def _toml_loads(text: str) -> dict[str, Any]:
    name = "tomllib" if sys.version_info >= (3, 11) else "tomli"
    stated: dict[str, Any] = imported(name, "study").loads(text)
    return stated


def _absolute(folder: pathlib.Path, place: str) -> str:
    """A path seen from a folder; an address as it is."""
    return place if "://" in place else str((folder / place).absolute())


def _toml(path: pathlib.Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as fault:
        raise OptionError(f"cannot read {path}: {fault.strerror}") from None
    try:
        stated: dict[str, Any] = _toml_loads(text)
    except ValueError as fault:
        raise OptionError(f"{path}: {fault}") from None
    return stated


def _table(path: pathlib.Path, unit: Unit) -> pd.DataFrame:
    """The trials by name, with absolute paths or addresses."""
    pandas = imported("pandas", "study")
    names = dict.fromkeys((_TRIAL, _RECORDING, _SESSION), str)
    try:
        if path.suffix == ".parquet":
            table: pd.DataFrame = pandas.read_parquet(path)
        else:
            table = pandas.read_csv(path, dtype=names)
    except (OSError, ValueError) as fault:
        raise OptionError(f"cannot read {path}: {fault}") from None

    needed = [_TRIAL, _RECORDING] + ([_SESSION] if unit == "session" else [])
    for column in needed:
        if column not in table.columns:
            raise OptionError(f"{path}: expected a column {column!r}, found {', '.join(map(str, table.columns))}")
        empty = table.index[table[column].isna()]
        if len(empty):
            raise OptionError(f"{path}: row {empty[0] + 1}: {column} is empty")
    for column in needed[::2]:
        _check_names(path, column, table[column].astype(str))
    for column in map(str, table.columns):
        if column in OWN_COLUMNS:
            raise OptionError(f"{path}: column {column!r} is one of the dataset's own")
    twice = table[_TRIAL][table[_TRIAL].duplicated()]
    if len(twice):
        raise OptionError(f"{path}: trial {twice.iloc[0]} stands there twice")
    return table.astype(dict.fromkeys(needed, str)).set_index(_TRIAL)


def _check_names(path: pathlib.Path, column: str, names: pd.Series[str]) -> None:
    odd = names[~names.str.fullmatch(_NAME)]
    if len(odd):
        raise OptionError(
            f"{path}: row {_number(odd.index[0]) + 1}: {column} {odd.iloc[0]!r}: "
            "expected letters of ASCII, digits, dots, hyphens and underscores"
        )


def _number(label: Hashable) -> int:
    return int(str(label))


def _check_options(study: Study) -> None:
    """Every option is one of the calls that the study makes; their values are checked when they are used."""
    call: Any = session if study.unit == "session" else Recording.fit
    fit = (set(inspect.signature(call).parameters) | {"fps"}) - _OWN
    gait = set(inspect.signature(Fit.gait).parameters) - _OWN
    _check_known(f"{study.path}: [fit]", study.options, fit)
    _check_known(f"{study.path}: [gait]", study.gait, gait)
    columns = [str(column) for column in study.table.columns if "." in str(column)]
    _check_known(
        f"{study.path}: the table", columns, {f"fit.{name}" for name in fit} | {f"gait.{name}" for name in gait}
    )


def _check_known(where: str, found: Any, known: set[str]) -> None:
    for name in found:
        if name not in known:
            raise OptionError(f"{where}: {name!r} is none of {', '.join(sorted(known))}")


def _rows(table: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Row by row, for a study may have a million; what is empty is left out."""
    columns = [_TRIAL, *table.columns]
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
