"""Run a study on Slurm: python on_slurm.py study.toml.

Needs dask-jobqueue. Change what your cluster calls differently.
"""

from __future__ import annotations

import sys

from dask_jobqueue.slurm import SLURMCluster
from distributed import Client

from maquette import study


def cluster() -> SLURMCluster:
    """Workers of one core, each a job of the queue, that end by themselves before the queue ends them."""
    return SLURMCluster(
        queue="short",
        cores=1,
        processes=1,
        memory="2GiB",
        walltime="04:00:00",
        worker_extra_args=["--lifetime", "220m", "--lifetime-stagger", "10m"],
    )


def main(path: str) -> None:
    """Run it on up to 500 workers, and gather the dataset."""
    cohort = study.read(path)
    with cluster() as workers, Client(workers) as client:
        workers.adapt(minimum=1, maximum=500)
        print(study.run(cohort, client, progress=True))
    print(study.gather(cohort))


if __name__ == "__main__":
    main(sys.argv[1])
