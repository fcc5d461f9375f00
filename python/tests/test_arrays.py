"""Masks, detections and cameras in memory make the recording that they would make as files."""

from __future__ import annotations

import pathlib
import shutil
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from projected import cameras_of, detected, write_detections

import maquette

plt = pytest.importorskip("matplotlib.pyplot")


@pytest.fixture(scope="module")
def arrays(recording: pathlib.Path) -> dict[str, Any]:
    """What the synthetic recording holds, of its first ten frames."""
    names = sorted(path.name for path in (recording / "masks").iterdir())

    def masks(name: str) -> NDArray[np.bool_]:
        paths = sorted((recording / "masks" / name).glob("*.png"))[:10]
        return np.array([plt.imread(path) > 0 for path in paths])

    return {
        "masks": {name: masks(name) for name in names},
        **cameras_of(recording / "calibration.toml"),
    }


def test_a_recording_of_arrays_gives_the_fit_of_its_files(
    recording: pathlib.Path, arrays: dict[str, Any], tmp_path: pathlib.Path
) -> None:
    """To the rounding of a rotation, and with what the cameras saw in the report."""
    rec = maquette.Recording.from_arrays(**arrays, fps=50.0)
    fit = rec.fit(body="human-ellipsoids")
    expected = maquette.Recording(recording, fps=50.0).fit(body="human-ellipsoids", frames=(0, 9))
    assert fit.result["recording"]["cameras"] == expected.result["recording"]["cameras"]
    columns = ["length", "sd"]
    np.testing.assert_allclose(fit.lengths[columns], expected.lengths[columns], rtol=1e-4)
    np.testing.assert_allclose(fit.points["value"], expected.points["value"], atol=1e-4)
    page = fit.report(tmp_path / "report.html")
    assert page.stat().st_size > 100_000


def test_the_world_may_have_another_axis_up(arrays: dict[str, Any]) -> None:
    """The result has Z up all the same."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    turned = arrays | {"R": arrays["R"] @ turn}
    points = maquette.Recording.from_arrays(**turned, fps=50.0, up="y").fit(body="human-ellipsoids").points
    upright = maquette.Recording.from_arrays(**arrays, fps=50.0).fit(body="human-ellipsoids").points
    # the search rounds otherwise, and ends within what it cannot tell apart
    apart = abs(points["value"] - upright["value"])
    assert bool((apart < upright["sd"]).all())
    assert float(apart.max()) < 0.01


def test_the_folder_lives_as_long_as_the_recording_or_a_fit_of_it(arrays: dict[str, Any]) -> None:
    """Nothing is left behind."""
    rec = maquette.Recording.from_arrays(**arrays, fps=50.0)
    folder = rec.path
    fit = rec.fit(body="human-ellipsoids", joint=False)
    del rec
    assert folder.is_dir()
    del fit
    assert not folder.exists()


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"K": np.eye(3)}, r"K: expected shape \(4, 3, 3\)"),
        ({"t": np.zeros((4, 3, 1))}, r"t: expected shape \(4, 3\)"),
        ({"distortion": [np.zeros(4)]}, "distortion: expected 4 rows"),
        ({"masks": [np.zeros((10, 4, 4), dtype=float)] * 4}, "expected bool or uint8"),
        ({"masks": {"a/b": np.zeros((10, 4, 4), dtype=bool)}}, "letters, digits"),
        ({"masks": None}, "found neither"),
        ({"detections": [np.zeros((10, 17, 3))]}, "detections: expected 4 arrays"),
        ({"detections": {"odd": np.zeros((10, 17, 3))}}, "no camera is named 'odd'"),
        ({"detections": {"cam_01": np.zeros((10, 17))}}, r"expected shape \(N, J, 3\) or"),
        ({"masks": None, "detections": [np.zeros((10, 17, 3))] * 4}, "size: expected the width"),
        ({"size": (640.5, 480)}, "size: expected whole numbers"),
    ],
)
def test_arrays_of_another_shape_are_refused(arrays: dict[str, Any], changed: dict[str, Any], line: str) -> None:
    """The line names the argument, what was expected and what was found."""
    with pytest.raises(maquette.OptionError, match=line):
        maquette.Recording.from_arrays(**(arrays | changed), fps=50.0)


def test_a_calibration_that_is_none_is_refused(arrays: dict[str, Any]) -> None:
    """By the program's own checks."""
    mirrored = arrays | {"R": arrays["R"] * [[1], [1], [-1]]}
    with pytest.raises(maquette.RecordingError, match="rotation"):
        maquette.Recording.from_arrays(**mirrored, fps=50.0).fit()


@pytest.fixture(scope="module")
def detections(fit: maquette.Fit, arrays: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Of the first twenty frames."""
    return dict(zip(arrays["masks"], detected(fit, arrays, 20), strict=True))


def test_detections_alone_give_the_fit_of_their_files(
    recording: pathlib.Path,
    arrays: dict[str, Any],
    detections: dict[str, NDArray[np.float64]],
    fit: maquette.Fit,
    tmp_path: pathlib.Path,
) -> None:
    """And lie where the joints are."""
    shutil.copy(recording / "calibration.toml", tmp_path)
    write_detections(tmp_path, detections)
    expected = maquette.Recording(tmp_path, fps=50.0).fit(body="human-ellipsoids")
    without_masks: dict[str, Any] = {**arrays, "masks": None}
    rec = maquette.Recording.from_arrays(
        **without_masks, detections=detections, keypoints="halpe26", size=(640, 480), fps=50.0
    )
    alone = rec.fit(body="human-ellipsoids")
    assert alone.usable
    assert alone.result["recording"]["frames"] == 20
    np.testing.assert_allclose(alone.lengths["length"], expected.lengths["length"], rtol=1e-4)
    np.testing.assert_allclose(alone.points["value"], expected.points["value"], atol=1e-4)
    apart = alone.points["value"].sel(joint="RKnee") - fit.points["value"].sel(joint="RKnee")[:20]
    assert float((apart**2).sum("axis").mean()) ** 0.5 < 0.05


def test_detections_beside_masks_are_used_and_other_people_are_not(
    arrays: dict[str, Any], detections: dict[str, NDArray[np.float64]]
) -> None:
    """Who stands outside the masks is nobody; a camera may have none."""

    def beside(name: str) -> NDArray[np.float64]:
        strange = np.where(np.isnan(detections[name]), np.nan, [5.0, 5.0, 0.9])
        strange[..., :2] += np.arange(26)[:, np.newaxis]
        return np.stack([strange, detections[name]], axis=1)

    names = list(detections)[:3]
    both = maquette.Recording.from_arrays(**arrays, detections={name: beside(name) for name in names}, fps=50.0)
    alone = maquette.Recording.from_arrays(**arrays, detections={name: detections[name] for name in names}, fps=50.0)
    lengths = [rec.fit(body="human-ellipsoids").lengths["length"] for rec in (both, alone)]
    assert lengths[0].equals(lengths[1])
    without = maquette.Recording.from_arrays(**arrays, fps=50.0).fit(body="human-ellipsoids")
    assert not lengths[0].equals(without.lengths["length"])


def test_joints_of_no_known_set_are_refused(arrays: dict[str, Any], detections: dict[str, NDArray[np.float64]]) -> None:
    """By the program's own line."""
    fewer = {name: array[:, :12] for name, array in detections.items()}
    rec = maquette.Recording.from_arrays(**arrays, detections=fewer, fps=50.0)
    with pytest.raises(maquette.RecordingError, match="people of 12 points"):
        rec.fit()
