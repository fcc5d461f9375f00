"""Small trials by two workers of Dask, and by two programs started by hand.

Both do the same fits, block by block in turn, so that what else the machine does meets both.
"""

from __future__ import annotations

import argparse
import dataclasses
import pathlib
import subprocess
import sysconfig
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

from cohort import written
from distributed import Client, LocalCluster

from maquette import study

_PROGRAM = pathlib.Path(sysconfig.get_path("scripts")) / "maquette"
_WORKERS = 2


def main() -> None:
    """Measure both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--blocks", type=int, default=4)
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch, _cluster() as cluster, Client(cluster) as client:
        folder = pathlib.Path(scratch)
        cohort = written(folder, words.trials)
        seconds = {"Dask": 0.0, "by hand": 0.0}
        for block in range(words.blocks):
            part = dataclasses.replace(cohort, table=cohort.table.iloc[block :: words.blocks])
            begin = time.perf_counter()
            tally = study.run(part, client)
            seconds["Dask"] += time.perf_counter() - begin
            assert tally.computed == tally.of["usable"] == len(part.table), tally

            begin = time.perf_counter()
            _by_hand(folder, part)
            seconds["by hand"] += time.perf_counter() - begin
    for name, taken in seconds.items():
        print(f"{name}: {words.trials / taken:.3f} trials a second")
    print(f"throughput of Dask over that by hand: {seconds['by hand'] / seconds['Dask']:.3f}")


def _cluster() -> LocalCluster:
    return LocalCluster(n_workers=_WORKERS, threads_per_worker=1, dashboard_address=None)


def _by_hand(folder: pathlib.Path, part: study.Study) -> None:
    """Two shells, each with half of the trials, one `maquette fit` and one `maquette gait` after the other."""
    tasks = list(part.tasks())

    def shell(mine: list[study.Task]) -> None:
        for task in mine:
            out = folder / "by_hand" / task.name
            recording = task.trials[0][1]
            options = ["--body=human-ellipsoids", f"--fps={task.options['fps']}", "--threads=1", "--quiet"]
            subprocess.run([_PROGRAM, "fit", recording, "--out", out, *options], check=True)

    with ThreadPoolExecutor(_WORKERS) as shells:
        list(shells.map(shell, (tasks[at::_WORKERS] for at in range(_WORKERS))))


if __name__ == "__main__":
    main()
