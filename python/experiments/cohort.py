"""A cohort of small synthetic trials, as a study."""

from __future__ import annotations

import pathlib
import shutil
from concurrent.futures import ProcessPoolExecutor

import maquette
from maquette import study

#: Different walks; more trials are copies of these at another frame rate, so that no two are the same.
_WALKS = 20


def written(folder: pathlib.Path, count: int, results: str = "results") -> study.Study:
    """Write a cohort of so many trials of 3 cameras and 16 frames into an empty folder."""
    walks = folder / "walks"
    with ProcessPoolExecutor() as pool:
        made = list(pool.map(_walk, [walks / f"{n:03}" for n in range(min(count, _WALKS))], range(_WALKS)))
    for n in range(_WALKS, count):
        shutil.copytree(made[n % _WALKS], walks / f"{n:03}")
    rows = [f"t{n:03},walks/{n:03},{50 + n // _WALKS}" for n in range(count)]
    (folder / "trials.csv").write_text("\n".join(["trial,recording,fit.fps", *rows]) + "\n", encoding="utf-8")
    stated = f'results = "{results}"\n\n[fit]\nbody = "human-ellipsoids"\n'
    (folder / "study.toml").write_text(stated, encoding="utf-8")
    return study.read(folder / "study.toml")


def _walk(folder: pathlib.Path, number: int) -> pathlib.Path:
    return maquette.synth(folder, seed=100 + number, cameras=3, frames=16)
