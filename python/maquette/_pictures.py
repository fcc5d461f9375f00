"""What is made of the pictures of a recording: masks, silhouettes, points on the surface."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence
from typing import Literal

from . import _maquette
from ._progress import Command, ProgressChoice, asked, cautions
from ._recording import Recording
from ._words import Path, words


def segment(
    recording: Recording | Path,
    *,
    out: Path,
    fps: float | None = None,
    frames: tuple[int, int] | None = None,
    probability: bool = False,
    overlays: bool = False,
    threads: int | None = None,
    overwrite: bool = False,
    progress: ProgressChoice = None,
) -> pathlib.Path:
    """Cut the person out of the pictures of a recording.

    This is ``maquette segment``; it runs as :meth:`Recording.fit` does. A fit does the same by itself where a recording
    has no masks.

    Parameters
    ----------
    recording
        A recording with videos or images, and pictures of the empty scene if there are any.
    out
        Folder to write into; it must be empty or new.
    fps, frames, threads, progress
        As of :class:`Recording` and :meth:`Recording.fit`. The background is learnt from all frames.
    probability
        Also write each pixel's probability of showing the person.
    overlays
        Also draw the masks over the pictures.
    overwrite
        Write into a folder that is not empty, and replace an older run's files.

    Returns
    -------
    pathlib.Path
        The folder: ``masks/<camera>/%06d.png``, and ``quality.csv`` with a row for each mask.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.

    Warns
    -----
    MaquetteWarning
        Of what a person should know, such as pictures that are missing.
    """
    path, fps = Recording.stated(recording, fps)
    given = words(
        path,
        out=out,
        fps=fps,
        frames=frames,
        probability=probability,
        overlays=overlays,
        threads=threads,
        overwrite=overwrite,
    )
    _write(_maquette.segment, given, progress)
    return pathlib.Path(out)


def silhouettes(
    recording: Recording | Path,
    *,
    out: Path,
    pipeline: Literal["simple", "joint", "frame-after-frame"] | None = None,
    fit: Path | None = None,
    fps: float | None = None,
    body: str | None = None,
    frames: tuple[int, int] | None = None,
    overlays: bool = False,
    stages: bool = False,
    threads: int | None = None,
    overwrite: bool = False,
    progress: ProgressChoice = None,
) -> pathlib.Path:
    """Find the person's outline before clutter, with a body that predicts where to look.

    This is ``maquette silhouettes``; it runs as :meth:`Recording.fit` does.

    Parameters
    ----------
    recording
        A recording with videos or images of cameras that stand side by side.
    out
        Folder to write into; it must be empty or new.
    pipeline
        How body and contours work together: by turns over all frames (``joint``, the default), in one pass
        (``simple``), or each frame from the one before.
    fit
        Begin with the folder of a finished fit; default a body that is fitted to the depths of what moves.
    fps, body, frames, threads, progress
        As of :class:`Recording` and :meth:`Recording.fit`. The body has metaballs.
    overlays
        Also write the contours over the pictures.
    stages
        Also write the filtered edges.
    overwrite
        Write into a folder that is not empty, and replace an older run's files.

    Returns
    -------
    pathlib.Path
        The folder: ``masks/<camera>/%06d.png``, ``contours/<camera>/%06d.json`` and ``.svg``, and ``quality.csv`` with
        a row for each frame and camera. docs/formats.md, contours.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.

    Warns
    -----
    MaquetteWarning
        Of contours that are nobody's outline, which have reliability 0; and of what else a person should know.
    """
    path, fps = Recording.stated(recording, fps)
    given = words(
        path,
        out=out,
        pipeline=pipeline,
        fit=fit,
        fps=fps,
        body=body,
        frames=frames,
        overlays=overlays,
        stages=stages,
        threads=threads,
        overwrite=overwrite,
    )
    _write(_maquette.silhouettes, given, progress)
    return pathlib.Path(out)


def stereo(
    recording: Recording | Path,
    *,
    out: Path,
    method: Literal["matching", "correlation"] | None = None,
    cameras: Sequence[str] | None = None,
    depth: tuple[float, float] | None = None,
    spacing: int | None = None,
    least_cameras: int | None = None,
    tracks: bool = False,
    pictures: bool = False,
    fps: float | None = None,
    frames: tuple[int, int] | None = None,
    overwrite: bool = False,
    progress: ProgressChoice = None,
) -> pathlib.Path:
    """Measure points of the surface with cameras that stand side by side.

    This is ``maquette stereo``; it runs as :meth:`Recording.fit` does. Where the recording has masks, only the person
    is measured.

    Parameters
    ----------
    recording
        A recording with videos or images.
    out
        Folder to write into; it must be empty or new.
    method
        Least-squares matching in all images at once (default), or disparities by correlation, which is faster.
    cameras
        Names of cameras, the template first; default the one in the middle and those beside it.
    depth
        Nearest and farthest depth, m.
    spacing
        Spacing of the points in the template's image, px; matching.
    least_cameras
        How many cameras besides the template must show a point; matching; default all.
    tracks
        Also follow the points, ten frames at a time (``trajectories.csv``); matching.
    pictures
        Also write pictures of disparities, cloud and motion.
    fps, frames, progress
        As of :class:`Recording` and :meth:`Recording.fit`.
    overwrite
        Write into a folder that is not empty, and replace an older run's files.

    Returns
    -------
    pathlib.Path
        The folder: ``points/%06d.ply`` with a covariance for each point (m), and ``disparity/%06d.png``.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.

    Warns
    -----
    MaquetteWarning
        Of what a person should know, such as pictures that are missing.
    """
    path, fps = Recording.stated(recording, fps)
    given = words(
        path,
        out=out,
        method=method,
        cameras=None if cameras is None else ",".join(cameras),
        depth=depth,
        spacing=spacing,
        least_cameras=least_cameras,
        tracks=tracks,
        pictures=pictures,
        fps=fps,
        frames=frames,
        overwrite=overwrite,
    )
    _write(_maquette.stereo, given, progress)
    return pathlib.Path(out)


def _write(call: Command, given: Sequence[str], progress: ProgressChoice) -> None:
    """Do what a command with these words does, and warn of what a person should know of it."""
    result = asked(call, given, progress)
    verdict = result.get("failure") or result.get("warning")
    cautions([*([] if verdict is None else [verdict]), *result["notes"]])
