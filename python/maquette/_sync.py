"""When each camera of a recording began."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING, Any

from . import _maquette
from ._optional import imported
from ._progress import ProgressChoice, asked
from ._recording import Recording
from ._words import Path, words

if TYPE_CHECKING:
    import pandas as pd

#: Columns of the table, and their units.
_UNITS = {
    "offset": "frames",
    "sd": "frames",
    "was": "frames",
    "offset_ms": "ms",
    "sd_ms": "ms",
    "drift": "ppm",
    "drift_sd": "ppm",
}
#: What the program calls those of another name.
_KEYS = {
    "offset": "offset_frames",
    "sd": "sd_frames",
    "was": "was_frames",
    "drift": "drift_ppm",
    "drift_sd": "drift_sd_ppm",
}


class Offsets:
    """When each camera began, and the file that says so.

    Made by :func:`sync`.

    Attributes
    ----------
    result : dict
        What ``maquette sync --json`` prints; with what the videos' sound says.
    file : pathlib.Path
        The file, which the next fit of the recording reads if it stands in its folder.
    """

    def __init__(self, result: dict[str, Any]) -> None:
        self.result: dict[str, Any] = result
        self.file: pathlib.Path = pathlib.Path(result["file"])

    @property
    def cameras(self) -> pd.DataFrame:
        """Every camera.

        Returns
        -------
        pandas.DataFrame
            By ``camera``: ``offset``, by how many frames it began after the recording, its ``sd``, and what it ``was``
            before; the same as ``offset_ms`` and ``sd_ms``; ``drift`` against the others' clocks and ``drift_sd``
            (ppm). Not numbers where the recording does not tell, and ``kept`` says why. ``attrs["units"]`` has the
            units.
        """
        rows = [_row(part) for part in self.result["cameras"]]
        table: pd.DataFrame = imported("pandas", "pandas").DataFrame(rows)
        table = table.astype(dict.fromkeys(_UNITS, float)).set_index("camera")
        table.attrs["units"] = dict(_UNITS)
        return table

    @property
    def reference(self) -> str:
        """The camera whose clock is the recording's; it keeps its offset, and the others are told against it."""
        return str(self.result["reference"])

    @property
    def fps(self) -> float:
        """Frames per second."""
        return float(self.result["fps"])

    @property
    def notes(self) -> list[str]:
        """What a person should know."""
        return list(self.result["notes"])

    def __repr__(self) -> str:
        """The file and the cameras."""
        return f"<Offsets of {len(self.result['cameras'])} cameras in {str(self.file)!r}>"


def _row(part: dict[str, Any]) -> dict[str, Any]:
    """One camera of the result as a row."""
    numbers = {column: part[_KEYS.get(column, column)] for column in _UNITS}
    return {"camera": part["camera"], **numbers, "kept": part["kept"]}


def sync(
    recording: Recording | Path,
    *,
    out: Path | None = None,
    windows: int | None = None,
    sound: bool = True,
    fps: float | None = None,
    body: str | None = None,
    frames: tuple[int, int] | None = None,
    threads: int | None = None,
    overwrite: bool = False,
    progress: ProgressChoice = None,
) -> Offsets:
    """Find when each camera began, from the person that they show.

    This is ``maquette sync``; it runs as :meth:`Recording.fit` does.

    Parameters
    ----------
    recording
        A recording, or the folder of a finished fit.
    out
        The file to write; default ``offsets.toml`` in the recording's folder, where the next fit reads it.
    windows
        Look at so many windows of 100 frames, evenly over the recording; default all frames up to 600, else 3 windows.
    sound
        Listen to the sound of videos, as a check.
    fps, body, frames, threads, progress
        As of :class:`Recording` and :meth:`Recording.fit`.
    overwrite
        Replace a file that stands there.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.
    """
    path, fps = Recording.stated(recording, fps)
    given = words(
        path,
        out=out,
        windows=windows,
        no_sound=not sound,
        fps=fps,
        body=body,
        frames=frames,
        threads=threads,
        overwrite=overwrite,
    )
    return Offsets(asked(_maquette.sync, given, progress))
