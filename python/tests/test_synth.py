"""Synthetic recordings are the program's."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import pytest
from conftest import Program

import maquette


@pytest.mark.parametrize(
    ("options", "words", "holds"),
    [
        (
            {"cameras": 2, "noise": "none", "make": "flesh"},
            "--cameras 2 --noise none --make flesh",
            "masks/cam_02/000002.png",
        ),
        (
            {"cameras": 2, "trial": 4, "fps": 40.0, "treadmill": True, "points": True, "body": "human-metaballs"},
            "--cameras 2 --trial 4 --fps 40 --treadmill --points --body human-metaballs",
            "points/000002.ply",
        ),
        ({"clutter": True}, "--clutter", "truth/masks/center/000002.png"),
    ],
    ids=["make", "points", "clutter"],
)
def test_a_synthetic_recording_is_the_programs(
    tmp_path: pathlib.Path, program: Program, options: dict[str, Any], words: str, holds: str
) -> None:
    """File by file, with every option."""
    folder = maquette.synth(tmp_path / "package", seed=9, frames=3, **options)
    told = program("synth", tmp_path / "program", *f"--seed 9 --frames 3 --quiet {words}".split())
    assert told.returncode == 0, told.stderr
    made = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert pathlib.Path(holds) in made
    for path in made:
        assert (folder / path).read_bytes() == (tmp_path / "program" / path).read_bytes()


def test_who_walks_on_a_treadmill_stays(tmp_path: pathlib.Path) -> None:
    """Who walks on the floor does not."""

    def way(folder: pathlib.Path) -> float:
        places = json.loads((folder / "truth.json").read_text())["root_position_m"]
        return abs(float(places[-1][0]) - float(places[0][0]))

    assert way(maquette.synth(tmp_path / "belt", cameras=1, frames=20, treadmill=True)) < 0.1
    assert way(maquette.synth(tmp_path / "floor", cameras=1, frames=20)) > 0.3


def test_a_folder_that_holds_something_is_refused(tmp_path: pathlib.Path) -> None:
    """As are options that exclude each other."""
    maquette.synth(tmp_path, cameras=1, frames=1)
    with pytest.raises(maquette.MaquetteError, match="not empty"):
        maquette.synth(tmp_path)
    with pytest.raises(maquette.OptionError, match="--clutter"):
        maquette.synth(tmp_path / "odd", clutter=True, points=True)
