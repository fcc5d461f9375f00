"""The extension module, in Rust: ``python/src`` in the repository."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Fitted",
    "Study",
    "__version__",
    "calibrate",
    "compare",
    "fit",
    "inputs",
    "main",
    "origin",
    "recording",
    "segment",
    "session",
    "session_page",
    "silhouettes",
    "simulate",
    "skin",
    "stereo",
    "sync",
    "synth",
    "write_mask",
]

__version__: str

_Path = str | os.PathLike[str]
_Listeners = tuple[Callable[[str, int, int], object] | None, Callable[[str], object]]
_Floats = NDArray[np.float64]

def fit(words: Sequence[str], listeners: _Listeners) -> Fitted:
    """What ``maquette fit`` with these words finds and writes."""

def inputs(words: Sequence[str]) -> list[tuple[str, str]]:
    """Each input that ``maquette fit`` with these words reads: its name and BLAKE3."""

def recording(path: _Path) -> tuple[str | None, float | None]:
    """The body and the height in metres that a recording names."""

def origin(folder: _Path) -> pathlib.Path | None:
    """Where the recording is that the folder of a fit names."""

def session(words: Sequence[str], listeners: _Listeners) -> str | None:
    """Write what ``maquette session`` with these words writes, and give the verdict of one that cannot be used."""

def session_page(words: Sequence[str]) -> str:
    """The page of all trials of a session."""

def compare(words: Sequence[str]) -> tuple[str, str]:
    """What ``maquette compare --json`` with these words prints, and its page."""

def calibrate(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette calibrate --json`` with these words prints; the calibration is written."""

def sync(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette sync --json`` with these words prints; the offsets are written."""

def segment(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette segment --json`` with these words prints; the masks are written."""

def silhouettes(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette silhouettes --json`` with these words prints; the silhouettes are written."""

def stereo(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette stereo --json`` with these words prints; the points are written."""

def skin(words: Sequence[str], listeners: _Listeners) -> str:
    """What ``maquette skin --json`` with these words prints; the skins are written."""

def synth(words: Sequence[str]) -> None:
    """Write what ``maquette synth`` with these words writes."""

def simulate(words: Sequence[str]) -> None:
    """Write what ``maquette simulate`` with these words writes."""

def write_mask(path: _Path, mask: NDArray[np.uint8]) -> None:
    """Write a mask, grey values of shape (H, W), as a picture."""

def main(words: Sequence[str]) -> int:
    """Do what the words of the command line say, and give the exit code."""

@final
class Fitted:
    """A fitted body: its files, and its N frames of A angles and P points as arrays."""

    @staticmethod
    def read(folder: _Path, body: str | None) -> Fitted: ...
    def json(self) -> bytes: ...
    def save(self, folder: _Path) -> None: ...
    def check_usable(self) -> None: ...
    def gait(self, words: Sequence[str]) -> Study: ...
    def report(self, words: Sequence[str], listeners: _Listeners) -> str: ...
    def viewer(self) -> str: ...
    def export(self, words: Sequence[str]) -> list[pathlib.Path]: ...
    def frame_numbers(self) -> NDArray[np.int64]: ...
    def times_s(self) -> _Floats: ...
    def views(self) -> NDArray[np.int64]: ...
    def angles_rad(self) -> _Floats: ...
    def angles_sd_rad(self) -> _Floats: ...
    def points_m(self) -> _Floats: ...
    def points_sd_m(self) -> _Floats: ...

@final
class Study:
    """A gait analysis: its files, and its angles as arrays."""

    def json(self) -> bytes: ...
    def save(self, folder: _Path) -> None: ...
    def check_usable(self) -> None: ...
    def time_base(self) -> tuple[int, float]: ...
    def tracks(self) -> list[tuple[str, str, _Floats, _Floats | None]]: ...
