"""A small recording, the program's own fit of it, and the package's."""

from __future__ import annotations

import pathlib
import subprocess
import sysconfig
from collections.abc import Callable

import pytest

import maquette

REPOSITORY = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(sysconfig.get_path("scripts")) / "maquette"

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def program() -> Program:
    """Run the command that the package brings."""

    def run(*words: str | pathlib.Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)

    return run


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory, program: Program) -> pathlib.Path:
    """A synthetic walk of 64 frames before four cameras."""
    folder = tmp_path_factory.mktemp("synthetic") / "walk"
    made = program("synth", folder, "--seed", "3", "--frames", "64", "--cameras", "4", "--quiet")
    assert made.returncode == 0, made.stderr
    return folder


@pytest.fixture(scope="session")
def fitted_folder(tmp_path_factory: pytest.TempPathFactory, program: Program, recording: pathlib.Path) -> pathlib.Path:
    """The folder that the program fits it into."""
    folder = tmp_path_factory.mktemp("program") / "walk"
    made = program("fit", recording, "--out", folder, "--body", "human-ellipsoids", "--quiet")
    assert made.returncode == 0, made.stderr
    return folder


@pytest.fixture(scope="session")
def fit(recording: pathlib.Path) -> maquette.Fit:
    """The package's fit of it, in memory."""
    return maquette.Recording(recording).fit(body="human-ellipsoids")
