"""Skins are the program's."""

from __future__ import annotations

import pathlib
import shutil

import pytest
from conftest import Program

import maquette


@pytest.fixture(scope="module")
def fit(recording: pathlib.Path) -> maquette.Fit:
    """A quick fit of a body with metaballs, in memory."""
    rec = maquette.Recording(recording)
    return rec.fit(body="human-metaballs", frames=(0, 4), likelihood="ellipses", joint=False)


def test_skins_are_the_programs(fit: maquette.Fit, tmp_path: pathlib.Path, program: Program) -> None:
    """Of a fit in memory they stand beside its result; byte for byte."""
    folder = maquette.skin(fit, frame=2, picture=True, around=48)
    assert folder == fit.folder / "skin"
    kept = fit.save(tmp_path / "kept")
    told = program("skin", kept, "--frame", "2", "--around", "48", "--quiet")
    assert told.returncode == 0, told.stderr
    made = sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))
    assert made == ["frame_000002.ply", "frame_000002.png"]
    mesh = "frame_000002.ply"
    assert (folder / mesh).read_bytes() == (kept / "skin" / mesh).read_bytes()
    shutil.rmtree(folder)


def test_a_folder_has_skins_of_some_frames_or_of_rest(fit: maquette.Fit, tmp_path: pathlib.Path) -> None:
    """In the formats there are."""
    kept = fit.save(tmp_path / "kept")
    folder = maquette.skin(kept, frames=(1, 2), format="obj")
    assert (folder / "frame_000001.obj").read_text().count("\nv ") > 1000
    assert (maquette.skin(kept, rest=True) / "rest.ply").is_file()


def test_a_body_without_a_skin_and_odd_options_are_refused(
    fitted_folder: pathlib.Path, fit: maquette.Fit, program: Program
) -> None:
    """With the program's line."""
    with pytest.raises(maquette.MaquetteError) as fault:
        maquette.skin(fitted_folder)
    assert program("skin", fitted_folder, "--quiet").stderr == f"error: {fault.value}\n"
    with pytest.raises(maquette.OptionError, match="--rest"):
        maquette.skin(fit, frame=1, rest=True)
