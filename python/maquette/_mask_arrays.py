"""Masks that are arrays, as pictures."""

from __future__ import annotations

import pathlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _maquette
from .errors import OptionError


def stack(name: str, masks: ArrayLike) -> NDArray[np.uint8]:
    """One camera's masks as grey pictures, of shape (N, H, W).

    Truth becomes white. Grey values stay, for they may name people.

    Raises
    ------
    OptionError
        If they are neither bool nor uint8, or have another shape.
    """
    array = np.asarray(masks)
    if array.ndim != 3 or array.dtype.name not in ("bool", "uint8"):
        found = f"found {array.dtype} of shape {array.shape}"
        raise OptionError(f"masks of camera {name}: expected bool or uint8 of shape (N, H, W), {found}")
    return array.astype(np.uint8) * np.uint8(255) if array.dtype.name == "bool" else array.astype(np.uint8)


def write(folder: pathlib.Path, masks: NDArray[np.uint8]) -> None:
    """Write a picture for each frame into a new folder."""
    folder.mkdir(parents=True)
    for frame, mask in enumerate(masks):
        _maquette.write_mask(folder / f"{frame:06}.png", np.ascontiguousarray(mask))
