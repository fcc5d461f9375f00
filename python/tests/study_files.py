"""Studies of small synthetic walks, for tests."""

from __future__ import annotations

import pathlib
import time
from typing import Any

import fsspec
from fsspec.implementations.local import LocalFileSystem

import maquette
from maquette import study
from maquette.study import Task
from maquette.study._task import Status

# Of 8 frames two are keyframes.
HEAD = 'results = "results"\n\n[fit]\nbody = "human-ellipsoids"\nkeyframe_every = 4\n'
OF_SESSIONS = 'unit = "session"\nresults = "results"\n\n[fit]\nbody = "human-ellipsoids"\n'


def walks(folder: pathlib.Path, count: int) -> pathlib.Path:
    """A folder of so many walks of 8 frames before 3 cameras."""
    for number in range(count):
        maquette.synth(folder / f"{number}", seed=100 + number, cameras=3, frames=8)
    return folder


def written(folder: pathlib.Path, *rows: str, head: str = HEAD, columns: str = "trial,recording") -> study.Study:
    """A study of these rows of its table."""
    (folder / "trials.csv").write_text("\n".join([columns, *rows]) + "\n", encoding="utf-8")
    (folder / "study.toml").write_text(head, encoding="utf-8")
    return study.read(folder / "study.toml")


def contents(cohort: study.Study) -> dict[str, bytes]:
    """All files of the fits but those that tell how long it took."""
    fits = pathlib.Path(cohort.results, "fits")
    files = (path for path in fits.rglob("*") if path.is_file() and path.name != "outcome.json")
    return {str(path.relative_to(fits)): path.read_bytes() for path in files}


def nothing(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """In the place of a fit."""
    return "usable", None


def all_memory(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """A fit that needs more than there is."""
    held: list[bytes] = []
    while True:
        held.append(b"x" * (50 << 20))


def unlucky(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """A file system that fails once for each task."""
    once = pathlib.Path(task.results).with_name(f"once_{task.name}")
    if not once.exists():
        once.touch()
        raise OSError(f"{once.name}: input/output error")
    return "usable", None


class SlowFileSystem(LocalFileSystem):  # type: ignore[misc]
    """A disk behind a slow network: `slow:///path`."""

    protocol = "slow"

    def cat_file(self, path: str, *arguments: Any, **options: Any) -> Any:
        """Read a file."""
        time.sleep(0.3)
        return super().cat_file(path, *arguments, **options)

    def pipe_file(self, path: str, *arguments: Any, **options: Any) -> Any:
        """Write a file."""
        time.sleep(0.3)
        return super().pipe_file(path, *arguments, **options)


fsspec.register_implementation("slow", SlowFileSystem, clobber=True)
