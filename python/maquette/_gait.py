"""How a person walks."""

from __future__ import annotations

import json
import pathlib
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import _html, _maquette
from ._optional import imported
from ._words import Path

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_SIDES = ("left", "right")


class Gait:
    """A gait analysis of a fit; docs/gait.md of the repository defines every number.

    Made by :meth:`Fit.gait`. Of a fit that is not to be used all numbers are withheld.
    """

    def __init__(self, study: _maquette.Study) -> None:
        self._study = study

    @cached_property
    def result(self) -> dict[str, Any]:
        """All of ``gait.json``. Angles in it are in degrees."""
        result: dict[str, Any] = json.loads(self._study.json())
        return result

    @property
    def parameters(self) -> pd.DataFrame:
        """Steps and strides.

        Returns
        -------
        pandas.DataFrame
            By ``name`` and ``side``: ``mean``, ``sd`` between strides, their number ``n``, the standard
            ``uncertainty`` of a single value, and the ``unit`` of these.
        """
        rows = [
            {"name": part["name"], "side": side}
            | {key: part[side][key] for key in ("mean", "sd", "n", "uncertainty")}
            | {"unit": part["unit"]}
            for part in self.result["parameters"]
            for side in _SIDES
            if part[side] is not None
        ]
        columns = ["name", "side", "mean", "sd", "n", "uncertainty", "unit"]
        table: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows, columns=columns)
        numbers = dict.fromkeys(("mean", "sd", "uncertainty"), float)
        return table.astype(numbers).set_index(["name", "side"])

    @property
    def events(self) -> pd.DataFrame:
        """Foot strikes and foot offs: ``side``, ``kind`` and ``time`` (s)."""
        rows = [[part["side"], part["kind"], part["time_s"]] for part in self.result["events"]]
        pandas = imported("pandas", "pandas")
        table: pd.DataFrame = pandas.DataFrame(rows, columns=["side", "kind", "time"])
        table.attrs["units"] = {"time": "s"}
        return table

    @property
    def curves(self) -> xr.Dataset:
        """The angles over the gait cycle.

        Returns
        -------
        xarray.Dataset
            ``mean``, ``sd`` between strides and ``fit_sd``, the standard deviation that the fit states, over
            (side, angle, percent), degrees; not a number where there is none.
        """
        import numpy as np

        curves = self.result["curves"]
        names = list(dict.fromkeys(curve["angle"] for curve in curves))
        count = len(curves[0]["mean_deg"]) if curves else 0
        blank = np.full((len(_SIDES), len(names), count), np.nan)
        filled = {"mean": blank, "sd": blank.copy(), "fit_sd": blank.copy()}
        for curve in curves:
            at = _SIDES.index(curve["side"]), names.index(curve["angle"])
            for name, values in filled.items():
                row = curve[f"{name}_deg"]
                if row is not None:
                    values[at] = np.array(row, dtype=float)
        dims = ("side", "angle", "percent")
        coords = {"side": list(_SIDES), "angle": names, "percent": np.linspace(0, 100, count)}
        variables = {name: (dims, values, {"units": "deg"}) for name, values in filled.items()}
        curves_of: xr.Dataset = imported("xarray", "xarray").Dataset(variables, coords=coords)
        return curves_of

    @property
    def angles(self) -> xr.Dataset:
        """The angles of gait analysis, frame by frame, as the fit has them.

        Returns
        -------
        xarray.Dataset
            ``value`` and ``sd`` over (side, angle, frame), rad; not a number where nobody was seen, or where it is
            not known. Coordinate: ``time`` (s).

        Raises
        ------
        UnusableError
            Of a fit that is not to be used.
        """
        import numpy as np

        self._study.check_usable()
        tracks = self._study.tracks()
        first, rate = self._study.time_base()
        names = list(dict.fromkeys(angle for _, angle, _, _ in tracks))
        count = len(tracks[0][2]) if tracks else 0
        value = np.full((len(_SIDES), len(names), count), np.nan)
        sd = value.copy()
        for side, angle, radians, spread in tracks:
            at = _SIDES.index(side), names.index(angle)
            value[at] = radians
            if spread is not None:
                sd[at] = spread
        frames = np.arange(first, first + count)
        dims = ("side", "angle", "frame")
        tracks_of: xr.Dataset = imported("xarray", "xarray").Dataset(
            {"value": (dims, value, {"units": "rad"}), "sd": (dims, sd, {"units": "rad"})},
            coords={
                "side": list(_SIDES),
                "angle": names,
                "frame": frames,
                "time": ("frame", frames / rate, {"units": "s"}),
            },
        )
        return tracks_of

    @property
    def notes(self) -> list[str]:
        """What a person should know."""
        return list(self.result["notes"])

    def save(self, folder: Path) -> pathlib.Path:
        """Write ``gait.json``, ``parameters.csv``, ``curves.csv`` and ``angles.csv`` into a folder."""
        self._study.save(folder)
        return pathlib.Path(folder)

    def __repr__(self) -> str:
        """How many events and parameters there are."""
        return f"<Gait: {len(self.result['events'])} events, {len(self.result['curves'])} curves>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return _html.gait(self.result)
