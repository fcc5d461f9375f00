"""Packages that only some calls need, imported when they are needed."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from .errors import MissingPackageError


def imported(name: str, extra: str) -> ModuleType:
    """Import an optional package, or say in one line how to install it.

    Parameters
    ----------
    name
        The module, e.g. ``"pandas"``.
    extra
        The extra of this package that brings it.

    Raises
    ------
    MissingPackageError
        If it is not installed.
    """
    package = name.partition(".")[0]
    try:
        return import_module(name)
    except ModuleNotFoundError as fault:
        if (fault.name or "").partition(".")[0] != package:
            raise
        line = f"{package} is not installed: pip install 'maquette[{extra}]'"
        raise MissingPackageError(line) from None
