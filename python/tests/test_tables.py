"""Tables and arrays hold what result.json holds."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import maquette


def test_lengths_have_their_units_and_the_results_numbers(fit: maquette.Fit) -> None:
    """By name."""
    table = fit.lengths
    parts = fit.result["shape"]["lengths"]
    assert list(table.index) == [part["name"] for part in parts]
    assert list(table.columns) == ["length", "sd", "p"]
    assert_array_equal(table["length"], [part["length_m"] for part in parts])
    assert_array_equal(table["sd"], [part["sd_m"] for part in parts])
    assert_array_equal(table["p"], [part["confidence"]["p_within"] for part in parts])
    assert table.attrs["units"] == {"length": "m", "sd": "m", "p": "1"}
    assert table.attrs["p_within"] == 0.02


def test_angles_have_frames_names_times_and_units(fit: maquette.Fit) -> None:
    """In the order of the result."""
    angles = fit.angles
    frames = fit.result["motion"]["frames"]
    assert angles["value"].dims == ("frame", "angle") == angles["sd"].dims
    assert list(angles["angle"].values) == fit.result["motion"]["angles"]
    assert_array_equal(angles["value"], [frame["angles_rad"] for frame in frames])
    assert_array_equal(angles["sd"], [frame["sd"]["angles_rad"] for frame in frames])
    assert_array_equal(angles["frame"], [frame["frame"] for frame in frames])
    assert_array_equal(angles["time"], [frame["time_s"] for frame in frames])
    assert_array_equal(angles["views"], [frame["views"] for frame in frames])
    assert angles["value"].attrs["units"] == angles["sd"].attrs["units"] == "rad"
    assert angles["time"].attrs["units"] == "s"
    knee = angles.sel(angle="knee_flexion_r")
    assert float(knee["value"].max() - knee["value"].min()) > 0.5


def test_points_have_joints_and_axes(fit: maquette.Fit) -> None:
    """In metres, Z up."""
    points = fit.points
    frames = fit.result["motion"]["frames"]
    assert points["value"].dims == ("frame", "joint", "axis") == points["sd"].dims
    assert list(points["joint"].values) == fit.result["motion"]["points"]
    assert_array_equal(points["value"], [frame["points_m"] for frame in frames])
    assert_array_equal(points["sd"], [frame["sd"]["points_m"] for frame in frames])
    assert points["value"].attrs["units"] == "m"
    head = points["value"].sel(joint="Head", axis="z")
    assert bool((head > points["value"].sel(joint="Hip", axis="z")).all())


def test_cameras_have_what_was_found_of_them(fit: maquette.Fit) -> None:
    """Turns, displacements, focal lengths and clocks; what was not estimated is not a number."""
    table = fit.cameras
    parts = fit.result["quality"]["cameras"]
    assert list(table.index) == fit.result["recording"]["cameras"]
    assert_array_equal(table["iou"], [part["mean_iou"] for part in parts])
    found = [part for part in parts if part["found"]["pose"] is not None]
    assert found
    for part in found:
        row = {column: table[column].to_dict()[part["camera"]] for column in table.columns}
        pose = part["found"]["pose"]
        assert [row[f"turn_{axis}"] for axis in "xyz"] == pose["turn_deg"]
        assert [row[f"displacement_{axis}_sd"] for axis in "xyz"] == pose["displacement_sd_m"]
        assert [row["zoom"], row["zoom_sd"]] == [pose["zoom"], pose["zoom_sd"]]
        assert row["ahead"] == part["found"]["clock"]["ahead_s"]
    assert len(found) < len(parts) or table["turn_x"].notna().all()
    assert table.attrs["units"]["turn_x_sd"] == "deg"
    assert table.attrs["units"]["ahead"] == "s"


def test_the_covariance_is_that_of_the_coefficients(fit: maquette.Fit) -> None:
    """Its diagonal is the square of their standard deviations."""
    covariance, coefficients = fit.covariance, fit.coefficients
    assert covariance is not None
    assert list(covariance.index) == list(covariance.columns) == list(coefficients.index)
    spread = np.sqrt(np.diag(covariance.to_numpy()))
    np.testing.assert_allclose(spread, coefficients["sd"], rtol=1e-9)
    parts = fit.result["shape"]["coefficients"]
    assert_array_equal(coefficients["value"], [part["value"] for part in parts])
    assert_array_equal(coefficients["prior_sd"], [part["prior_sd"] for part in parts])


def test_one_hypothesis_won_and_it_is_the_most_probable_that_was_finished(
    fit: maquette.Fit,
) -> None:
    """The winner is named in the result."""
    table = fit.hypotheses
    won = table[table["outcome"] == "won"]
    assert list(won.index) == [fit.result["winner"]]
    finished = table[table["outcome"] != "pruned"]
    assert won["minus_log_posterior"].iloc[0] == finished["minus_log_posterior"].min()
    assert table.attrs["units"]["length_thigh"] == "m"
    parts = fit.result["hypotheses"]
    assert_array_equal(table["length_thigh"], [part["lengths_m"][0] for part in parts])


def test_arrays_own_their_memory_and_can_be_written_to(fit: maquette.Fit) -> None:
    """Writing to one does not change the fit."""
    angles = fit.angles
    angles["value"][:] = 0.0
    assert float(np.abs(fit.angles["value"]).max()) > 0.0


def test_gait_angles_are_those_of_the_fit_by_side(fit: maquette.Fit) -> None:
    """A knee bends as the body's own hinge does."""
    gait = fit.gait()
    angles = gait.angles
    assert angles["value"].dims == ("side", "angle", "frame")
    knee = angles["value"].sel(side="right", angle="knee_flexion")
    assert_array_equal(knee["frame"], fit.frames)
    np.testing.assert_allclose(knee["time"], fit.angles["time"])
    own = fit.angles["value"].sel(angle="knee_flexion_r")
    np.testing.assert_allclose(knee, own, atol=1e-9)
    assert angles["sd"].attrs["units"] == "rad"


def test_gait_has_steps_events_and_curves(fit: maquette.Fit) -> None:
    """As gait.json has them."""
    gait = fit.gait()
    assert list(gait.events.columns) == ["side", "kind", "time"]
    assert list(gait.events["time"]) == [part["time_s"] for part in gait.result["events"]]
    (part,) = (part for part in gait.result["parameters"] if part["name"] == "step_length")
    step = ("step_length", "left")
    assert gait.parameters["mean"].to_dict()[step] == part["left"]["mean"]
    assert gait.parameters["unit"].to_dict()[step] == "m"
    assert 0.2 < part["left"]["mean"] < 1.2
    curves = gait.curves
    assert curves["mean"].dims == ("side", "angle", "percent")
    assert curves["mean"].attrs["units"] == "deg"
    assert curves["percent"].values[[0, -1]].tolist() == [0.0, 100.0]
    curve = next(c for c in gait.result["curves"] if c["angle"] == "knee_flexion")
    mean = curves["mean"].sel(angle="knee_flexion", side=curve["side"])
    assert_array_equal(mean, curve["mean_deg"])


def test_options_of_gait_are_heard(fit: maquette.Fit) -> None:
    """Each changes what it names."""
    gait = fit.gait()
    assert fit.gait(cutoff=5.0).result["cutoff_hz"] == 5.0 != gait.result["cutoff_hz"]
    assert fit.gait(surface="treadmill").result["surface"] == "treadmill" != gait.result["surface"]
    assert fit.gait(norm="none").result["norm"] is None
    aged = fit.gait(age=70, sex="female").result["norm"]["parameters_source"]
    assert aged != gait.result["norm"]["parameters_source"]
    with pytest.raises(maquette.errors.GaitError):
        fit.gait(pass_=7)


def test_events_that_a_person_corrected_stand_in_the_place_of_those_that_are_found(
    fit: maquette.Fit, tmp_path: pathlib.Path
) -> None:
    """From a file as the report's page saves it."""
    found = fit.gait().result
    fps = found["fps"]
    events = [{"side": e["side"], "kind": e["kind"], "frame": e["time_s"] * fps} for e in found["events"]]
    head = {"format": "maquette-events", "version": 1, "fps": fps, "first_frame": 0, "frames": found["frames"]}
    path = tmp_path / "events.json"
    path.write_text(json.dumps({**head, "events": events[1:]}), encoding="utf-8")
    corrected = fit.gait(events=path).result
    assert (found["event_source"], corrected["event_source"]) == ("detected", "person")
    assert len(corrected["events"]) == len(events) - 1
    path.write_text(json.dumps({**head, "frames": 1, "events": []}), encoding="utf-8")
    with pytest.raises(maquette.errors.GaitError, match=r"events\.json: frames 1, but"):
        fit.gait(events=path)
