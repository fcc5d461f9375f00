"""Recordings of a simulated walker, with the truth beside them."""

from __future__ import annotations

import pathlib
from typing import Literal

from . import _maquette
from ._words import Path, words


def synth(
    out: Path,
    *,
    seed: int = 1,
    trial: int | None = None,
    cameras: int | None = None,
    frames: int | None = None,
    fps: float | None = None,
    treadmill: bool = False,
    make: Literal["metaballs", "flesh", "dressed"] | None = None,
    noise: Literal["none", "mild"] | None = None,
    points: bool = False,
    clutter: bool = False,
    body: Path | None = None,
) -> pathlib.Path:
    """Make a synthetic recording of a walking person, with the truth beside it.

    This is ``maquette synth``: the same arguments give the same files.

    Parameters
    ----------
    out
        Folder to write into; it must be empty or new.
    seed
        Who walks, and how.
    trial
        Another trial of the same person has the same body and cameras, and a walk that differs a little.
    cameras, frames, fps
        How many cameras around the person (default 6), frames (default one gait cycle) and frames per second (50).
        With ``clutter`` there are always three cameras; frames are 300 and frames per second 25 by default.
    treadmill
        The person walks on a treadmill, and so stays in the middle of the cameras.
    make
        What the person is made of; default metaballs.
    noise
        Segmentation errors of the masks; default mild.
    points
        Also points on the skin, as a second camera beside each would measure them (``points/%06d.ply``, m). Only of a
        person of metaballs.
    clutter
        Photographs of a person before clutter, from three cameras side by side, in the place of masks. Their true
        masks are in ``truth/masks``.
    body
        Body model with metaballs: a shipped one or a ``.toml`` file; default ``walker-metaballs``.

    Returns
    -------
    pathlib.Path
        The folder, which :class:`Recording` reads. ``truth.trc`` has the true joint centres, ``truth.json`` the true
        lengths (m) and angles.

    Raises
    ------
    OptionError
        Of options that exclude each other.
    MaquetteError
        With the one line that the program prints.
    """
    given = words(
        out,
        seed=seed,
        trial=trial,
        cameras=cameras,
        frames=frames,
        fps=fps,
        treadmill=treadmill,
        make=make,
        noise=noise,
        points=points,
        clutter=clutter,
        body=body,
    )
    _maquette.synth(given)
    return pathlib.Path(out)
