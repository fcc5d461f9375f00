"""Masks and cameras that are arrays, written as the folder of a recording."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _maquette
from ._folder import Scratch
from .errors import OptionError

#: Of each camera, by name or in order, an array of shape (N, H, W).
Masks = Union[Mapping[str, ArrayLike], Sequence[ArrayLike], NDArray[np.bool_], NDArray[np.uint8]]
#: Keys of OpenCV's file storage.
_NAME = re.compile(r"[A-Za-z0-9_-]+")


def written(masks: Masks, cameras: Mapping[str, ArrayLike], distortion: Sequence[ArrayLike] | None, up: str) -> Scratch:
    """Write masks and calibration into a temporary folder that is a recording.

    Parameters
    ----------
    masks
        Of each camera, of shape (N, H, W).
    cameras
        ``K``, ``R`` and ``t`` of all cameras, of shapes (C, 3, 3), (C, 3, 3) and (C, 3).
    distortion
        Of each camera, in OpenCV's order; None for none.
    up
        Which axis of the cameras' world points up.
    """
    named = _named(masks)
    stacks = {name: _stack(name, stack) for name, stack in named.items()}
    matrices = {key: _of_all(key, value, len(stacks)) for key, value in cameras.items()}
    lenses = _lenses(distortion, len(stacks))

    scratch = Scratch()
    text = ["%YAML:1.0", "---", "names:", *(f'  - "{name}"' for name in stacks)]
    for number, (name, stack) in enumerate(stacks.items()):
        for key, entry in (("K", "K"), ("Rot", "R"), ("T", "t")):
            text += _matrix(f"{key}_{name}", matrices[entry][number])
        text += _matrix(f"dist_{name}", lenses[number])
        text += [f"W_{name}: {stack.shape[2]}", f"H_{name}: {stack.shape[1]}"]
        _write(scratch, name, stack)
    (scratch.path / "calibration.yml").write_text("\n".join([*text, ""]), encoding="utf-8")
    (scratch.path / "sequence.toml").write_text(f'up = "{up}"\n', encoding="utf-8")
    return scratch


def _named(masks: Masks) -> dict[str, ArrayLike]:
    """The masks by the name of their camera."""
    if isinstance(masks, Mapping):
        named = dict(masks)
    else:
        named = {f"cam_{number:02}": stack for number, stack in enumerate(masks, 1)}
    odd = [name for name in named if not _NAME.fullmatch(name)]
    if odd:
        raise OptionError(f"masks: camera {odd[0]!r}: expected a name of letters, digits, - and _")
    return named


def _stack(name: str, stack: ArrayLike) -> NDArray[np.uint8]:
    """One camera's masks as pictures; truth becomes white, grey values stay, for they may name people."""
    array = np.asarray(stack)
    if array.ndim != 3 or array.dtype.name not in ("bool", "uint8"):
        found = f"found {array.dtype} of shape {array.shape}"
        raise OptionError(f"masks of camera {name}: expected bool or uint8 of shape (N, H, W), {found}")
    return array.astype(np.uint8) * np.uint8(255) if array.dtype.name == "bool" else array.astype(np.uint8)


def _of_all(key: str, value: ArrayLike, cameras: int) -> NDArray[np.float64]:
    """Matrices or vectors of all cameras."""
    array = np.asarray(value, dtype=np.float64)
    shape = (cameras, 3) if key == "t" else (cameras, 3, 3)
    if array.shape != shape:
        raise OptionError(f"{key}: expected shape {shape}, one for each camera's masks, found {array.shape}")
    return array


def _lenses(distortion: Sequence[ArrayLike] | None, cameras: int) -> list[NDArray[np.float64]]:
    """The coefficients of each camera."""
    given = [np.zeros(4)] * cameras if distortion is None else distortion
    if len(given) != cameras:
        raise OptionError(f"distortion: expected {cameras} rows, one for each camera's masks, found {len(given)}")
    return [np.asarray(lens, dtype=np.float64).ravel() for lens in given]


def _matrix(key: str, values: NDArray[np.float64]) -> list[str]:
    """A matrix in OpenCV's file storage, with as many digits as give the same numbers back."""
    rows = values if values.ndim == 2 else values[:, np.newaxis]
    data = ", ".join(repr(float(value)) for value in rows.ravel())
    shape = [f"  rows: {rows.shape[0]}", f"  cols: {rows.shape[1]}", "  dt: d"]
    return [f"{key}: !!opencv-matrix", *shape, f"  data: [ {data} ]"]


def _write(scratch: Scratch, name: str, stack: NDArray[np.uint8]) -> None:
    """The masks of one camera, a picture for each frame."""
    folder = scratch.path / "masks" / name
    folder.mkdir(parents=True)
    for frame, mask in enumerate(stack):
        _maquette.write_mask(folder / f"{frame:06}.png", np.ascontiguousarray(mask))
