"""Curves with bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._optional import imported
from .errors import OptionError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: What is shown if nobody names an angle.
_SHOWN = ("hip_flexion", "knee_flexion", "ankle_dorsiflexion")
#: Standard deviations of an interval that holds 95 %.
_BAND = 1.96


def angles(dataset: xr.Dataset, names: tuple[str, ...]) -> Figure:
    """Angles over time in degrees, one below the other, left and right of one angle together."""
    known = [str(name) for name in dataset["angle"].values]
    odd = [name for name in names if name not in known]
    if odd:
        raise OptionError(f"no angle named {odd[0]!r}: there are {', '.join(known)}")
    shown = names or tuple(name for name in known if _base(name) in _SHOWN) or tuple(known)
    groups = list(dict.fromkeys(_base(name) for name in shown))

    plt = imported("matplotlib.pyplot", "plot")
    size = (7.0, 2.0 * len(groups) + 0.5)
    figure, axes = plt.subplots(len(groups), sharex=True, squeeze=False, figsize=size, layout="constrained")
    for group, axis in zip(groups, axes[:, 0], strict=True):
        for name in (name for name in shown if _base(name) == group):
            _curve(axis, dataset.sel(angle=name), name)
        axis.set_ylabel(f"{group.replace('_', ' ')} (°)")
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes[-1, 0].set_xlabel("time (s)")
    drawn: Figure = figure
    return drawn


def _base(name: str) -> str:
    """The name without its side."""
    return name.removesuffix("_r").removesuffix("_l")


def _curve(axis: Axes, of: xr.Dataset, name: str) -> None:
    """One angle, with its band where its standard deviations are known."""
    import numpy as np

    time, value = of["time"].values, np.degrees(of["value"].values)
    spread = _BAND * np.degrees(of["sd"].values)
    side = {"_r": "right", "_l": "left"}.get(name[-2:], name)
    (line,) = axis.plot(time, value, label=side)
    if np.isfinite(spread).any():
        band = f"{side}, 95 %"
        axis.fill_between(time, value - spread, value + spread, alpha=0.3, color=line.get_color(), label=band)
