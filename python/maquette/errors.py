"""What can go wrong, each in one line: the line that the program ``maquette`` prints."""

from __future__ import annotations

__all__ = [
    "BodyError",
    "FitError",
    "GaitError",
    "MaquetteError",
    "MaquetteWarning",
    "MissingPackageError",
    "OptionError",
    "OutputError",
    "RecordingError",
    "ResultError",
    "UnusableError",
]


class MaquetteError(Exception):
    """Whatever this package raises by itself."""


class OptionError(MaquetteError, ValueError):
    """An option that does not exist, or a value that it cannot have."""


class RecordingError(MaquetteError):
    """A recording that cannot be read: calibration, masks, pictures, points, frames."""


class BodyError(MaquetteError):
    """A body model that does not exist or cannot be read."""


class FitError(MaquetteError):
    """Observations that no body can be fitted to, or that do not tell what they were asked for."""


class OutputError(MaquetteError):
    """A folder or file that cannot be written, or a run in it that cannot be continued."""


class ResultError(MaquetteError):
    """A folder that holds no result, or one that was changed; or trials that make no session."""


class GaitError(MaquetteError):
    """A movement without gait, or a norm that cannot be read."""


class UnusableError(MaquetteError):
    """A fit that is not to be used: its verdict says why."""


class MissingPackageError(MaquetteError, ImportError):
    """An optional package that is needed here and not installed."""


class MaquetteWarning(UserWarning):
    """What a person should know of a recording or of a fit."""
