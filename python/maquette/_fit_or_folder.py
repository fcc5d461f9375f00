"""A fit, or the folder of one."""

from __future__ import annotations

import pathlib
from typing import Union

from ._fit import Fit
from ._words import Path

FitOrFolder = Union[Fit, Path]


def stated(fit: FitOrFolder, body: Path | None) -> tuple[pathlib.Path, Path | None]:
    """Where a fit is, and its body model if it is not a shipped one; ``body`` goes first."""
    if isinstance(fit, Fit):
        return fit.folder, fit._body if body is None else body
    return pathlib.Path(fit), body
