"""Options as the words of the command line, so that the program itself reads and checks them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Union

#: A folder or a file.
Path = Union[str, "os.PathLike[str]"]
Value = Union[str, int, float, bool, "os.PathLike[str]", Sequence[float], None]


def words(positional: Path | None = None, **options: Value) -> list[str]:
    """Options and one positional argument as words; options that are None are left out.

    Parameters
    ----------
    positional
        A path, which may begin with a hyphen.
    **options
        The value of each: True gives the bare switch and False none, a pair of numbers ``first:last``.
    """
    given = [word for name, value in options.items() for word in _option(name, value)]
    return given if positional is None else [*given, "--", os.fspath(positional)]


def _option(name: str, value: Value) -> list[str]:
    """The word of one option, or none."""
    switch = "--" + name.replace("_", "-")
    if value is None or value is False:
        return []
    if value is True:
        return [switch]
    return [f"{switch}={_text(value)}"]


def _text(value: str | float | os.PathLike[str] | Sequence[float]) -> str:
    """A value as the program reads it; floats with as many digits as give the same number back."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, Sequence):
        return ":".join(str(number) for number in value)
    return repr(value)
