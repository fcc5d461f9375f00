"""Masks and cameras in memory make the recording that they would make as files."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import maquette

plt = pytest.importorskip("matplotlib.pyplot")


def _matrix_of(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn: NDArray[np.float64] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return turn


@pytest.fixture(scope="module")
def arrays(recording: pathlib.Path) -> dict[str, Any]:
    """What the synthetic recording holds, of its first ten frames."""
    names = sorted(path.name for path in (recording / "masks").iterdir())
    text = (recording / "calibration.toml").read_text()

    def numbers(key: str) -> NDArray[np.float64]:
        found = re.findall(rf"^{key} = (\[.*?\])$", text, flags=re.DOTALL | re.MULTILINE)
        return np.array([eval(value) for value in found], dtype=np.float64)

    def masks(name: str) -> NDArray[np.bool_]:
        paths = sorted((recording / "masks" / name).glob("*.png"))[:10]
        return np.array([plt.imread(path) > 0 for path in paths])

    return {
        "masks": {name: masks(name) for name in names},
        "K": numbers("matrix"),
        "R": np.array([_matrix_of(vector) for vector in numbers("rotation")]),
        "t": numbers("translation"),
        "distortion": list(numbers("distortions")),
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
