"""A fitted body."""

from __future__ import annotations

import json
import pathlib
import tempfile
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from . import _camera_table, _html, _maquette, _plot, _tables
from ._folder import Scratch, copied, written_page
from ._gait import Gait
from ._progress import ProgressChoice, caution, listening
from ._show import Viewer
from ._words import Path, words
from .errors import OptionError, UnusableError

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: A format of another program.
Format = Literal["c3d", "trc", "mot", "sto", "bvh", "glb", "csv", "parquet", "ply", "obj"]

_RESULT = "result.json"
_ORIGIN = "recording.toml"


class Fit:
    """A fitted body: its lengths, its motion, and how sure both are.

    Made by :meth:`Recording.fit` and :func:`load`. It can be pickled.

    Attributes
    ----------
    folder : pathlib.Path
        The folder that it was written into or read from.
    """

    def __init__(
        self,
        fitted: _maquette.Fitted,
        *,
        folder: pathlib.Path,
        body: str | None = None,
        keeps: tuple[Scratch | None, ...] = (),
    ) -> None:
        self._fitted = fitted
        self._body = body
        # temporary folders of the result and of its recording
        self._keeps = keeps
        self.folder: pathlib.Path = folder.absolute()

    # --- the result as it is -------------------------------------------------------------------

    @property
    def json(self) -> bytes:
        """``result.json``, byte by byte."""
        return self._fitted.json()

    @cached_property
    def result(self) -> dict[str, Any]:
        """All of ``result.json``, which docs/formats.md describes field by field."""
        result: dict[str, Any] = json.loads(self.json)
        return result

    @property
    def body(self) -> str:
        """Name of the body model."""
        return str(self.result["body"])

    @property
    def fps(self) -> float:
        """Frames per second."""
        return float(self.result["recording"]["fps"])

    @property
    def frames(self) -> NDArray[np.int64]:
        """Numbers of the frames, of shape (N,)."""
        return self._fitted.frame_numbers()

    @property
    def usable(self) -> bool:
        """Whether the numbers can be used."""
        return self.why_unusable is None

    @property
    def why_unusable(self) -> str | None:
        """The verdict of a fit that is not to be used, in one line."""
        try:
            self._fitted.check_usable()
        except UnusableError as verdict:
            return str(verdict)
        return None

    @property
    def warnings(self) -> list[str]:
        """What a person should know, in plain words; the verdict first."""
        return list(self.result["warnings"])

    # --- shape and cameras -----------------------------------------------------------------------------------

    @property
    def lengths(self) -> pd.DataFrame:
        """The lengths of the body at rest.

        Returns
        -------
        pandas.DataFrame
            By the name of the length: ``length`` (m), ``sd`` (m, not a number without the joint optimum) and ``p``,
            the probability that one of the keyframes' own estimates lies within 2 cm of it. ``attrs["units"]`` has
            the units.

        Raises
        ------
        UnusableError
            Of a fit that is not to be used.

        Notes
        -----
        ``p`` is p(K) of Zimmermann and Svoboda, after Algorithm 1: a confidence of the model's optimum. An error that
        all keyframes share does not show in it.
        """
        self._fitted.check_usable()
        return _tables.lengths(self.result)

    @property
    def coefficients(self) -> pd.DataFrame:
        """The shape coefficients: ``value``, ``sd``, ``prior_mean`` and ``prior_sd``, by name.

        Coefficients are logarithms of scales, or metres of shifts; docs/formats.md, body models.
        """
        return _tables.coefficients(self.result)

    @property
    def covariance(self) -> pd.DataFrame | None:
        """Covariance of the shape coefficients, by name on both axes.

        None without the joint optimum, and of a fit that is not to be used.
        """
        return _tables.covariance(self.result)

    @property
    def hypotheses(self) -> pd.DataFrame:
        """Every explanation that was tried, and what became of it.

        Returns
        -------
        pandas.DataFrame
            ``origin``, ``keyframe``, ``reading``, ``outcome`` (``won``, ``finished``, ``pruned``), ``frames_fitted``,
            ``minus_log_posterior`` (a lower bound of it if pruned), ``keyframe_cost``, ``iou``, and each length in
            metres as ``length_<name>``.
        """
        return _tables.hypotheses(self.result)

    @property
    def cameras(self) -> pd.DataFrame:
        """Every camera: how well the body covers what it saw, and how far it was found to be from its calibration.

        Returns
        -------
        pandas.DataFrame
            By ``camera``: ``frames`` in which it sees the person, mean overlap ``iou``, ``median`` distance of outlines
            (px); ``turn_x`` … ``turn_z`` (deg) about its own centre and ``displacement_x`` … ``displacement_z`` (m),
            world axes, and ``zoom``, its focal length over the calibrated one, each with its ``_sd``; by how much its
            pictures are ``ahead`` of the recording's time (s), and ``ahead_sd``. What was not estimated is NaN.
            ``attrs["units"]`` has the units.
        """
        return _camera_table.of_fit(self.result)

    # --- motion ------------------------------------------------------------------------------------

    @property
    def angles(self) -> xr.Dataset:
        """The angles of the body's joints, frame by frame.

        Returns
        -------
        xarray.Dataset
            ``value`` and ``sd`` over (frame, angle), rad, as the model has them; ``sd`` is not a number without the
            joint optimum. Coordinates: ``time`` (s) and ``views``, the number of cameras that see the person; where
            that is 0 the motion is a guess. Angles of gait analysis are those of :meth:`gait`.

        Raises
        ------
        UnusableError
            Of a fit that is not to be used.
        """
        self._fitted.check_usable()
        return _tables.angles(self._fitted, self.result)

    @property
    def points(self) -> xr.Dataset:
        """The joint centres and other points of the body, frame by frame.

        Returns
        -------
        xarray.Dataset
            ``value`` and ``sd`` over (frame, joint, axis), m, in the world with Z up. Coordinates as of
            :attr:`angles`.
        """
        return _tables.points(self._fitted, self.result)

    def gait(
        self,
        *,
        cutoff: float | None = None,
        surface: Literal["ground", "treadmill"] | None = None,
        pass_: int | None = None,
        events: Path | Literal["none"] | None = None,
        norm: Path | Literal["none"] | None = None,
        age: int | None = None,
        sex: Literal["female", "male"] | None = None,
        neutral: Path | None = None,
    ) -> Gait:
        """Analyse how the person walks.

        Parameters
        ----------
        cutoff
            Cutoff of the low-pass filter on all points, Hz; 0 turns it off. Default 10.
        surface
            What the person walks on; default detected.
        pass_
            Which pass through the room, if the person leaves and comes back; default the longest.
        events
            Foot strikes and foot offs as a person corrected them on the report's page; ``"none"`` for those that the
            program finds. Default ``events.json`` of the fit's folder, if it is there.
        norm
            Healthy people to compare with: a ``.toml`` file or ``"none"``; default the shipped norm of the age.
        age, sex
            Choose the norms, the sex that of steps and strides alone; years.
        neutral
            Folder of a fit of the same body, in which the person stands still: angles are counted from that pose.

        Raises
        ------
        GaitError
            Says why there is no gait to be analysed.
        """
        options = {"cutoff": cutoff, "surface": surface, "pass": pass_, "events": events}
        options |= {"norm": norm, "age": age, "sex": sex, "neutral": neutral}
        return Gait(self._fitted.gait(words(self.folder, **options)))

    # --- files -----------------------------------------------------------------------------------------

    def save(self, folder: Path) -> pathlib.Path:
        """Write ``result.json`` and ``joints.trc`` into a folder, which is made where there is none."""
        self._fitted.save(folder)
        return pathlib.Path(folder)

    def report(
        self,
        path: Path,
        *,
        subject: str | None = None,
        age: int | None = None,
        sex: Literal["female", "male"] | None = None,
        date: str | None = None,
        condition: str | None = None,
        footwear: Literal["barefoot", "shoes"] | None = None,
        events: Path | Literal["none"] | None = None,
        norm: Path | Literal["none"] | None = None,
        recording: Path | None = None,
        pictures: bool = True,
        language: Literal["en", "de"] | None = None,
        progress: ProgressChoice = None,
    ) -> pathlib.Path:
        """Write the page that a clinician reads: one HTML file that needs nothing else.

        Parameters
        ----------
        path
            The file.
        subject, age, sex, date, condition, footwear
            Who was recorded and how, as the report should say it.
        events, norm
            As of :meth:`gait`.
        recording
            The recording, which shows what the cameras saw; default where the fit found it.
        pictures
            Show the recorded pictures under the outlines.
        language
            Of the page; default English.
        progress
            As of :meth:`Recording.fit`.
        """
        given = words(
            self.folder,
            subject=subject,
            age=age,
            sex=sex,
            date=date,
            condition=condition,
            footwear=footwear,
            events=events,
            norm=norm,
            recording=recording,
            no_pictures=not pictures,
            language=language,
        )
        with listening(progress) as told:
            page = self._fitted.report(given, (told, caution))
        return written_page(path, page)

    def export(self, format: Format, path: Path) -> pathlib.Path:
        """Write the fit in a format of another program.

        Parameters
        ----------
        format
            ``c3d``, ``trc``, ``mot``, ``sto``, ``bvh``, ``glb``, ``csv`` or ``parquet``; or ``ply`` and ``obj``, the
            body's surface as a file per frame. docs/formats.md says what each holds. Every file's world is Y up.
        path
            The file; of ``ply`` and ``obj`` the folder.

        Raises
        ------
        OptionError
            If there is no such format, or the file's ending is another.
        """
        path = pathlib.Path(path)
        if format not in ("ply", "obj") and path.suffix != f".{format}":
            raise OptionError(f"{path}: expected a name that ends in .{format}")
        events = beside if (beside := self.folder / "events.json").exists() else None
        with tempfile.TemporaryDirectory(prefix="maquette-") as scratch:
            (written,) = self._fitted.export(words(scratch, format=format, events=events))
            return copied(written, path)

    # --- pictures -----------------------------------------------------------------------------------

    def plot(self, *angles: str) -> Figure:
        """Plot angles over time, with bands of 1.96 standard deviations.

        Parameters
        ----------
        *angles
            Names of angles of the model; default flexion of hips, knees and ankles, as far as the body has them.
        """
        return _plot.angles(self.angles, angles)

    def show(self, *, width: int | str = "100%", height: int = 480) -> Viewer:
        """Show the fitted body in 3-D as it moves.

        A notebook shows it: to play, to turn by dragging, to zoom by the wheel. :meth:`Viewer.save` writes a page.

        Parameters
        ----------
        width, height
            Of its frame, pixels; the width may also be a share of the notebook's.

        Raises
        ------
        GaitError
            Of fewer than 10 frames, and of a body that has no legs.
        """
        return Viewer(self._fitted.viewer(), str(self.result["body"]), width, height)

    def __repr__(self) -> str:
        """The body, the frames, and whether it can be used."""
        recording = self.result["recording"]
        verdict = "" if self.usable else ", not to be used"
        frames = f"{recording['frames']} frames of {len(recording['cameras'])} cameras"
        return f"<Fit of {self.body}: {frames}{verdict}>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return _html.fit(self.result, self.why_unusable)

    # --- pickling ------------------------------------------------------------------------------------

    def __reduce__(self) -> tuple[Any, ...]:
        """The result's own bytes, and where its recording is."""
        origin = _maquette.origin(self.folder)
        return _restored, (self.json, self._body, origin and str(origin.resolve()))


def load(folder: Path, *, body: str | None = None) -> Fit:
    """Read the folder of a finished fit.

    Parameters
    ----------
    folder
        What ``maquette fit --out``, ``Recording.fit(out=…)`` or :meth:`Fit.save` has written.
    body
        Its body model, if it is not a shipped one.

    Raises
    ------
    ResultError
        If it holds no result, or one that was changed since.
    """
    return Fit(_maquette.Fitted.read(folder, body), folder=pathlib.Path(folder), body=body)


def _restored(result: bytes, body: str | None, origin: str | None) -> Fit:
    """A fit that was pickled, in a temporary folder."""
    scratch = Scratch()
    (scratch.path / _RESULT).write_bytes(result)
    if origin is not None:
        # TOML's basic strings are written as JSON's
        (scratch.path / _ORIGIN).write_text(f"path = {json.dumps(origin)}\n", encoding="utf-8")
    fitted = _maquette.Fitted.read(scratch.path, body)
    return Fit(fitted, folder=scratch.path, body=body, keeps=(scratch,))
