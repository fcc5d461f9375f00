"""A refined calibration is the program's."""

from __future__ import annotations

import json
import pathlib
import shutil

import numpy as np
import pytest
from conftest import Program
from projected import cameras_of, detected, write_detections

import maquette


def test_a_calibration_of_a_fit_is_the_programs(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """Byte for byte, and every number of every camera."""
    calibration = maquette.calibrate([fitted_folder], out=tmp_path / "package.toml")
    told = program("calibrate", fitted_folder, "--out", tmp_path / "program.toml", "--json", "--quiet")
    assert calibration.files == [tmp_path / "package.toml"]
    assert (tmp_path / "package.toml").read_bytes() == (tmp_path / "program.toml").read_bytes()

    expected = json.loads(told.stdout)["cameras"]
    table = calibration.cameras
    assert list(table.index) == [part["camera"] for part in expected]
    moved = [part for part in expected if part["turn_deg"] is not None]
    assert moved
    for part in moved:
        camera = part["camera"]
        assert [table[f"turn_{axis}"].to_dict()[camera] for axis in "xyz"] == part["turn_deg"]
        spreads = [table[f"displacement_{axis}_sd"].to_dict()[camera] for axis in "xyz"]
        assert spreads == part["displacement_sd_m"]
        assert [table[key].to_dict()[camera] for key in ("zoom", "zoom_sd")] == [part["zoom"], part["zoom_sd"]]
    assert table.attrs["units"]["turn_x_sd"] == "deg"
    assert table.attrs["units"]["displacement_z"] == "m"


def test_a_file_that_stands_there_is_left_alone(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """Unless somebody says otherwise."""
    out = tmp_path / "rig.toml"
    out.write_text("mine")
    with pytest.raises(maquette.OptionError) as fault:
        maquette.calibrate([fitted_folder], out=out)
    assert program("calibrate", fitted_folder, "--out", out).stderr == f"error: {fault.value}\n"
    maquette.calibrate([fitted_folder], out=out, overwrite=True)
    assert out.read_text() != "mine"


def test_cameras_of_lenses_alone_are_placed_by_a_distance(
    recording: pathlib.Path, fit: maquette.Fit, tmp_path: pathlib.Path, program: Program
) -> None:
    """As the program places them; the two cameras stand so far apart."""
    cameras = cameras_of(recording / "calibration.toml")
    walk = tmp_path / "walk"
    names = sorted(path.name for path in (recording / "masks").iterdir())
    write_detections(walk, dict(zip(names, detected(fit, cameras, 64), strict=True)))
    shutil.copy(recording / "calibration.toml", walk)
    places = [-turn.T @ way for turn, way in zip(cameras["R"], cameras["t"], strict=True)]
    apart = round(float(np.linalg.norm(places[0] - places[2])), 3)

    made = maquette.calibrate(
        [walk],
        out=tmp_path / "package.toml",
        from_="lenses",
        distance=("cam_01", "cam_03", apart),
        fps=50.0,
        body="human-ellipsoids",
    )
    words = f"--from lenses --distance cam_01 cam_03 {apart} --fps 50 --body human-ellipsoids --quiet"
    told = program("calibrate", walk, "--out", tmp_path / "program.toml", *words.split())
    assert told.returncode == 0, told.stderr
    assert made.files[0].read_bytes() == (tmp_path / "program.toml").read_bytes()
    found = cameras_of(made.files[0])
    stand = [-turn.T @ way for turn, way in zip(found["R"], found["t"], strict=True)]
    assert abs(float(np.linalg.norm(stand[0] - stand[2])) - apart) < 0.02


def test_a_distance_of_a_calibration_is_refused(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """With the program's line."""
    with pytest.raises(maquette.OptionError, match="for --from lenses") as fault:
        maquette.calibrate([fitted_folder], out=tmp_path / "rig.toml", distance=("cam_01", "cam_02", 3.0))
    words = ["--distance", "cam_01", "cam_02", "3", "--quiet"]
    told = program("calibrate", fitted_folder, "--out", tmp_path / "rig.toml", *words)
    assert told.stderr == f"error: {fault.value}\n"
