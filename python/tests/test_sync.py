"""When cameras began is what the program finds."""

from __future__ import annotations

import json
import pathlib
import shutil

import pytest
from conftest import Program

import maquette


def test_offsets_of_a_fit_are_the_programs(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """Byte for byte, and every number of every camera; what is not known is not a number."""
    offsets = maquette.sync(fitted_folder, out=tmp_path / "package.toml")
    told = program("sync", fitted_folder, "--out", tmp_path / "program.toml", "--json", "--quiet")
    assert offsets.file == tmp_path / "package.toml"
    assert offsets.file.read_bytes() == (tmp_path / "program.toml").read_bytes()

    expected = json.loads(told.stdout)
    table = offsets.cameras
    assert list(table.index) == [part["camera"] for part in expected["cameras"]]
    for part in expected["cameras"]:
        row = {column: table[column].to_dict()[part["camera"]] for column in table.columns}
        for column, key in (
            ("offset", "offset_frames"),
            ("sd", "sd_frames"),
            ("was", "was_frames"),
            ("sd_ms", "sd_ms"),
        ):
            assert row[column] == part[key] or (row[column] != row[column] and part[key] is None)
        assert row["kept"] == part["kept"]
    assert bool(table["sd"].notna().any())
    assert offsets.reference == expected["reference"]
    assert offsets.fps == 50.0
    assert offsets.notes == expected["notes"]
    assert table.attrs["units"]["offset"] == "frames"
    assert table.attrs["units"]["drift_sd"] == "ppm"


def test_a_recording_that_is_synchronised_is_fitted_so(recording: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """The file stands in its folder; one camera is three frames late, and the next fit knows it."""
    late = tmp_path / "late"
    shutil.copytree(recording, late)
    masks = sorted((late / "masks" / "cam_02").iterdir())
    for path in masks:
        path.rename(path.with_name(f"{int(path.stem) + 3:06}.old"))
    for path in sorted((late / "masks" / "cam_02").iterdir()):
        path.rename(path.with_suffix(".png"))

    rec = maquette.Recording(late, fps=50.0)
    offsets = maquette.sync(rec, body="human-ellipsoids", sound=False)
    found = offsets.cameras["offset"].to_dict()["cam_02"]
    assert abs(found + 3.0) < 0.3
    assert offsets.file == late / "offsets.toml"
    with pytest.raises(maquette.OptionError, match="stands already"):
        maquette.sync(rec)
    fit = rec.fit(body="human-ellipsoids", frames=(0, 9), joint=False)
    stated = dict(zip(fit.result["recording"]["cameras"], fit.result["recording"]["offset_frames"], strict=True))
    assert stated["cam_02"] == pytest.approx(found, abs=0.001)


def test_windows_that_have_no_room_are_refused(
    recording: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """With the program's line."""
    with pytest.raises(maquette.errors.FitError, match="windows of 100 frames") as fault:
        maquette.sync(recording, windows=5, out=tmp_path / "offsets.toml")
    told = program("sync", recording, "--windows", "5", "--out", tmp_path / "offsets.toml", "--quiet")
    assert told.stderr == f"error: {fault.value}\n"
