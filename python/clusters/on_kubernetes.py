"""Run a study on Kubernetes: python on_kubernetes.py study.toml IMAGE.

Needs dask-kubernetes, and its operator in the cluster.
"""

from __future__ import annotations

import sys
from typing import Any

from dask_kubernetes.operator import KubeCluster, make_cluster_spec
from distributed import Client

from maquette import study


def specification(image: str) -> Any:
    """A scheduler, and workers of one core from an image that has this package and its extra ``dask``."""
    resources = {"requests": {"cpu": "1", "memory": "2Gi"}, "limits": {"cpu": "1", "memory": "2Gi"}}
    command = ["dask", "worker", "--nthreads", "1", "--memory-limit", "1.8GiB"]
    options = {"resources": resources, "worker_command": command, "n_workers": 1, "env": {}}
    return make_cluster_spec(name="maquette", image=image, **options)


def main(path: str, image: str) -> None:
    """Run it on up to 500 workers, and gather the dataset."""
    cohort = study.read(path)
    with KubeCluster(custom_cluster_spec=specification(image)) as workers, Client(workers) as client:
        workers.adapt(minimum=1, maximum=500)
        print(study.run(cohort, client, progress=True))
    print(study.gather(cohort))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
