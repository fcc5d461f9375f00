"""Detections of joints that are arrays, as OpenPose writes them."""

from __future__ import annotations

import json
import pathlib
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import OptionError

#: Which points a detector names, and in which order; docs/formats.md, detections.
Keypoints = Literal["coco17", "body25", "body25b", "halpe26", "mediapipe33", "wholebody133", "halpe136"]


def people(name: str, detections: ArrayLike) -> NDArray[np.float64]:
    """One camera's detections of P people, of shape (N, P, J, 3): x and y (px) and confidence, 0, 0, 0 if not seen.

    Parameters
    ----------
    name
        The camera's.
    detections
        The same, or (N, J, 3) of one person; what was not seen is not a number or has no confidence.

    Raises
    ------
    OptionError
        If they have another shape.
    """
    array = np.asarray(detections, dtype=np.float64)
    if array.ndim not in (3, 4) or array.shape[-1] != 3:
        shapes = "expected shape (N, J, 3) or (N, P, J, 3)"
        raise OptionError(f"detections of camera {name}: {shapes}, found {array.shape}")
    array = array if array.ndim == 4 else array[:, np.newaxis]
    is_seen = np.isfinite(array).all(axis=-1, keepdims=True) & (array[..., 2:] > 0)
    return np.where(is_seen, array, 0.0)


def write(folder: pathlib.Path, detections: NDArray[np.float64]) -> None:
    """Write a file for each frame into a new folder."""
    folder.mkdir(parents=True)
    for frame, persons in enumerate(detections):
        listed = [{"pose_keypoints_2d": person.ravel().tolist()} for person in persons]
        text = json.dumps({"version": 1.3, "people": listed})
        (folder / f"{frame:06}.json").write_text(text, encoding="utf-8")
