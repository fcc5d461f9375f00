"""Body shape and motion of a person, with standard deviations, from calibrated recordings.

>>> import maquette
>>> fit = maquette.Recording("data/sequences/walker").fit()  # doctest: +SKIP
>>> fit.lengths  # doctest: +SKIP

Numbers are in metres, seconds and radians unless an attribute ``units`` says otherwise; the world is right-handed
with Z up. Every number is the program's, to the last bit.

NumPy, pandas, xarray and matplotlib are imported by what needs them, so that a call is as quick as the program.
"""

from __future__ import annotations

from . import errors
from ._calibrate import Calibration, calibrate
from ._fit import Fit, load
from ._gait import Gait
from ._maquette import __version__
from ._pictures import segment, silhouettes, stereo
from ._recording import Recording
from ._session import Comparison, Session, session
from ._show import Viewer
from ._skin import skin
from ._sync import Offsets, sync
from ._synth import simulate, synth
from .errors import (
    MaquetteError,
    MaquetteWarning,
    OptionError,
    RecordingError,
    ResultError,
    UnusableError,
)

__all__ = [
    "Calibration",
    "Comparison",
    "Fit",
    "Gait",
    "MaquetteError",
    "MaquetteWarning",
    "Offsets",
    "OptionError",
    "Recording",
    "RecordingError",
    "ResultError",
    "Session",
    "UnusableError",
    "Viewer",
    "__version__",
    "calibrate",
    "errors",
    "load",
    "segment",
    "session",
    "silhouettes",
    "simulate",
    "skin",
    "stereo",
    "sync",
    "synth",
]
