"""Calibrations that a person who moves has refined."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from . import _camera_table
from ._maquette import calibrate as _calibrate
from ._progress import ProgressChoice, asked
from ._words import Path, words

if TYPE_CHECKING:
    import pandas as pd


class Calibration:
    """What was found of the cameras, and the files that it was written into."""

    def __init__(self, result: dict[str, Any]) -> None:
        self.result: dict[str, Any] = result
        self.files: list[pathlib.Path] = [pathlib.Path(path) for path in result["files"]]

    @property
    def cameras(self) -> pd.DataFrame:
        """Every camera of a refined calibration.

        Returns
        -------
        pandas.DataFrame
            By ``camera``: ``turn_x`` … ``turn_z`` (deg) about the world's axes and ``displacement_x`` …
            ``displacement_z`` (m), and ``zoom``, each with its ``_sd``; not numbers where the camera keeps its
            calibration, and ``kept`` says why. ``determined`` is how many of the seven the motion determines. From
            lenses alone nothing is refined, and ``result`` says what was found.
        """
        rows = [_row(part) for part in self.result["cameras"] if "turn_deg" in part]
        return _camera_table.table(rows, list(_row({})), {})

    @property
    def notes(self) -> list[str]:
        """What a person should know."""
        return list(self.result.get("notes") or [])


def _row(part: dict[str, Any]) -> dict[str, Any]:
    """One camera of the result as a row."""
    known = {"determined": part.get("determined"), "kept": part.get("kept")}
    return {"camera": part.get("camera"), **_camera_table.place(part), **known}


def calibrate(
    recordings: Sequence[Path],
    *,
    out: Path,
    from_: Literal["calibration", "lenses"] | None = None,
    height: float | None = None,
    distance: tuple[str, str, float] | None = None,
    fps: float | None = None,
    body: str | None = None,
    frames: tuple[int, int] | None = None,
    threads: int | None = None,
    overwrite: bool = False,
    progress: ProgressChoice = None,
) -> Calibration:
    """Write the calibration that a person who moves before the cameras has refined.

    This is ``maquette calibrate``; it runs as :meth:`Recording.fit` does.

    Parameters
    ----------
    recordings
        Recordings, or folders of finished fits.
    out
        The calibration to write; its ending says in which format (docs/formats.md, calibrations).
    from_
        What is known of the cameras: lenses and places (the default), or lenses alone.
    height
        Of lenses alone: the person's height without shoes, m.
    distance
        Of lenses alone, in the place of the height: two cameras and how far they stand from each other, m.
    fps, body, frames, threads, progress
        As of :class:`Recording` and :meth:`Recording.fit`.
    overwrite
        Replace files that stand there.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.
    """
    options = {"from": from_, "height": height, "fps": fps, "body": body, "frames": frames, "threads": threads}
    given = words(None, out=out, overwrite=overwrite, **options)
    if distance is not None:
        first, second, metres = distance
        given += ["--distance", first, second, repr(float(metres))]
    paths = [os.fspath(path) for path in recordings]
    return Calibration(asked(_calibrate, [*given, "--", *paths], progress))
