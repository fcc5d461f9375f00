"""An engine: the workers of Dask, on this machine or on a cluster."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

from .._optional import imported
from ._compute import Work, compute, lost
from ._task import Outcome, Task

#: Tasks that wait for each thread of a worker: enough that none is idle, few enough that a million fit in no memory.
_AHEAD = 8
#: At least so many tasks wait in all, for workers that come later.
_LEAST = 64
#: How often a task is done again that could not read or write.
_RETRIES = 2


def outcomes(tasks: Iterator[Task], client: Any, work: Work | None) -> Iterator[Outcome]:
    """Do tasks on the workers of a client, in any order.

    A task whose worker ends goes to another one; Dask gives up after as many as its ``allowed-failures`` says.
    """
    distributed = imported("distributed", "study")
    ended = distributed.as_completed(with_results=False)
    waiting: dict[Any, Task] = {}

    def submit(more: Iterator[Task]) -> None:
        for task in more:
            # a key of its own: what is known of a task stands in the results, not in the scheduler
            future = client.submit(compute, task, work, pure=False, retries=_RETRIES)
            waiting[future] = task
            ended.add(future)

    submit(islice(tasks, max(_LEAST, _AHEAD * sum(client.nthreads().values()))))
    for batch in ended.batches():
        done = {future: waiting.pop(future) for future in batch}
        submit(islice(tasks, len(done)))
        # all results of a batch come together
        ended_well: list[Outcome] = client.gather(list(done), errors="skip")
        yield from ended_well
        names = {outcome.name for outcome in ended_well}
        for future, task in done.items():
            if task.name not in names:
                yield lost(task, future.exception() or "its worker took the result with it")
