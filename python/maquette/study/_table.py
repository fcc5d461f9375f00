"""Reading a study: `study.toml` and the table of its trials."""

from __future__ import annotations

import inspect
import pathlib
import re
import sys
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from .._fit import Fit
from .._optional import imported
from .._recording import Recording
from .._session import session
from .._words import Path
from ..errors import OptionError
from ._rows import OWN_COLUMNS
from ._study import RECORDING, SESSION, TRIAL, Study, Unit, absolute

if TYPE_CHECKING:
    import pandas as pd

#: What a name may consist of: it becomes the name of a file.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
#: What a study decides by itself.
_OWN = {"self", "out", "existing", "progress", "threads", "overlays", "trials", "without"}
_KEYS = {"trials", "results", "unit", "fit", "gait"}


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
        results=absolute(path.parent, stated.get("results", "results")),
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
    names = dict.fromkeys((TRIAL, RECORDING, SESSION), str)
    try:
        if path.suffix == ".parquet":
            table: pd.DataFrame = pandas.read_parquet(path)
        else:
            table = pandas.read_csv(path, dtype=names)
    except (OSError, ValueError) as fault:
        raise OptionError(f"cannot read {path}: {fault}") from None

    needed = [TRIAL, RECORDING] + ([SESSION] if unit == "session" else [])
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
    twice = table[TRIAL][table[TRIAL].duplicated()]
    if len(twice):
        raise OptionError(f"{path}: trial {twice.iloc[0]} stands there twice")
    return table.astype(dict.fromkeys(needed, str)).set_index(TRIAL)


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
