"""Cameras that are arrays, as a calibration in OpenCV's file storage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import OptionError

#: Width and height, px.
Size = tuple[int, int]
#: Of each camera by name, its width and height in pixels.
Sizes = Mapping[str, Size]
#: The same as somebody states it: for all cameras, or for each in order.
SizeChoice = Union[ArrayLike, None]


class Cameras(NamedTuple):
    """C calibrated cameras, x_camera = R x + t in metres."""

    #: Camera matrices, px, of shape (C, 3, 3).
    K: ArrayLike
    #: Of shape (C, 3, 3).
    R: ArrayLike
    #: Of shape (C, 3).
    t: ArrayLike
    #: Of each camera its coefficients in OpenCV's order; None for none.
    distortion: Sequence[ArrayLike] | None


def stated_sizes(names: Sequence[str], size: ArrayLike) -> dict[str, Size]:
    """The stated size of each camera's pictures, of shape (2,) for all or (C, 2).

    Raises
    ------
    OptionError
        If it has another shape, or is no whole number of pixels.
    """
    array = np.asarray(size)
    if array.shape not in ((2,), (len(names), 2)) or array.dtype.kind not in "iu":
        raise OptionError(
            f"size: expected whole numbers of shape (2,) or ({len(names)}, 2), found {array.dtype} of {array.shape}"
        )
    rows = np.broadcast_to(array, (len(names), 2))
    return {name: (int(row[0]), int(row[1])) for name, row in zip(names, rows, strict=True)}


def calibration(cameras: Cameras, sizes: Sizes) -> str:
    """The text of a calibration of the cameras that ``sizes`` names.

    Raises
    ------
    OptionError
        If an array has another shape than there are cameras.
    """
    count = len(sizes)
    columns = {key: _of_all(key, value, count) for key, value in zip("KRt", cameras[:3], strict=True)}
    lenses = _lenses(cameras.distortion, count)
    text = ["%YAML:1.0", "---", "names:", *(f'  - "{name}"' for name in sizes)]
    for number, (name, (width, height)) in enumerate(sizes.items()):
        for key, entry in (("K", "K"), ("Rot", "R"), ("T", "t")):
            text += _matrix(f"{key}_{name}", columns[entry][number])
        text += _matrix(f"dist_{name}", lenses[number])
        text += [f"W_{name}: {width}", f"H_{name}: {height}"]
    return "\n".join([*text, ""])


def _of_all(key: str, value: ArrayLike, cameras: int) -> NDArray[np.float64]:
    """Matrices or vectors of all cameras."""
    array = np.asarray(value, dtype=np.float64)
    shape = (cameras, 3) if key == "t" else (cameras, 3, 3)
    if array.shape != shape:
        raise OptionError(f"{key}: expected shape {shape}, one for each camera, found {array.shape}")
    return array


def _lenses(distortion: Sequence[ArrayLike] | None, cameras: int) -> list[NDArray[np.float64]]:
    """The coefficients of each camera."""
    given = [np.zeros(4)] * cameras if distortion is None else distortion
    if len(given) != cameras:
        raise OptionError(f"distortion: expected {cameras} rows, one for each camera, found {len(given)}")
    return [np.asarray(lens, dtype=np.float64).ravel() for lens in given]


def _matrix(key: str, values: NDArray[np.float64]) -> list[str]:
    """A matrix in OpenCV's file storage, with as many digits as give the same numbers back."""
    rows = values if values.ndim == 2 else values[:, np.newaxis]
    data = ", ".join(repr(float(value)) for value in rows.ravel())
    shape = [f"  rows: {rows.shape[0]}", f"  cols: {rows.shape[1]}", "  dt: d"]
    return [f"{key}: !!opencv-matrix", *shape, f"  data: [ {data} ]"]
