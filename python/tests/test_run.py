"""How a run is watched and stopped."""

from __future__ import annotations

import itertools
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pytest

import maquette
from maquette import _progress


def test_a_callable_hears_of_every_stage_to_its_end(recording: pathlib.Path) -> None:
    """On the thread that called, with steps that only grow."""
    heard: list[tuple[str, int, int]] = []
    threads: set[int] = set()

    def progress(stage: str, done: int, steps: int) -> None:
        heard.append((stage, done, steps))
        threads.add(threading.get_ident())

    maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9), progress=progress)
    assert threads == {threading.get_ident()}
    stages = list(dict.fromkeys(stage for stage, _, _ in heard))
    assert stages[:3] == ["reading masks", "keyframes", "hypotheses"]
    assert ("reading masks", 10, 10) in heard
    assert all(done <= steps for _, done, steps in heard)
    # a stage goes on, or begins
    for (before, was, _), (stage, done, _) in itertools.pairwise(heard):
        assert done == 0 or (stage == before and done > was)


def test_news_of_a_run_is_logged(
    recording: pathlib.Path, tmp_path: pathlib.Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Under the package's name; a step of a stopped run that was changed is news."""
    rec = maquette.Recording(recording)
    out = tmp_path / "out"

    def progress(stage: str, done: int, steps: int) -> None:
        if stage == "hypotheses":
            raise LookupError

    with pytest.raises(LookupError):
        rec.fit(body="human-ellipsoids", frames=(0, 9), out=out, progress=progress)
    kept = sorted(out.glob(".journal/keyframe-*.json"))[0]
    kept.write_text(kept.read_text().replace("1", "2", 1))
    with caplog.at_level("INFO", logger="maquette"):
        rec.fit(body="human-ellipsoids", frames=(0, 9), out=out, existing="resume")
    assert [record.name for record in caplog.records] == ["maquette"]
    assert f"{kept.name}: changed since this run wrote it" in caplog.text


def test_what_a_callable_raises_stops_the_run(recording: pathlib.Path) -> None:
    """And comes out of it."""

    def progress(stage: str, done: int, steps: int) -> None:
        raise LookupError(stage)

    with pytest.raises(LookupError, match="reading masks"):
        maquette.Recording(recording).fit(body="human-ellipsoids", progress=progress)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_stops_a_run_that_can_be_continued(
    recording: pathlib.Path, tmp_path: pathlib.Path, fit: maquette.Fit
) -> None:
    """The continued run gives the bytes of one that was not stopped."""
    rec = maquette.Recording(recording)
    sent: list[float] = []

    def progress(stage: str, done: int, steps: int) -> None:
        if stage == "hypotheses" and done > 0 and not sent:
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        rec.fit(body="human-ellipsoids", out=tmp_path / "out", progress=progress)
    assert time.monotonic() - sent[0] < 5
    assert not (tmp_path / "out" / "result.json").exists()
    again = rec.fit(body="human-ellipsoids", out=tmp_path / "out", existing="resume")
    assert again.json == fit.json


def test_other_threads_of_python_run_meanwhile(recording: pathlib.Path) -> None:
    """The interpreter's lock is free."""
    ticks = 0
    ended = threading.Event()

    def count() -> None:
        nonlocal ticks
        while not ended.wait(0.01):
            ticks += 1

    other = threading.Thread(target=count)
    other.start()
    start = time.monotonic()
    maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9), threads=1)
    seconds = time.monotonic() - start
    ended.set()
    other.join()
    # a hundred ticks a second, less what a busy machine takes
    assert ticks > 20 * seconds


def test_a_run_imports_no_package_that_it_does_not_need(recording: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """NumPy and the like take longer to import than a call may cost."""
    script = (
        "import sys, maquette\n"
        f"maquette.Recording({str(recording)!r}).fit(body='human-ellipsoids', frames=(0, 9), joint=False)\n"
        "print(sorted({'numpy', 'pandas', 'xarray', 'matplotlib', 'tqdm'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


def test_bars_go_to_the_end_of_each_stage(recording: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By tqdm, on standard error."""
    pytest.importorskip("tqdm")
    maquette.Recording(recording).fit(body="human-ellipsoids", frames=(0, 9), progress=True)
    shown = capsys.readouterr()
    assert "reading masks: 100%" in shown.err
    assert shown.out == ""


def test_without_tqdm_a_line_names_each_stage(capsys: pytest.CaptureFixture[str]) -> None:
    """Once."""
    lines = _progress.Lines()
    for done in range(3):
        lines("keyframes", done, 3)
    assert capsys.readouterr().err == "keyframes (3 steps)\n"


@pytest.mark.parametrize(
    ("package", "call"),
    [
        ("pandas", "fit.lengths"),
        ("xarray", "fit.angles"),
        ("matplotlib", "fit.plot()"),
    ],
)
def test_a_missing_package_is_named_with_what_installs_it(fitted_folder: pathlib.Path, package: str, call: str) -> None:
    """And everything else works without it."""
    script = (
        f"import sys; sys.modules[{package!r}] = None\n"
        f"import maquette; fit = maquette.load({str(fitted_folder)!r})\n"
        f"assert fit.usable\n"
        f"try: {call}\n"
        f"except maquette.errors.MissingPackageError as fault: print(fault)"
    )
    run = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True)
    extra = "plot" if package == "matplotlib" else package
    assert run.stdout == f"{package} is not installed: pip install 'maquette[{extra}]'\n"
