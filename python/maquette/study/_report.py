"""A page about a study: how many trials can be used, why the others cannot, how the numbers lie, and who is odd."""

from __future__ import annotations

import pathlib
import re
import tempfile
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from .._fit import load
from .._folder import written_page
from .._optional import imported
from .._words import Path
from ..errors import MaquetteError, MaquetteWarning, ResultError
from . import _numbers
from ._dataset import DATASET
from ._store import Store, local
from ._study import Study

if TYPE_CHECKING:
    import pandas as pd

_TEMPLATE = pathlib.Path(__file__).with_name("report.html.jinja")
#: What two lines of one reason differ in: numbers, and names in quotes or of files.
_PARTICULAR = re.compile(r"'[^']*'|\S*/\S*|-?\d+(?:\.\d+)?")


def report(study: Study, path: Path, *, outliers: int = 20) -> pathlib.Path:
    """Write a page about all trials of a study, and the reports of those that are odd into a folder beside it.

    Parameters
    ----------
    study
        What :func:`read` has read; its dataset was gathered.
    path
        The page, HTML.
    outliers
        Of how many odd trials the reports are written.

    Raises
    ------
    ResultError
        If there is no dataset.
    """
    path = pathlib.Path(path)
    store = Store(study.results)
    if not store.paths(f"{DATASET}/trials", ".parquet"):
        raise ResultError(f"{study.results}: no dataset: `maquette study gather` writes it")
    trials = _numbers.table(store, "trials")
    values = _numbers.quantities(store)
    odd = _numbers.odd(values)
    links = _reports(study, store, trials, list(odd["trial"].unique()[:outliers]), path)

    jinja2 = imported("jinja2", "study")
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    page = environment.from_string(_TEMPLATE.read_text(encoding="utf-8")).render(
        name=study.path.parent.absolute().name,
        count=len(trials),
        statuses=trials["status"].value_counts().to_dict(),
        reasons=_reasons(trials),
        versions=sorted(trials["version"].dropna().unique()),
        cpu_s=float(trials["cpu_s"].sum()),
        groups=_groups(values),
        odd=odd.assign(link=odd["trial"].map(links)).to_dict("records"),
        odd_z=_numbers.ODD_Z,
    )
    return written_page(path, page)


def _reasons(trials: pd.DataFrame) -> list[dict[str, Any]]:
    """Why trials cannot be used, the most frequent first; lines that differ in numbers and names are one reason."""
    told = trials[trials["status"] != "usable"].fillna({"reason": ""})
    kind = told["reason"].str.replace(_PARTICULAR, "…", regex=True)
    rows = [
        {
            "status": status,
            "count": len(rows),
            "example": rows["reason"].iloc[0],
            "trials": list(rows["trial"][:5]),
        }
        for (status, _), rows in told.groupby(["status", kind])
    ]
    return sorted(rows, key=lambda row: -row["count"])


def _groups(values: pd.DataFrame) -> dict[str, list[dict[str, Any]]]:
    """Of each quantity its number, quantiles, the median of u, and a histogram."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for key, rows in values.groupby(["group", "quantity", "unit"], sort=False):
        group, quantity, unit = map(str, key)
        low, median, high = rows["value"].quantile([0.05, 0.5, 0.95])
        row = {"quantity": quantity.replace("_", " "), "unit": unit, "n": len(rows), "low": low, "median": median}
        row |= {"high": high, "u": rows["u"].median(), "histogram": _histogram(rows["value"]), "spread": None}
        if rows["u"].notna().any():
            row["spread"] = _histogram(rows["u"].dropna())
        groups.setdefault(group, []).append(row)
    return groups


def _histogram(values: pd.Series[float]) -> dict[str, Any]:
    """The heights of a histogram's bars, the highest 1, and its ends."""
    counts, edges = np.histogram(values, bins="auto")
    return {"bars": (counts / counts.max()).tolist(), "low": edges[0], "high": edges[-1]}


def _reports(study: Study, store: Store, trials: pd.DataFrame, odd: list[str], page: pathlib.Path) -> dict[str, str]:
    """Write the reports of some trials beside the page; their links by trial."""
    folder = page.with_name(f"{page.stem}_trials")
    keys = trials.set_index("trial")["key"]
    links: dict[str, str] = {}
    for trial in odd:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="maquette-") as scratch, warnings.catch_warnings():
            warnings.simplefilter("ignore", MaquetteWarning)
            below = pathlib.Path(scratch)
            store.get(keys[trial], below / "fit")
            fitted = below / "fit" / "trials" / trial if study.unit == "session" else below / "fit"
            fit = load(fitted, body=study.options.get("body"))
            target = folder / f"{trial}.html"
            try:
                recording = local(dict(study.task_of(trial).trials)[trial], below)
                fit.report(target, subject=trial, recording=recording)
            except MaquetteError:
                # the recording is not there any more; the numbers are
                fit.report(target, subject=trial)
        links[trial] = f"{folder.name}/{target.name}"
    return links
