"""The skin of a fitted body as meshes."""

from __future__ import annotations

import pathlib
from typing import Literal

from . import _maquette
from ._fit_or_folder import FitOrFolder, stated
from ._progress import ProgressChoice, asked
from ._words import Path, words


def skin(
    fit: FitOrFolder,
    *,
    frames: tuple[int, int] | None = None,
    frame: int | None = None,
    rest: bool = False,
    format: Literal["ply", "ply-text", "obj"] | None = None,
    around: int | None = None,
    picture: bool = False,
    body: Path | None = None,
    progress: ProgressChoice = None,
) -> pathlib.Path:
    """Write the skin of a fitted body: one closed surface of triangles for each frame.

    This is ``maquette skin``. Coordinates are those of the world, in metres with Z up; :meth:`Fit.export` writes the
    same with Y up.

    Parameters
    ----------
    fit
        A fit of a body with metaballs, or the folder of one. Of a fit in memory the skins stand in its temporary
        folder, which goes with it; ``maquette.skin(fit.save("out/me"))`` keeps them.
    frames
        Only these frames, first and last included; default all.
    frame
        Only this frame.
    rest
        The fitted person in the rest pose instead of frames.
    format
        Format of the meshes; default binary PLY.
    around
        Vertices around the trunk, an even number; their spacing along the body follows.
    picture
        Also write a shaded picture of each.
    body
        Body model of the fit, if it is not a shipped one.
    progress
        As of :meth:`Recording.fit`.

    Returns
    -------
    pathlib.Path
        The folder ``skin`` beside the result: ``frame_%06d.ply``, or ``rest.ply``.

    Raises
    ------
    MaquetteError
        With the one line that the program prints.
    """
    folder, model = stated(fit, body)
    options = {"frames": frames, "frame": frame, "rest": rest, "format": format, "around": around, "picture": picture}
    given = words(folder, **options, body=model)
    asked(_maquette.skin, given, progress)
    return folder / "skin"
