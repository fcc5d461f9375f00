"""What cameras saw, and the cameras, as arrays in memory that are written as the folder of a recording."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _detection_arrays, _mask_arrays
from ._camera_arrays import Cameras, SizeChoice, calibration, stated_sizes
from ._detection_arrays import Keypoints
from ._folder import Scratch
from .errors import OptionError

#: Of each camera, by name or in order, an array of shape (N, H, W).
Masks = Union[Mapping[str, ArrayLike], Sequence[ArrayLike], NDArray[np.bool_], NDArray[np.uint8]]
#: Of each camera, by name or in order, an array of shape (N, P, J, 3) or (N, J, 3).
Detections = Union[Mapping[str, ArrayLike], Sequence[ArrayLike], NDArray[np.float64], NDArray[np.float32]]
#: Keys of OpenCV's file storage.
_NAME = re.compile(r"[A-Za-z0-9_-]+")


class Seen(NamedTuple):
    """What the cameras saw."""

    masks: Masks | None
    detections: Detections | None
    #: Which points the detections are.
    keypoints: Keypoints | None
    #: Width and height of the pictures, px; None for those of the masks.
    size: SizeChoice


def written(seen: Seen, cameras: Cameras, up: str) -> Scratch:
    """Write what was seen and a calibration into a temporary folder that is a recording.

    ``up`` says which axis of the cameras' world points up.
    """
    names = _names(seen)
    masks = _by_camera("masks", seen.masks, names)
    stacks = {name: _mask_arrays.stack(name, stack) for name, stack in masks.items()}
    detections = _by_camera("detections", seen.detections, names)
    people = {name: _detection_arrays.people(name, array) for name, array in detections.items()}
    if seen.size is None and not stacks:
        raise OptionError("size: expected the width and height of the pictures, for there are no masks that have it")
    of_masks = {name: (stack.shape[2], stack.shape[1]) for name, stack in stacks.items()}
    text = calibration(cameras, of_masks if seen.size is None else stated_sizes(names, seen.size))

    scratch = Scratch()
    for name, stack in stacks.items():
        _mask_arrays.write(scratch.path / "masks" / name, stack)
    for name, array in people.items():
        _detection_arrays.write(scratch.path / "pose" / f"{name}_json", array)
    (scratch.path / "calibration.yml").write_text(text, encoding="utf-8")
    (scratch.path / "sequence.toml").write_text(_manifest(seen.keypoints, up), encoding="utf-8")
    return scratch


def _manifest(keypoints: Keypoints | None, up: str) -> str:
    stated = [f'up = "{up}"', *([] if keypoints is None else [f'keypoints = "{keypoints}"'])]
    return "\n".join([*stated, ""])


def _names(seen: Seen) -> list[str]:
    """The cameras: those of the masks, or without masks those of the detections."""
    named = seen.detections if seen.masks is None else seen.masks
    if named is None:
        raise OptionError("masks: expected masks, detections or both, found neither")
    if not isinstance(named, Mapping):
        return [f"cam_{number:02}" for number in range(1, len(named) + 1)]
    odd = [name for name in named if not _NAME.fullmatch(name)]
    if odd:
        raise OptionError(f"camera {odd[0]!r}: expected a name of letters, digits, - and _")
    return list(named)


def _by_camera(key: str, arrays: Masks | Detections | None, names: Sequence[str]) -> dict[str, ArrayLike]:
    """The arrays by the name of their camera."""
    if arrays is None:
        return {}
    if isinstance(arrays, Mapping):
        strange = [name for name in arrays if name not in names]
        if strange:
            raise OptionError(f"{key}: no camera is named {strange[0]!r}: there are {', '.join(names)}")
        return dict(arrays)
    if len(arrays) != len(names):
        raise OptionError(f"{key}: expected {len(names)} arrays, one for each camera, found {len(arrays)}")
    return dict(zip(names, arrays, strict=True))
