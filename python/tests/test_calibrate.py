"""A refined calibration is the program's."""

from __future__ import annotations

import json
import pathlib

import pytest
from conftest import Program

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
