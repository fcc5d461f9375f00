"""A worker of Dask is killed at random moments: whether a result is lost, done twice, or another one."""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import os
import pathlib
import random
import signal
import tempfile
import threading
import time
from collections import Counter

import dask
from cohort import written
from distributed import Client, LocalCluster

from maquette import study
from maquette.study import Task
from maquette.study._compute import fitted
from maquette.study._task import Status


def main() -> None:
    """Run once undisturbed and once with killed workers, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        cohort = written(folder, words.trials)
        quiet, killed = (dataclasses.replace(cohort, results=str(folder / name)) for name in ("quiet", "killed"))
        seconds = _run(quiet, [])
        moments = random.Random(words.seed)
        waits = [moments.expovariate(1.0) for _ in range(words.kills)]
        # all of them before the trials are done
        scale = 0.8 * seconds / sum(waits)
        _run(killed, [wait * scale for wait in waits])

        before, after = _contents(quiet), _contents(killed)
        print(f"{words.trials} trials, {words.kills} workers killed")
        print(f"lost: {len(before.keys() - after.keys())}")
        print(f"different: {sum(after.get(key) != content for key, content in before.items())}")
        print(f"finished twice: {sum(count - 1 for count in _finished(killed).values())}")


def _run(cohort: study.Study, waits: list[float]) -> float:
    """Run a study while a worker is killed after each wait; how long it took, s."""
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client:
        over = threading.Event()
        killer = threading.Thread(target=_kill, args=(client, waits, over))
        begin = time.perf_counter()
        killer.start()
        print(study.run(cohort, client, work=_logged))
        seconds = time.perf_counter() - begin
        over.set()
        killer.join()
    return seconds


def _kill(client: Client, waits: list[float], over: threading.Event) -> None:
    """Kill a worker after each wait."""
    chance = random.Random(0)
    for wait in waits:
        if over.wait(wait):
            print("the study ended before all workers were killed")
            return
        pids = list(client.run(os.getpid, on_error="ignore").values())
        os.kill(chance.choice(pids), signal.SIGKILL)


def _logged(task: Task, recordings: list[pathlib.Path], folder: pathlib.Path) -> tuple[Status, str | None]:
    """The fit, which leaves a line once it is finished."""
    done = fitted(task, recordings, folder)
    with _log(task.results).open("a", encoding="utf-8") as log:
        log.write(task.name + "\n")
    return done


def _contents(cohort: study.Study) -> dict[str, str]:
    """What the results of each key are: a sum of all that does not tell the time."""
    contents: dict[str, str] = {}
    for fit in sorted(pathlib.Path(cohort.results, "fits").iterdir()):
        files = sorted(path for path in fit.rglob("*") if path.is_file() and path.name != "outcome.json")
        together = b"".join(str(path.relative_to(fit)).encode() + path.read_bytes() for path in files)
        contents[fit.name] = hashlib.sha256(together).hexdigest()
    return contents


def _log(results: str) -> pathlib.Path:
    return pathlib.Path(results).with_suffix(".log")


def _finished(cohort: study.Study) -> Counter[str]:
    """How often the fit of each task was finished."""
    return Counter(_log(cohort.results).read_text(encoding="utf-8").split())


if __name__ == "__main__":
    dask.config.set({"distributed.scheduler.allowed-failures": 30})
    main()
