"""An engine: processes of this machine, one for each task."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from functools import partial
from itertools import islice

from ..errors import OptionError
from ._compute import compute, lost
from ._task import Outcome, Task

#: How often a task is tried whose process ends.
_ATTEMPTS = 3
_GIB = 1 << 30


def outcomes(tasks: Iterator[Task], jobs: int, memory_gib: float | None) -> Iterator[Outcome]:
    """Do tasks in so many processes side by side, in any order; each has its share of the memory."""
    if jobs < 1:
        raise OptionError(f"jobs: expected 1 or more, found {jobs}")
    share = None if memory_gib is None else int(memory_gib * _GIB / jobs)
    return _ended(tasks, jobs, partial(_in_process, share=share))


def _ended(tasks: Iterator[Task], jobs: int, done: Callable[[Task], Outcome]) -> Iterator[Outcome]:
    with ThreadPoolExecutor(jobs) as threads:
        waiting: set[Future[Outcome]] = {threads.submit(done, task) for task in islice(tasks, 2 * jobs)}
        while waiting:
            ended, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            waiting |= {threads.submit(done, task) for task in islice(tasks, len(ended))}
            yield from (future.result() for future in ended)


def _in_process(task: Task, share: int | None) -> Outcome:
    """Do a task in a process of its own, which a fault of the program or of the machine may end."""
    command = [sys.executable, "-m", __name__, *([] if share is None else [str(share)])]
    line = ""
    for _ in range(_ATTEMPTS):
        ended = subprocess.run(command, input=task.json(), capture_output=True, text=True, check=False)
        if ended.returncode == 0:
            return Outcome.of_json(ended.stdout)
        line = _why(ended, share)
    return lost(task, f"{line} ({_ATTEMPTS} attempts)")


def _why(ended: subprocess.CompletedProcess[str], share: int | None) -> str:
    said = ended.stderr.strip().splitlines()
    if ended.returncode >= 0:
        return said[-1] if said else f"its process ended with code {ended.returncode}"
    name = signal.Signals(-ended.returncode).name
    bound = "" if share is None else f"; it had {share / _GIB:.1f} GiB"
    return f"its process was ended by {name}{bound}"


def _main() -> None:
    """Do the task on standard input, with so many bytes of memory as the first word says."""
    if len(sys.argv) > 1:
        import resource

        share = int(sys.argv[1])
        resource.setrlimit(resource.RLIMIT_DATA, (share, share))
    print(compute(Task.of_json(sys.stdin.read())).json())


if __name__ == "__main__":
    _main()
