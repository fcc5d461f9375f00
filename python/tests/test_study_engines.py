"""Engines of a study: Dask, with workers that fail, and Snakemake."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import signal
import subprocess
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import pytest
from conftest import REPOSITORY
from study_files import HEAD, all_memory, contents, nothing, unlucky, walks, written

from maquette import study

pytestmark = pytest.mark.filterwarnings("default")
pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """Six walks."""
    return walks(tmp_path_factory.mktemp("engines") / "walks", 6)


@contextmanager
def workers(**options: Any) -> Generator[Any]:
    """Two workers of one thread."""
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None} | options
    # a worker that is started anew imports the functions of these tests
    os.environ["PYTHONPATH"] = os.pathsep.join([str(pathlib.Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        yield client


def _study(folder: pathlib.Path, recordings: pathlib.Path, count: int = 6, head: str = HEAD) -> study.Study:
    return written(folder, *(f"t{number},{recordings / str(number)}" for number in range(count)), head=head)


def test_workers_that_are_killed_lose_nothing_and_change_nothing(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Against processes that nobody disturbs."""
    for name in ("quiet", "killed"):
        (tmp_path / name).mkdir()
    quiet, killed = _study(tmp_path / "quiet", folder), _study(tmp_path / "killed", folder)
    assert study.run(quiet, jobs=2).of == {"usable": 6}

    with workers() as client:
        over, count = threading.Event(), 0

        def kill() -> None:
            nonlocal count
            while count < 3 and not over.wait(1.0):
                pids = list(client.run(os.getpid, on_error="ignore").values())
                if pids:
                    os.kill(pids[count % len(pids)], signal.SIGKILL)
                    count += 1

        killer = threading.Thread(target=kill)
        killer.start()
        tally = study.run(killed, client)
        over.set()
        killer.join()
    assert count > 0
    assert (tally.of, len(contents(killed))) == ({"usable": 6}, len(contents(quiet)))
    assert contents(killed) == contents(quiet)


def test_a_worker_out_of_memory_is_a_row_and_not_the_end(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Dask ends the worker, and gives up after the failures that it allows."""
    cohort = _study(tmp_path, folder, count=1)
    dask = pytest.importorskip("dask")
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1, "distributed.worker.memory.terminate": 0.8}),
        workers(memory_limit="400MiB") as client,
    ):
        assert study.run(cohort, client, work=all_memory).of == {"lost": 1}
    (outcome,) = study.outcomes(cohort)
    assert outcome.reason is not None
    assert "KilledWorker" in outcome.reason


def test_what_cannot_be_read_for_once_is_tried_again(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """A shared file system that fails now and then."""
    cohort = _study(tmp_path, folder)
    with workers() as client:
        assert study.run(cohort, client, work=unlucky).of == {"usable": 6}


def test_a_slow_file_system_changes_nothing(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Nor does a worker that is killed while it writes."""
    cohort = _study(tmp_path, folder, head=HEAD.replace('"results"', f'"slow://{tmp_path}/results"'))
    with workers() as client:
        killer = threading.Timer(1.0, lambda: os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL))
        killer.start()
        assert study.run(cohort, client, work=nothing).of == {"usable": 6}
        killer.join()
        assert study.run(cohort, client, work=nothing).computed == 0


def test_an_object_store_holds_the_results(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """By fsspec; workers that are threads share the one in memory."""
    cohort = _study(tmp_path, folder, head=HEAD.replace('"results"', '"memory://study"'))
    with workers(processes=False) as client:
        assert study.run(cohort, client, work=nothing).computed == 6
        assert study.run(cohort, client, work=nothing).computed == 0
    assert study.gather(cohort).endswith("study/dataset")
    fsspec = import_module("fsspec")
    assert fsspec.filesystem("memory").exists("/study/dataset/trials/part-00000.parquet")


def test_recordings_come_from_an_object_store(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Their key is that of the same files on a disk."""
    fsspec = pytest.importorskip("fsspec")
    fsspec.filesystem("memory").put(f"{folder / '0'}/", "/walks/0/", recursive=True)
    here, there = (
        written(tmp_path, f"t0,{folder / '0'}").task("t0"),
        written(tmp_path, "t0,memory://walks/0").task("t0"),
    )
    assert study.compute(here, nothing).key == study.compute(there, nothing).key


def test_snakemake_runs_a_study(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """A rule for each trial, and the dataset."""
    pytest.importorskip("snakemake")
    cohort = _study(tmp_path, folder, count=3)
    command = [sys.executable, "-m", "snakemake", "-s", str(study.SNAKEFILE), "--cores", "2", "--config"]
    ran = subprocess.run([*command, f"study={cohort.path}"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert [outcome.status for outcome in study.outcomes(cohort)] == ["usable"] * 3
    trials = import_module("pandas").read_parquet(f"{cohort.results}/dataset/trials")
    assert list(trials["trial"]) == ["t0", "t1", "t2"]


def test_workers_are_asked_of_slurm() -> None:
    """One core each, in the queue of the script."""
    pytest.importorskip("dask_jobqueue")
    with _script("on_slurm").cluster() as cluster:
        job = cluster.job_script()
    assert "#SBATCH -p short" in job
    assert "#SBATCH --cpus-per-task=1" in job
    assert "--nthreads 1" in job


def test_workers_are_asked_of_kubernetes() -> None:
    """Of one core and the image that was named."""
    pytest.importorskip("dask_kubernetes")
    specification = _script("on_kubernetes").specification("an/image:1")
    (container,) = specification["spec"]["worker"]["spec"]["containers"]
    assert container["image"] == "an/image:1"
    assert container["resources"]["limits"]["cpu"] == "1"


def _script(name: str) -> Any:
    """A script of `python/clusters` as a module."""
    found = importlib.util.spec_from_file_location(name, REPOSITORY / "python" / "clusters" / f"{name}.py")
    assert found is not None
    assert found.loader is not None
    script = importlib.util.module_from_spec(found)
    found.loader.exec_module(script)
    return script
