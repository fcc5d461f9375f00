"""A fit from Python is the program's."""

from __future__ import annotations

import json
import pathlib
import shutil
import warnings

import pytest
from conftest import Program

import maquette


def test_the_result_is_the_programs_byte_for_byte(fit: maquette.Fit, fitted_folder: pathlib.Path) -> None:
    """In memory, and with the files that it leaves."""
    written = (fitted_folder / "result.json").read_bytes()
    assert fit.json == written
    assert (fit.folder / "joints.trc").read_bytes() == (fitted_folder / "joints.trc").read_bytes()


def test_every_option_is_the_programs(recording: pathlib.Path, tmp_path: pathlib.Path, program: Program) -> None:
    """Those that change the result are in it; the same words give the same bytes."""
    short = maquette.Recording(recording, fps=40.0).fit(
        body="human-ellipsoids",
        cameras="check",
        clocks="trust",
        frames=(10, 24),
        height=1.8,
        keyframe_every=7,
        likelihood="published",
        joint=False,
        pruning=False,
        fit_to="silhouettes",
        people=1,
        person=1,
        threads=1,
    )
    words = (
        "--fps 40 --body human-ellipsoids --cameras check --clocks trust --frames 10:24 --height 1.8"
        " --keyframe-every 7 --likelihood published --joint off --no-pruning --fit-to silhouettes"
        " --people 1 --person 1 --threads 2 --quiet"
    )
    program("fit", recording, "--out", tmp_path / "out", *words.split())
    written = (tmp_path / "out" / "result.json").read_bytes()
    assert short.json == written
    options = json.loads(written)["options"]
    assert options["estimate"]["joint"] is None
    assert options["estimate"]["height_m"] == 1.8
    assert list(short.frames) == list(range(10, 25))
    assert short.fps == 40.0


def test_a_result_without_the_joint_optimum_has_no_standard_deviations(
    recording: pathlib.Path,
) -> None:
    """They are not numbers, and the covariance is None."""
    short = maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9), joint=False)
    assert short.covariance is None
    assert bool(short.lengths["sd"].isna().all())
    assert bool(short.angles["sd"].isnull().all())
    assert bool(short.points["value"].notnull().all())


def test_a_folder_is_written_continued_and_replaced_as_asked(recording: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """A folder that holds a result is left alone unless somebody says otherwise."""
    rec = maquette.Recording(recording)
    first = rec.fit(body="human-ellipsoids", frames=(0, 9), out=tmp_path / "out", overlays=True)
    assert (tmp_path / "out" / "overlays").is_dir()
    assert first.folder == tmp_path / "out"
    with pytest.raises(maquette.errors.OutputError, match="not empty"):
        rec.fit(body="human-ellipsoids", frames=(0, 9), out=tmp_path / "out")
    again = rec.fit(body="human-ellipsoids", frames=(0, 9), out=tmp_path / "out", existing="overwrite")
    assert again.json == first.json


def test_a_fit_that_cannot_be_used_warns_and_withholds_its_numbers(
    recording: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """Cameras that are exchanged: the verdict is the program's line."""
    odd = tmp_path / "odd"
    shutil.copytree(recording, odd)
    masks = sorted((odd / "masks").iterdir())
    for path in masks:
        path.rename(path.with_suffix(".moved"))
    for path, other in zip(masks, masks[1:] + masks[:1], strict=True):
        path.with_suffix(".moved").rename(other)

    with pytest.warns(maquette.MaquetteWarning) as caught:
        fit = maquette.Recording(odd).fit(body="human-ellipsoids", frames=(0, 9))
    assert not fit.usable
    assert fit.why_unusable in [str(warning.message) for warning in caught]
    with pytest.raises(maquette.UnusableError) as verdict:
        _ = fit.lengths
    with pytest.raises(maquette.UnusableError):
        _ = fit.angles
    assert "Not to be used" in fit._repr_html_()
    words = ("--body", "human-ellipsoids", "--frames", "0:9", "--out", str(tmp_path / "out"))
    told = program("fit", odd, *words, "--quiet")
    assert told.returncode == 3
    assert f"error: {verdict.value}" in told.stderr.splitlines()


def test_a_usable_fit_does_not_warn(recording: pathlib.Path) -> None:
    """What a person should know stands in the result."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit = maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9))
    assert fit.usable
    assert fit.warnings == fit.result["warnings"]


def test_the_temporary_folder_goes_with_the_fit(recording: pathlib.Path) -> None:
    """And not before."""
    fit = maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9), joint=False)
    folder = fit.folder
    assert (folder / "result.json").is_file()
    del fit
    assert not folder.exists()
