"""Recordings of a simulated walker, or of a fitted body, with the truth beside them."""

from __future__ import annotations

import pathlib
from typing import Literal

from . import _maquette
from ._fit_or_folder import FitOrFolder, stated
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
    action: str | None = None,
    make: Literal["metaballs", "flesh", "dressed"] | None = None,
    noise: Literal["none", "mild"] | None = None,
    points: bool = False,
    clutter: bool = False,
    body: Path | None = None,
) -> pathlib.Path:
    """Make a synthetic recording of a person who walks, or does something else, with the truth beside it.

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
    action
        What the person does: ``"walk"`` (default), ``"stand"`` (for the zero of the angles of other trials), or one of
        the movements that ``maquette synth --help`` lists, such as ``"squat"``.
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
        action=action,
        make=make,
        noise=noise,
        points=points,
        clutter=clutter,
        body=body,
    )
    _maquette.synth(given)
    return pathlib.Path(out)


def simulate(
    fit: FitOrFolder,
    out: Path,
    *,
    seed: int = 1,
    noise: Literal["none", "mild"] | None = None,
    recording: Path | None = None,
    body: Path | None = None,
) -> pathlib.Path:
    """Make a recording of a fitted body by the fit's own cameras, with the truth beside it.

    This is ``maquette simulate``: a parametric bootstrap. Shape and motion are those of the fit, and the cameras stand
    where it found them, with clocks that agree. A fit of the new recording shows how far it lies from a truth that is
    known.

    Parameters
    ----------
    fit
        A usable fit of a body with metaballs, or the folder of one.
    out
        Folder to write into; it must be empty or new.
    seed
        Errors of the masks.
    noise
        Segmentation errors of the masks; default mild.
    recording
        The recording that was fitted, which has the cameras; default where the fit found it.
    body
        Body model of the fit, if it is not a shipped one.

    Returns
    -------
    pathlib.Path
        The folder, as of :func:`synth`. Frame 0 is the first that was fitted.

    Raises
    ------
    UnusableError
        Of a fit that is not to be used.
    MaquetteError
        With the one line that the program prints.

    Examples
    --------
    >>> again = maquette.simulate(fit, "again", seed=2)  # doctest: +SKIP
    >>> maquette.Recording(again).fit().lengths["length"] - fit.lengths["length"]  # doctest: +SKIP
    """
    folder, model = stated(fit, body)
    _maquette.simulate(words(folder, out=out, seed=seed, noise=noise, recording=recording, body=model))
    return pathlib.Path(out)
