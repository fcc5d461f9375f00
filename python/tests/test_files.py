"""What a fit is written into and read from, and what it looks like."""

from __future__ import annotations

import multiprocessing
import os
import pathlib
import pickle
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest
from conftest import PROGRAM, Program

import maquette
from maquette._fit import Format


def test_a_saved_fit_is_the_same_again(fit: maquette.Fit, tmp_path: pathlib.Path) -> None:
    """And the program's folder can be read."""
    again = maquette.load(fit.save(tmp_path / "saved"))
    assert again.json == fit.json
    assert again.lengths.equals(fit.lengths)
    assert again.angles.identical(fit.angles)


def test_a_fit_stays_where_it_is_when_the_working_directory_changes(
    fitted_folder: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A report finds the recording beside it."""
    monkeypatch.chdir(fitted_folder.parent)
    fit = maquette.load(fitted_folder.name)
    monkeypatch.chdir(tmp_path)
    assert fit.folder == fitted_folder
    # without its recording it would warn
    fit.report("report.html")
    assert (tmp_path / "report.html").is_file()


def test_a_pickled_fit_is_the_same_again(fit: maquette.Fit) -> None:
    """And still knows its recording."""
    again = pickle.loads(pickle.dumps(fit))
    assert isinstance(again, maquette.Fit)
    assert again.json == fit.json
    assert again.folder != fit.folder
    assert again.points.identical(fit.points)
    assert pickle.loads(pickle.dumps(again)).json == fit.json


def _thigh(fit: maquette.Fit) -> float:
    return float(fit.lengths["length"].to_dict()["thigh"])


def test_a_fit_goes_to_another_process(fit: maquette.Fit) -> None:
    """As Dask and multiprocessing send it."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(_thigh, (fit,)) == _thigh(fit)


def _surface(path: pathlib.Path) -> int:
    assert _forked is not None
    return len(list(_forked.export("ply", path).glob("*.ply")))


#: What a forked process finds in its memory.
_forked: maquette.Fit | None = None


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no fork here")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_does_not_wait_for_threads_that_it_lacks(fit: maquette.Fit, tmp_path: pathlib.Path) -> None:
    """Although its parent has worked on many threads before."""
    global _forked
    _forked = fit
    assert _surface(tmp_path / "parent") == len(fit.frames)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(_surface, (tmp_path / "child",)).get(timeout=60) == len(fit.frames)


def _numbered_anew(page: str) -> str:
    """A page without the numbers of clip paths, which a process counts on from chart to chart."""
    return re.sub(r"kuva-clip-\d+", "clip", page)


def test_the_report_is_the_programs(
    fit: maquette.Fit,
    recording: pathlib.Path,
    fitted_folder: pathlib.Path,
    tmp_path: pathlib.Path,
    program: Program,
) -> None:
    """With what the cameras saw, also of a fit that was pickled."""
    folder = tmp_path / "fit"
    shutil.copytree(fitted_folder, folder)
    words = ("--subject", "P 17", "--age", "40", "--sex", "female", "--date", "today")
    made = program("report", folder, "--recording", recording, *words, "--quiet")
    assert made.returncode == 0, made.stderr
    expected = _numbered_anew((folder / "report.html").read_text())

    again: maquette.Fit = pickle.loads(pickle.dumps(fit))
    for number, one in enumerate((fit, again)):
        path = tmp_path / f"{number}.html"
        one.report(path, subject="P 17", age=40, sex="female", date="today")
        assert _numbered_anew(path.read_text()) == expected


def test_a_report_without_its_recording_says_so(fitted_folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """And is written all the same."""
    folder = tmp_path / "fit"
    shutil.copytree(fitted_folder, folder)
    (folder / "recording.toml").write_text('path = "nowhere"\n')
    with pytest.warns(maquette.MaquetteWarning, match="the report is without camera views"):
        maquette.load(folder).report(tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size > 100_000


@pytest.mark.parametrize("format", ["c3d", "trc", "mot", "sto", "bvh", "glb", "csv", "parquet"])
def test_exports_are_the_programs(
    fit: maquette.Fit,
    fitted_folder: pathlib.Path,
    tmp_path: pathlib.Path,
    program: Program,
    format: Format,
) -> None:
    """Byte for byte."""
    folder = tmp_path / "fit"
    shutil.copytree(fitted_folder, folder)
    assert program("export", folder, "--format", format, "--quiet").returncode == 0
    path = fit.export(format, tmp_path / f"walk.{format}")
    assert path.read_bytes() == (folder / "export" / f"motion.{format}").read_bytes()


def test_a_surface_is_a_file_per_frame(fit: maquette.Fit, tmp_path: pathlib.Path) -> None:
    """In a folder."""
    folder = fit.export("ply", tmp_path / "skin")
    assert len(list(folder.glob("*.ply"))) == len(fit.frames)


def test_gait_files_are_the_programs(
    fit: maquette.Fit, fitted_folder: pathlib.Path, tmp_path: pathlib.Path, program: Program
) -> None:
    """All four."""
    program("gait", fitted_folder, "--out", tmp_path / "program", "--quiet")
    folder = fit.gait().save(tmp_path / "package")
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["angles.csv", "curves.csv", "gait.json", "parameters.csv"]
    for name in names:
        assert (folder / name).read_bytes() == (tmp_path / "program" / name).read_bytes()


def test_a_plot_has_a_curve_and_a_band_for_each_angle(fit: maquette.Fit) -> None:
    """Left and right of one angle together."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    figure = fit.plot("knee_flexion_r", "knee_flexion_l", "head_flexion")
    knees, head = figure.axes
    assert [len(axis.lines) for axis in (knees, head)] == [2, 1]
    assert [len(axis.collections) for axis in (knees, head)] == [2, 1]
    assert knees.get_ylabel() == "knee flexion (°)"
    value = fit.angles["value"].sel(angle="knee_flexion_r")
    np.testing.assert_allclose(np.asarray(knees.lines[0].get_ydata()), np.degrees(value))
    assert len(fit.plot().axes) == 3
    import matplotlib.pyplot as plt

    plt.close("all")


def test_a_notebook_shows_lengths_and_warnings(fit: maquette.Fit) -> None:
    """As HTML, escaped."""
    page = fit._repr_html_()
    assert f"<td>thigh</td><td>{100 * _thigh(fit):.1f}</td>" in page
    assert repr(fit) == "<Fit of human-ellipsoids: 64 frames of 4 cameras>"
    assert "step length" in fit.gait()._repr_html_()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_the_command_can_be_stopped_as_the_program(recording: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """With one line that says how to go on, and the exit code of the signal."""
    words: list[str | pathlib.Path] = [PROGRAM, "fit", recording, "--out", tmp_path / "out", "--quiet"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as run:
        while not (tmp_path / "out" / ".journal").exists():
            assert run.poll() is None
            time.sleep(0.05)
        run.send_signal(signal.SIGINT)
        _, told = run.communicate(timeout=30)
    assert run.returncode == 130
    assert told.startswith("stopped by SIGINT: what was finished is kept")
    assert len(told.splitlines()) == 1


def test_the_command_prints_and_ends_as_the_program_does(program: Program) -> None:
    """Its version, its help, and its faults."""
    version = program("--version")
    assert version.stdout == f"maquette {maquette.__version__}\n"
    assert version.returncode == 0
    assert "maquette fit" in program("--help").stdout
    odd = program("fit", "--nonsense")
    assert odd.returncode == 2
    assert odd.stderr.startswith("error: unexpected argument '--nonsense'")
    assert len(odd.stderr.splitlines()) == 1
