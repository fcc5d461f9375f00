"""Tasks that do nothing, through all that a study does: what one costs the driver, in time and in memory."""

from __future__ import annotations

import argparse
import pathlib
import resource
import tempfile
import time

from distributed import Client, LocalCluster

from maquette import study
from maquette.study import Task
from maquette.study._task import Status


def main() -> None:
    """Run a study of so many trials of one recording, which differ in the frame rate that is stated."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100_000)
    parser.add_argument("--recording", default="data/sequences/walker")
    words = parser.parse_args()
    recording = pathlib.Path(words.recording).absolute()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        rows = (f"t{n},{recording},{1 + n / words.trials}" for n in range(words.trials))
        (folder / "trials.csv").write_text("\n".join(["trial,recording,fit.fps", *rows]), encoding="utf-8")
        (folder / "study.toml").write_text("", encoding="utf-8")
        begin = time.perf_counter()
        cohort = study.read(folder / "study.toml")
        _say("reading", words.trials, begin)

        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with cluster, Client(cluster) as client:
            begin, driver = time.perf_counter(), time.process_time()
            tally = study.run(cohort, client, work=_nothing)
            _say("running", words.trials, begin)
            taken = time.process_time() - driver
            print(f"of which the driver and the scheduler, CPU: {1e3 * taken / words.trials:.2f} ms a trial")
            print(tally)
        begin = time.perf_counter()
        study.gather(cohort)
        _say("gathering", words.trials, begin)


def _nothing(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """No fit."""
    return "usable", None


def _say(what: str, trials: int, begin: float) -> None:
    seconds = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{what}: {1e3 * seconds / trials:.2f} ms a trial, at most {peak:.0f} MiB so far", flush=True)


if __name__ == "__main__":
    main()
