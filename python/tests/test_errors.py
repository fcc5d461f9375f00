"""What goes wrong is an exception with the program's line."""

from __future__ import annotations

import pathlib
import pickle
import shutil
from typing import Any

import pytest
from conftest import Program

import maquette
from maquette import errors


def test_a_recording_that_does_not_exist_is_refused_when_it_is_named(tmp_path: pathlib.Path, program: Program) -> None:
    """Before anything is fitted."""
    nowhere = tmp_path / "nowhere"
    with pytest.raises(maquette.RecordingError) as fault:
        maquette.Recording(nowhere)
    told = program("fit", nowhere, "--out", tmp_path / "out")
    assert told.stderr == f"error: {fault.value}\n"


@pytest.mark.parametrize(
    ("options", "words", "kind"),
    [
        ({"cameras": "doubt"}, ["--cameras=doubt"], errors.OptionError),
        ({"people": 0}, ["--people=0"], errors.OptionError),
        ({"body": "nobody"}, ["--body=nobody"], errors.BodyError),
        ({"frames": (900, 1000)}, ["--frames=900:1000"], errors.RecordingError),
        ({"frames": (9, 1)}, ["--frames=9:1"], errors.OptionError),
        ({"keyframe_every": 0}, ["--keyframe-every=0"], errors.FitError),
    ],
)
def test_the_line_is_the_programs(
    recording: pathlib.Path,
    tmp_path: pathlib.Path,
    program: Program,
    options: dict[str, Any],
    words: list[str],
    kind: type[Exception],
) -> None:
    """Whatever is asked for."""
    with pytest.raises(kind) as fault:
        maquette.Recording(recording).fit(**options)
    told = program("fit", recording, "--out", tmp_path / "out", "--quiet", *words)
    assert told.returncode == 2
    assert told.stderr == f"error: {fault.value}\n"
    assert isinstance(fault.value, maquette.MaquetteError)


def test_masks_that_cannot_be_read_are_named(recording: pathlib.Path, tmp_path: pathlib.Path, program: Program) -> None:
    """The file stands in the line."""
    odd = tmp_path / "odd"
    shutil.copytree(recording, odd)
    mask = sorted(odd.glob("masks/*/*.png"))[3]
    mask.write_bytes(b"no picture")
    with pytest.raises(maquette.RecordingError, match=mask.name) as fault:
        maquette.Recording(odd).fit()
    told = program("fit", odd, "--out", tmp_path / "out", "--quiet")
    assert told.stderr == f"error: {fault.value}\n"


def test_a_frame_rate_that_is_none_is_refused(recording: pathlib.Path) -> None:
    """As the program refuses it."""
    with pytest.raises(maquette.RecordingError, match=r"frame rate|frames per second"):
        maquette.Recording(recording, fps=-1.0).fit()


def test_a_folder_without_a_result_is_refused(tmp_path: pathlib.Path) -> None:
    """The line says what is expected."""
    with pytest.raises(maquette.ResultError, match="expected the folder of a finished"):
        maquette.load(tmp_path)


def test_a_changed_result_is_refused(fitted_folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """One digit is enough."""
    changed = tmp_path / "changed"
    shutil.copytree(fitted_folder, changed)
    text = (changed / "result.json").read_text()
    (changed / "result.json").write_text(text.replace('"length_m": 0.4', '"length_m": 0.5', 1))
    assert (changed / "result.json").read_text() != text
    with pytest.raises(maquette.ResultError, match="changed since"):
        maquette.load(changed)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        ("fit.export('docx', 'a.docx')", "docx"),
        ("fit.export('c3d', 'a.trc')", "a.trc"),
        ("fit.plot('knee')", "knee_flexion_r"),
        ("fit.gait(surface='sand')", "sand"),
    ],
)
def test_names_that_do_not_exist_are_value_errors(fit: maquette.Fit, call: str, named: str) -> None:
    """The line names them, or those that do."""
    with pytest.raises(ValueError, match=named) as fault:
        eval(call, {"fit": fit})
    assert isinstance(fault.value, maquette.OptionError)


def test_errors_can_be_pickled() -> None:
    """A worker hands them back."""
    fault = pickle.loads(pickle.dumps(errors.RecordingError("a line")))
    assert isinstance(fault, errors.RecordingError)
    assert str(fault) == "a line"
