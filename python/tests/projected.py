"""Where cameras see the joints of a body, and the files that a 2-D detector would write of it."""

from __future__ import annotations

import json
import pathlib
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

import maquette

#: The joints that a fit and a detector both have, as halpe26 orders them.
HALPE_26 = {
    5: "LShoulder",
    6: "RShoulder",
    7: "LElbow",
    8: "RElbow",
    9: "LWrist",
    10: "RWrist",
    11: "LHip",
    12: "RHip",
    13: "LKnee",
    14: "RKnee",
    15: "LAnkle",
    16: "RAnkle",
    17: "Head",
    18: "Neck",
    20: "LBigToe",
    21: "RBigToe",
}


def cameras_of(calibration: pathlib.Path) -> dict[str, Any]:
    """K, R, t and distortion of the cameras of a calibration that the program has written, as arrays."""
    text = calibration.read_text()

    def numbers(key: str) -> NDArray[np.float64]:
        found = re.findall(rf"^{key} = (\[.*?\])$", text, flags=re.DOTALL | re.MULTILINE)
        return np.array([json.loads(value) for value in found], dtype=np.float64)

    return {
        "K": numbers("matrix"),
        "R": np.array([_matrix_of(vector) for vector in numbers("rotation")]),
        "t": numbers("translation"),
        "distortion": list(numbers("distortions")),
    }


def detected(fit: maquette.Fit, cameras: Mapping[str, Any], frames: int) -> list[NDArray[np.float64]]:
    """Of each camera where the joints of the first frames are seen, two pixels off; else not numbers."""
    places = fit.points["value"].sel(joint=list(HALPE_26.values())).to_numpy()[:frames]
    rng = np.random.default_rng(1)
    found: list[NDArray[np.float64]] = []
    for camera in range(len(cameras["K"])):
        pixels = _pixels(places, cameras, camera)
        array = np.full((frames, 26, 3), np.nan)
        array[:, list(HALPE_26), :2] = pixels + rng.normal(0.0, 2.0, pixels.shape)
        array[:, list(HALPE_26), 2] = 0.8
        found.append(array)
    return found


def write_detections(folder: pathlib.Path, detections: Mapping[str, NDArray[np.float64]]) -> None:
    """Write them as Pose2Sim keeps them."""
    for name, array in detections.items():
        own = folder / "pose" / f"{name}_json"
        own.mkdir(parents=True)
        for frame, points in enumerate(np.nan_to_num(array)):
            person = {"person_id": [-1], "pose_keypoints_2d": points.ravel().tolist()}
            text = json.dumps({"version": 1.3, "people": [person]})
            (own / f"{name}_{frame:06}.json").write_text(text)


def _matrix_of(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn: NDArray[np.float64] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return turn


def _pixels(points: NDArray[np.float64], cameras: Mapping[str, Any], camera: int) -> NDArray[np.float64]:
    """Where a camera of OpenCV's model shows points of shape (…, 3)."""
    seen = points @ cameras["R"][camera].T + cameras["t"][camera]
    x, y = seen[..., 0] / seen[..., 2], seen[..., 1] / seen[..., 2]
    k1, k2, p1, p2 = cameras["distortion"][camera][:4]
    square = x * x + y * y
    radial = 1 + k1 * square + k2 * square * square
    along_x = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
    along_y = y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y
    bent = np.stack([along_x, along_y, np.ones_like(x)], axis=-1)
    pixels: NDArray[np.float64] = bent @ cameras["K"][camera].T
    return pixels[..., :2]
