"""A recording, and how it is fitted."""

from __future__ import annotations

import os
import pathlib
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from . import _maquette
from ._fit import Fit
from ._folder import Scratch
from ._progress import ProgressChoice, listening, news
from ._words import Path, words
from .errors import MaquetteWarning

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._arrays import Detections, Masks
    from ._camera_arrays import SizeChoice
    from ._detection_arrays import Keypoints

#: What to do with a folder that holds something.
Existing = Literal["refuse", "resume", "overwrite"]


class Recording:
    """A folder with a calibration and with masks, pictures, videos, detections or points; or a ``sequence.toml``.

    Parameters
    ----------
    path
        The folder or file. docs/formats.md of the repository says what it may hold.
    fps
        Frames per second, in place of what the recording states.

    Raises
    ------
    RecordingError
        If there is no such recording, or its manifest is wrong.
    """

    def __init__(self, path: Path, *, fps: float | None = None) -> None:
        self.path: pathlib.Path = pathlib.Path(path)
        self.fps = fps
        self.body: str | None
        self.height: float | None
        #: The body model and the person's height (m) that its manifest names.
        self.body, self.height = _maquette.recording(os.fspath(path))
        self._scratch: Scratch | None = None

    @classmethod
    def from_arrays(
        cls,
        masks: Masks | None,
        K: ArrayLike,  # noqa: N803
        R: ArrayLike,  # noqa: N803
        t: ArrayLike,
        distortion: Sequence[ArrayLike] | None = None,
        *,
        detections: Detections | None = None,
        keypoints: Keypoints | None = None,
        size: SizeChoice = None,
        fps: float,
        up: Literal["z", "-z", "y", "-y"] = "z",
    ) -> Recording:
        """Make a recording of C cameras from masks, detections of joints, or both, and a calibration in memory.

        It lives in a temporary folder, for a recording consists of files.

        Parameters
        ----------
        masks
            Of each camera N masks as bool or uint8, of shape (N, H, W): a mapping by the cameras' names, or one after
            the other, also of shape (C, N, H, W). True, or any grey value but 0, is the person. None if there are
            detections alone.
        K
            Camera matrices, px, of shape (C, 3, 3); pixel (0, 0) is the centre of the top-left pixel.
        R, t
            World to camera, x_camera = R x + t, in metres, of shapes (C, 3, 3) and (C, 3).
        distortion
            Of each camera 4, 5 or 8 coefficients in OpenCV's order; default none.
        detections
            Of each camera, by name or in order, the J joints of P people in N frames: x and y in pixels of the recorded
            picture, and confidence, of shape (N, P, J, 3), or (N, J, 3) of one person. What is not a number, or has no
            confidence, was not seen. People may stand in any order. docs/detections.md says what a fit makes of them.
        keypoints
            Which joints they are and in which order, e.g. ``"halpe26"``; default by their number J.
        size
            Width and height of the pictures, px, of shape (2,) or (C, 2); default that of the masks.
        fps
            Frames per second.
        up
            Which axis of the world points up. Results have Z up.

        Raises
        ------
        OptionError
            If an array has another shape or type.

        Examples
        --------
        >>> rec = maquette.Recording.from_arrays(  # doctest: +SKIP
        ...     None, K, R, t, detections=found, keypoints="coco17", size=(1920, 1080), fps=50
        ... )
        """
        from ._arrays import Seen, written
        from ._camera_arrays import Cameras

        scratch = written(Seen(masks, detections, keypoints, size), Cameras(K, R, t, distortion), up)
        made = cls(scratch.path, fps=fps)
        made._scratch = scratch
        return made

    @staticmethod
    def stated(recording: Recording | Path, fps: float | None) -> tuple[Path, float | None]:
        """Where a recording is, and its frames per second as far as somebody states them; ``fps`` goes first."""
        if isinstance(recording, Recording):
            return recording.path, recording.fps if fps is None else fps
        return recording, fps

    def __repr__(self) -> str:
        """The call that makes it."""
        fps = "" if self.fps is None else f", fps={self.fps!r}"
        return f"Recording({str(self.path)!r}{fps})"

    def fit(
        self,
        *,
        body: str | None = None,
        cameras: Literal["trust", "refine", "check"] | None = None,
        clocks: Literal["trust", "estimate"] | None = None,
        frames: tuple[int, int] | None = None,
        height: float | None = None,
        keyframe_every: int | None = None,
        likelihood: Literal["ellipses", "published", "metaballs", "both"] | None = None,
        residual: Literal["distance", "field"] | None = None,
        joint: bool = True,
        pruning: bool = True,
        stereo: Literal["matching", "correlation"] | None = None,
        silhouettes: Literal["background", "joint"] | None = None,
        fit_to: Literal["all", "silhouettes", "points", "detections"] | None = None,
        people: int | Literal["auto"] | None = None,
        person: int | None = None,
        threads: int | None = None,
        out: Path | None = None,
        existing: Existing = "refuse",
        overlays: bool = False,
        progress: ProgressChoice = None,
    ) -> Fit:
        """Fit a body: shape, motion and confidence.

        This is ``maquette fit`` with the same options and the same numbers, to the last bit. It runs without the
        interpreter's lock. Ctrl-C ends it at its next step.

        Parameters
        ----------
        body
            A shipped body model or a ``.toml`` file; default that of the recording, or ``human-metaballs``.
        cameras
            Where the cameras are: where their calibration says (``trust``), about there (``refine``, the default),
            or as it says, with what would be refined told and not used (``check``).
        clocks
            Whether they took their pictures at once (``trust``), or by clocks whose offsets are estimated (default).
        frames
            First and last frame, both included; default all.
        height
            The person's height without shoes, m. It tests the size of the calibrated world and changes nothing else.
        keyframe_every
            Frames between keyframes, each of which proposes a body.
        likelihood
            What outlines are compared with; default ellipses, then metaballs where the body has them.
        residual
            What the metaballs' skin is compared by; default ``distance``.
        joint
            Fit all frames together at the end, which gives every number a standard deviation.
        pruning
            Drop a proposed body once it can no longer win.
        stereo
            Measure points with cameras that stand side by side, and fit to them too.
        silhouettes
            How outlines are found in pictures.
        fit_to
            What to fit to; default all there is.
        people
            How many people are looked for at most.
        person
            Who is measured, if there are several: 1 is who is in view longest.
        threads
            Threads; default all cores. The result does not depend on it.
        out
            Folder for the result; default a temporary one that lives as long as the result.
        existing
            What to do with an ``out`` that holds something.
        overlays
            Draw the fit over the masks, into ``out/overlays``.
        progress
            A function that is called with stage, steps done and steps in all, or True for bars.

        Returns
        -------
        Fit
            Also where it is not to be used: then a warning says why, and ``fit.usable`` is False.

        Raises
        ------
        MaquetteError
            With the one line that the program prints.
        KeyboardInterrupt
            After Ctrl-C. What was finished is kept in ``out``; ``existing="resume"`` goes on there.
        """
        scratch = Scratch() if out is None else None
        folder = scratch.path if scratch is not None else pathlib.Path(os.fspath(out or "."))
        given = words(
            self.path,
            out=folder,
            fps=self.fps,
            body=body,
            height=height,
            frames=frames,
            keyframe_every=keyframe_every,
            likelihood=likelihood,
            residual=residual,
            joint="on" if joint else "off",
            cameras=cameras,
            clocks=clocks,
            no_pruning=not pruning,
            stereo=stereo,
            silhouettes=silhouettes,
            fit_to=fit_to,
            people=people,
            person=person,
            threads=threads,
            overlays=overlays,
            resume=existing == "resume",
            overwrite=existing == "overwrite",
        )
        with listening(progress) as told:
            fitted = _maquette.fit(given, (told, news))
        fit = Fit(fitted, folder=folder, body=body, keeps=(scratch, self._scratch))
        if fit.why_unusable is not None:
            warnings.warn(fit.why_unusable, MaquetteWarning, stacklevel=2)
        return fit
