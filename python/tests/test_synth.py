"""Synthetic recordings are the program's."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import numpy as np
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


@pytest.fixture(scope="module")
def fit(recording: pathlib.Path) -> maquette.Fit:
    """A fit of a body with metaballs."""
    return maquette.Recording(recording).fit(body="human-metaballs", frames=(10, 29))


def test_a_simulated_fit_is_the_programs_and_looks_like_what_was_fitted(
    recording: pathlib.Path, fit: maquette.Fit, tmp_path: pathlib.Path, program: Program
) -> None:
    """Its true masks overlap the recorded ones as the fitted body does; frame 0 is the first that was fitted."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    folder = maquette.simulate(fit, tmp_path / "package", noise="none")
    kept = fit.save(tmp_path / "kept")
    words = ["--recording", str(recording), "--noise", "none", "--quiet"]
    told = program("simulate", kept, "--out", tmp_path / "program", *words)
    assert told.returncode == 0, told.stderr
    made = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(made) == 4 + 4 * 20
    for path in made:
        assert (folder / path).read_bytes() == (tmp_path / "program" / path).read_bytes()

    truth: dict[str, float] = json.loads((folder / "truth.json").read_text())["lengths_m"]
    # the trunk's are those of the first frame, in which it is bent
    limbs = ["thigh", "shank", "upper_arm", "forearm"]
    assert fit.lengths["length"][limbs].to_list() == pytest.approx([truth[limb] for limb in limbs], abs=1e-6)
    for camera, iou in fit.cameras["iou"].items():
        pairs = [
            [pyplot.imread(path / "masks" / str(camera) / f"{frame:06}.png") > 0 for path, frame in both]
            for both in [((folder, frame), (recording, frame + 10)) for frame in range(0, 20, 5)]
        ]
        overlaps = [(a & b).sum() / (a | b).sum() for a, b in pairs]
        assert np.mean(overlaps) > float(str(iou)) - 0.02


def test_a_fit_of_a_simulation_lies_where_its_standard_deviations_say(
    fit: maquette.Fit, tmp_path: pathlib.Path
) -> None:
    """The truth is the first fit; another seed makes other masks."""
    again = maquette.simulate(fit, tmp_path / "again")
    other = maquette.simulate(fit, tmp_path / "other", seed=2)
    mask = pathlib.Path("masks", "cam_01", "000003.png")
    assert (again / mask).read_bytes() != (other / mask).read_bytes()
    lengths = maquette.Recording(again).fit(body="human-metaballs").lengths
    off = (lengths["length"] - fit.lengths["length"]) / lengths["sd"]
    assert float((off**2).mean()) < 4.0


def test_a_body_without_a_skin_cannot_be_simulated(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """With the program's line."""
    with pytest.raises(maquette.MaquetteError, match="metaball") as fault:
        maquette.simulate(fitted_folder, tmp_path / "out")
    told = program("simulate", fitted_folder, "--out", tmp_path / "out")
    assert told.stderr == f"error: {fault.value}\n"


def test_a_folder_that_holds_something_is_refused(tmp_path: pathlib.Path) -> None:
    """As are options that exclude each other."""
    maquette.synth(tmp_path, cameras=1, frames=1)
    with pytest.raises(maquette.MaquetteError, match="not empty"):
        maquette.synth(tmp_path)
    with pytest.raises(maquette.OptionError, match="--clutter"):
        maquette.synth(tmp_path / "odd", clutter=True, points=True)
