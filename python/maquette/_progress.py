"""Who is told how far a run is."""

from __future__ import annotations

import json
import logging
import sys
import warnings
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from typing import Any, Union

from ._optional import imported
from .errors import MaquetteWarning, MissingPackageError

#: Called with the name of the stage, the steps that are done, and the steps there are.
Progress = Callable[[str, int, int], None]
#: A function, bars, or nothing.
ProgressChoice = Union[Progress, bool, None]
#: A call of the extension with the words of a command, and who is told of stages and of news; what it tells is JSON.
Command = Callable[[Sequence[str], "tuple[Progress | None, Callable[[str], object]]"], str]


_LOG = logging.getLogger("maquette")


def news(line: str) -> None:
    """Log what a run tells on its way; what a person should know of it stands in the result too."""
    _LOG.info(line)


def caution(line: str) -> None:
    """Warn of what stands in no result."""
    warnings.warn(line, MaquetteWarning, stacklevel=3)


def cautions(lines: Iterable[str]) -> None:
    """Warn of each, with the line that has called the package's own function."""
    for line in lines:
        warnings.warn(line, MaquetteWarning, stacklevel=4)


def asked(call: Command, given: Sequence[str], progress: ProgressChoice) -> dict[str, Any]:
    """What a command with these words tells in JSON, while somebody listens."""
    with listening(progress) as told:
        result: dict[str, Any] = json.loads(call(given, (told, news)))
    return result


@contextmanager
def listening(progress: ProgressChoice) -> Generator[Progress | None, None, None]:
    """Give the function that is told of what a caller has asked for, and end what it shows."""
    told = _listener(progress)
    try:
        yield told
    finally:
        if isinstance(told, Bars):
            told.close()


def _listener(progress: ProgressChoice) -> Progress | None:
    if progress is None or progress is False:
        return None
    if progress is True:
        try:
            return Bars(imported("tqdm.auto", "progress").tqdm)
        except MissingPackageError:
            return Lines()
    return progress


class Bars:
    """A bar of tqdm for each stage."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm = tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, steps: int) -> None:
        """Show how far the stage is."""
        if stage != self._stage or self._bar is None or done < self._bar.n:
            self.close()
            self._bar = self._tqdm(total=steps, desc=stage)
            self._stage = stage
        self._bar.total = steps
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """End the last bar where it is."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class Lines:
    """A line on standard error for each stage, where tqdm is not installed."""

    def __init__(self) -> None:
        self._stage = ""

    def __call__(self, stage: str, done: int, steps: int) -> None:
        """Name the stage when it begins."""
        if stage != self._stage:
            print(f"{stage} ({steps} steps)", file=sys.stderr)
            self._stage = stage
