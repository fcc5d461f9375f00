"""What was found of cameras, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._optional import imported

if TYPE_CHECKING:
    import pandas as pd

_AXES = ("x", "y", "z")
#: What is known of where a camera is, its key in a result, and its unit.
_PLACES = (("turn", "turn_deg", "deg"), ("displacement", "displacement_m", "m"))


def place(found: dict[str, Any] | None) -> dict[str, float]:
    """How a camera is turned, displaced and zoomed, with standard deviations; not numbers if unknown."""
    row: dict[str, float] = {}
    for name, key, unit in _PLACES:
        for whole, ending in ((key, ""), (f"{name}_sd_{unit}", "_sd")):
            values = (found or {}).get(whole) or [float("nan")] * 3
            row |= {f"{name}_{axis}{ending}": value for axis, value in zip(_AXES, values, strict=True)}
    for key in ("zoom", "zoom_sd"):
        value = (found or {}).get(key)
        row[key] = float("nan") if value is None else value
    return row


def table(rows: list[dict[str, Any]], columns: list[str], units: dict[str, str]) -> pd.DataFrame:
    """Rows by camera, with the units of their places and others."""
    made: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows, columns=columns).set_index("camera")
    of_places = {column: unit for column in made.columns for name, _, unit in _PLACES if column.startswith(f"{name}_")}
    made.attrs["units"] = of_places | {"zoom": "1", "zoom_sd": "1"} | units
    return made


def of_fit(result: dict[str, Any]) -> pd.DataFrame:
    """Every camera of a fit."""
    rows = [_row(part) for part in result["quality"]["cameras"]]
    units = {"iou": "1", "median": "px", "ahead": "s", "ahead_sd": "s"}
    return table(rows, list(rows[0]) if rows else ["camera"], units)


def _row(part: dict[str, Any]) -> dict[str, Any]:
    clock: dict[str, Any] = part["found"]["clock"] or {}
    numbers = {"iou": part["mean_iou"], "median": part["median_px"]}
    ahead = {"ahead": clock.get("ahead_s"), "ahead_sd": clock.get("sd_s")}
    known = numbers | place(part["found"]["pose"]) | ahead
    named = {"camera": part["camera"], "frames": part["frames"]}
    return named | {name: float("nan") if value is None else value for name, value in known.items()}
