"""A fit as rows: what it adds to the tables of a study's dataset."""

from __future__ import annotations

import pathlib
from typing import Any

from .. import _maquette
from .._fit import Fit
from .._gait import Gait
from .._optional import imported
from ..errors import GaitError, UnusableError

Rows = list[dict[str, Any]]

#: The tables, with the type of each column. Units are in the names.
TABLES: dict[str, dict[str, str]] = {
    "trials": {
        "trial": "string",
        "status": "string",
        "reason": "string",
        "body": "string",
        "fps": "float64",
        "frames": "int64",
        "cameras": "int64",
        "overlap": "float64",
        "gps_left_deg": "float64",
        "gps_right_deg": "float64",
        "gps_deg": "float64",
        "warnings": "string",
        "notes": "string",
        "version": "string",
    },
    "lengths": {"trial": "string", "name": "string", "length_m": "float64", "sd_m": "float64", "p": "float64"},
    "strides": {
        "trial": "string",
        "name": "string",
        "side": "string",
        "stride": "int64",
        "value": "float64",
        "uncertainty": "float64",
        "unit": "string",
    },
    "curves": {
        "trial": "string",
        "side": "string",
        "angle": "string",
        "percent": "float64",
        "mean_deg": "float64",
        "sd_deg": "float64",
        "fit_sd_deg": "float64",
    },
    "scores": {"trial": "string", "side": "string", "angle": "string", "gvs_deg": "float64"},
}

#: Columns that the task adds to those of the trials.
OF_TASK = {"key": "string", "wall_s": "float64", "cpu_s": "float64"}
#: What the table of a study cannot have as a column of its own.
OWN_COLUMNS = {*TABLES["trials"], *OF_TASK} - {"trial"}


def write(folder: pathlib.Path, fits: dict[str, Fit], gait: dict[str, Any]) -> None:
    """Write the rows of each fit, by the name of its trial, as ``rows/<table>.parquet``."""
    rows: dict[str, Rows] = {table: [] for table in TABLES}
    for trial, fit in fits.items():
        for table, more in _of(fit, gait).items():
            rows[table] += [{"trial": trial} | row for row in more]
    (folder / "rows").mkdir()
    pyarrow, parquet = imported("pyarrow", "study"), imported("pyarrow.parquet", "study")
    for table, found in rows.items():
        if not found:
            continue
        content = pyarrow.Table.from_pylist(found, schema=schema(table))
        parquet.write_table(content, folder / "rows" / f"{table}.parquet", compression="zstd")


def schema(table: str) -> Any:
    """The columns of a table as pyarrow's schema."""
    return schema_of(TABLES[table])


def schema_of(columns: dict[str, str]) -> Any:
    """Columns and their types as pyarrow's schema."""
    pyarrow = imported("pyarrow", "study")
    types = {"string": pyarrow.string(), "float64": pyarrow.float64(), "int64": pyarrow.int64()}
    return pyarrow.schema([(name, types[type_]) for name, type_ in columns.items()])


def _of(fit: Fit, options: dict[str, Any]) -> dict[str, Rows]:
    """The rows of one fit. One that is not to be used has no numbers, and one without gait no strides."""
    verdict = fit.why_unusable
    if verdict is not None:
        return {"trials": [_trial(fit) | {"status": "unusable", "reason": verdict}]}
    lengths = [
        {"name": name, "length_m": row["length"], "sd_m": row["sd"], "p": row["p"]}
        for name, row in fit.lengths.iterrows()
    ]
    try:
        gait = fit.gait(**options)
    except (GaitError, UnusableError) as fault:
        return {"trials": [_trial(fit) | {"status": "usable", "notes": str(fault)}], "lengths": lengths}
    row = _trial(fit) | {"status": "usable", "notes": "\n".join(gait.notes)} | _profile_scores(gait)
    return {
        "trials": [row],
        "lengths": lengths,
        "strides": _strides(gait),
        "curves": _curves(gait),
        "scores": _scores(gait),
    }


def _trial(fit: Fit) -> dict[str, Any]:
    recording = fit.result["recording"]
    overlaps = [part["mean_iou"] for part in fit.result["quality"]["cameras"] if part["mean_iou"] is not None]
    return {
        "body": fit.body,
        "fps": fit.fps,
        "frames": len(fit.frames),
        "cameras": len(recording["cameras"]),
        "overlap": sum(overlaps) / len(overlaps) if overlaps else None,
        "warnings": "\n".join(fit.warnings),
        "version": _maquette.__version__,
    }


def _scores(gait: Gait) -> Rows:
    """Gait variable scores, where there is a norm."""
    parts = _indices(gait).get("variables", [])
    return [{"side": part["side"], "angle": part["angle"], "gvs_deg": part["score"]} for part in parts]


def _profile_scores(gait: Gait) -> dict[str, Any]:
    """Gait profile scores, where all angles of theirs are known."""
    indices = _indices(gait)
    columns = {"gps_deg": "both", "gps_left_deg": "left", "gps_right_deg": "right"}
    return {column: indices.get(name) for column, name in columns.items()}


def _indices(gait: Gait) -> dict[str, Any]:
    indices: dict[str, Any] | None = gait.result["indices"]
    return indices or {}


def _strides(gait: Gait) -> Rows:
    return [
        {
            "name": part["name"],
            "side": side,
            "stride": number,
            "value": value,
            "uncertainty": part[side]["uncertainty"],
            "unit": part["unit"],
        }
        for part in gait.result["parameters"]
        for side in ("left", "right")
        if part[side] is not None
        for number, value in enumerate(part[side]["values"])
    ]


def _curves(gait: Gait) -> Rows:
    rows: Rows = []
    for curve in gait.result["curves"]:
        count = len(curve["mean_deg"])
        blank = [None] * count
        columns = (curve["mean_deg"], curve["sd_deg"] or blank, curve["fit_sd_deg"] or blank)
        rows += [
            {
                "side": curve["side"],
                "angle": curve["angle"],
                "percent": 100 * at / (count - 1),
                "mean_deg": mean,
                "sd_deg": sd,
                "fit_sd_deg": fit_sd,
            }
            for at, (mean, sd, fit_sd) in enumerate(zip(*columns, strict=True))
        ]
    return rows
