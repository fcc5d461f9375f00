"""Thousands of trials: a table of recordings in, one folder for each and one dataset of all out.

>>> from maquette import study
>>> cohort = study.read("study.toml")  # doctest: +SKIP
>>> study.run(cohort, jobs=8)  # doctest: +SKIP
>>> study.gather(cohort)  # doctest: +SKIP

A fit is kept under a name that is made from all it depends on: what was done is not done again. One function,
:func:`compute`, does one task; processes of this machine, Dask and Snakemake call it, and nothing else computes.

| module          | holds                                                            |
|-----------------|------------------------------------------------------------------|
| `_study.py`     | a study: its trials and their tasks                              |
| `_table.py`     | how it is read: `study.toml` and its table                       |
| `_task.py`      | one task, and what became of it                                  |
| `_compute.py`   | doing it: from a recording to its folder                         |
| `_key.py`       | what a result depends on, as its name                            |
| `_store.py`     | folders under such names, on a disk or in an object store        |
| `_rows.py`      | a fit as rows of the dataset                                     |
| `_run.py`       | all tasks, by one of the engines, and what became of them        |
| `_processes.py` | an engine: processes of this machine                             |
| `_dask.py`      | an engine: the workers of Dask                                   |
| `_dataset.py`   | the rows of all as Parquet                                       |
| `_report.py`    | a page about all of them                                         |
| `_command.py`   | `maquette study`                                                 |
| `Snakefile`     | an engine: Snakemake                                             |
"""

from __future__ import annotations

from ._compute import compute
from ._dataset import gather
from ._report import report
from ._run import SNAKEFILE, Tally, outcomes, run
from ._study import Study
from ._table import read
from ._task import Outcome, Task

__all__ = ["SNAKEFILE", "Outcome", "Study", "Tally", "Task", "compute", "gather", "outcomes", "read", "report", "run"]
