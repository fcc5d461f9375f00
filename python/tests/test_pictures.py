"""What is made of pictures is the program's, file by file."""

from __future__ import annotations

import pathlib
import shutil
from collections.abc import Callable
from typing import Any

import pytest
from conftest import Program

import maquette


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """Three frames of a person before clutter."""
    return maquette.synth(tmp_path_factory.mktemp("clutter") / "photographs", clutter=True, frames=3)


@pytest.fixture(scope="module")
def fit_to_true_masks(tmp_path_factory: pytest.TempPathFactory, photographs: pathlib.Path) -> pathlib.Path:
    """The folder of a quick fit."""
    masked = tmp_path_factory.mktemp("clutter") / "masked"
    shutil.copytree(photographs / "truth" / "masks", masked / "masks")
    shutil.copy(photographs / "calibration.toml", masked)
    rec = maquette.Recording(masked, fps=25.0)
    options: dict[str, Any] = {"likelihood": "ellipses", "joint": False, "frames": (0, 0)}
    return rec.fit(body="human-metaballs", out=masked / "fit", **options).folder


def _files(folder: pathlib.Path) -> dict[pathlib.Path, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file() and not path.name.startswith("."))
    return {path.relative_to(folder): path.read_bytes() for path in files}


@pytest.mark.parametrize(
    ("call", "options", "words", "holds"),
    [
        (
            maquette.segment,
            {"frames": (0, 1), "probability": True, "overlays": True, "threads": 1},
            "segment --frames 0:1 --probability --overlays",
            "probability/left/000001.png",
        ),
        (
            maquette.stereo,
            {
                "frames": (0, 0),
                "method": "correlation",
                "cameras": ("left", "center"),
                "depth": (2.0, 5.5),
                "pictures": True,
                "progress": True,
            },
            "stereo --frames 0:0 --method correlation --cameras left,center --depth 2:5.5 --pictures",
            "points/000000.ply",
        ),
    ],
    ids=["segment", "stereo"],
)
@pytest.mark.filterwarnings("ignore::maquette.MaquetteWarning")
def test_files_are_the_programs(
    photographs: pathlib.Path,
    tmp_path: pathlib.Path,
    program: Program,
    call: Callable[..., pathlib.Path],
    options: dict[str, Any],
    words: str,
    holds: str,
) -> None:
    """With the options of the command."""
    folder = call(maquette.Recording(photographs), out=tmp_path / "package", **options)
    command, *rest = words.split()
    told = program(command, photographs, "--out", tmp_path / "program", *rest, "--quiet")
    assert told.returncode == 0, told.stderr
    files = _files(folder)
    assert pathlib.Path(holds) in files
    assert files == _files(tmp_path / "program")


def test_silhouettes_are_the_programs(
    photographs: pathlib.Path, fit_to_true_masks: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """From a fit on."""
    options: dict[str, Any] = {"pipeline": "simple", "fit": fit_to_true_masks, "frames": (0, 0), "overlays": True}
    folder = maquette.silhouettes(photographs, out=tmp_path / "package", **options)
    words = ["--pipeline", "simple", "--frames", "0:0", "--overlays", "--quiet"]
    told = program("silhouettes", photographs, "--out", tmp_path / "program", "--fit", fit_to_true_masks, *words)
    assert told.returncode == 0, told.stderr
    files = _files(folder)
    assert pathlib.Path("contours/left/000000.json") in files
    assert files == _files(tmp_path / "program")


def test_what_a_person_should_know_is_warned_of(photographs: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """As the program notes it, at the line that has called."""
    odd = tmp_path / "odd"
    shutil.copytree(photographs, odd)
    sorted((odd / "images" / "left").iterdir())[1].write_bytes(b"no picture")
    with pytest.warns(maquette.MaquetteWarning) as caught:
        maquette.segment(odd, out=tmp_path / "out")
    assert any("camera left" in str(warning.message) for warning in caught)
    assert {warning.filename for warning in caught} == {__file__}


def test_what_cannot_be_done_is_an_exception_with_the_programs_line(
    recording: pathlib.Path, photographs: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """Masks are no pictures; a depth is two numbers; a folder that holds something is left alone."""
    with pytest.raises(maquette.RecordingError, match="no pictures") as fault:
        maquette.segment(recording, out=tmp_path / "out")
    assert program("segment", recording, "--out", tmp_path / "out").stderr == f"error: {fault.value}\n"
    with pytest.raises(maquette.OptionError, match="NEAR:FAR"):
        maquette.stereo(photographs, out=tmp_path / "out", depth=(3.0, 2.0))
    with pytest.raises(maquette.MaquetteError, match="not empty"):
        maquette.silhouettes(photographs, out=photographs)
