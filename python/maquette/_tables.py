"""A result as tables of pandas and arrays of xarray, with their units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _maquette
from ._optional import imported

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import xarray as xr
    from numpy.typing import NDArray

Result = dict[str, Any]


def _frame(rows: list[dict[str, Any]], index: str, units: dict[str, str]) -> pd.DataFrame:
    """A table of rows by one of their columns, with its units."""
    table: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows).set_index(index)
    table.attrs["units"] = units
    return table


def _number(value: float | None) -> float:
    """A number that may not be known."""
    return float("nan") if value is None else value


def lengths(result: Result) -> pd.DataFrame:
    """The lengths at rest, by name."""
    parts = result["shape"]["lengths"]
    rows = [
        {
            "name": part["name"],
            "length": part["length_m"],
            "sd": _number(part["sd_m"]),
            "p": _number(part["confidence"]["p_within"]),
        }
        for part in parts
    ]
    table = _frame(rows, "name", {"length": "m", "sd": "m", "p": "1"})
    table.attrs["p_within"] = parts[0]["confidence"]["epsilon"] if parts else None
    return table


def session_lengths(result: Result) -> pd.DataFrame:
    """The lengths of a session's one body, by name."""
    rows = [
        {"name": part["name"], "length": part["length_m"], "sd": _number(part["sd_m"])} for part in result["lengths"]
    ]
    return _frame(rows, "name", {"length": "m", "sd": "m"})


def coefficients(result: Result) -> pd.DataFrame:
    """The shape coefficients, by name."""
    keys = ("name", "value", "prior_mean", "prior_sd")
    rows = [{key: part[key] for key in keys} | {"sd": _number(part["sd"])} for part in result["shape"]["coefficients"]]
    table = _frame(rows, "name", {})
    return table[["value", "sd", "prior_mean", "prior_sd"]]


def covariance(result: Result) -> pd.DataFrame | None:
    """Covariance of the shape coefficients."""
    rows = result["shape"]["covariance"]
    if rows is None:
        return None
    names = [part["name"] for part in result["shape"]["coefficients"]]
    table: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows, index=names, columns=names)
    return table.rename_axis(index="name", columns="name")


def hypotheses(result: Result) -> pd.DataFrame:
    """Every hypothesis, in the order in which it was tried."""
    names = [f"length_{part['name']}" for part in result["shape"]["lengths"]]
    keys = ("origin", "keyframe", "reading", "outcome", "frames_fitted", "keyframe_cost", "iou")
    rows = [
        {"hypothesis": number}
        | {key: part[key] for key in keys}
        | {"minus_log_posterior": part["minus_log_posterior"]["total"]}
        | dict(zip(names, part["lengths_m"], strict=True))
        for number, part in enumerate(result["hypotheses"])
    ]
    return _frame(rows, "hypothesis", dict.fromkeys(names, "m"))


def angles(fitted: _maquette.Fitted, result: Result) -> xr.Dataset:
    """Angles over (frame, angle)."""
    value, sd = fitted.angles_rad(), fitted.angles_sd_rad()
    names = {"angle": result["motion"]["angles"]}
    return _dataset(fitted, value, sd, names, {"units": "rad"})


def points(fitted: _maquette.Fitted, result: Result) -> xr.Dataset:
    """Points over (frame, joint, axis)."""
    value, sd = fitted.points_m(), fitted.points_sd_m()
    names = {"joint": result["motion"]["points"], "axis": ["x", "y", "z"]}
    return _dataset(fitted, value, sd, names, {"units": "m"})


def _dataset(
    fitted: _maquette.Fitted,
    value: NDArray[np.float64],
    sd: NDArray[np.float64],
    names: dict[str, list[str]],
    attrs: dict[str, str],
) -> xr.Dataset:
    """Values and their standard deviations, frame by frame, over named axes."""
    dims = ("frame", *names)
    dataset: xr.Dataset = imported("xarray", "xarray").Dataset(
        {
            "value": (dims, value, attrs),
            "sd": (dims, sd, attrs | {"long_name": "standard deviation"}),
        },
        coords={
            "frame": fitted.frame_numbers(),
            "time": ("frame", fitted.times_s(), {"units": "s"}),
            "views": ("frame", fitted.views(), {"long_name": "cameras that see the person"}),
            **names,
        },
    )
    return dataset
