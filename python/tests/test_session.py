"""Sessions and what changed between them are the program's."""

from __future__ import annotations

import json
import pathlib
import shutil

import pytest
from conftest import Program

import maquette


@pytest.fixture(scope="module")
def days(tmp_path_factory: pytest.TempPathFactory) -> list[maquette.Session]:
    """Two days of one person, two walks each."""
    folder = tmp_path_factory.mktemp("days")
    sessions: list[maquette.Session] = []
    for day in range(2):
        trials = [
            maquette.synth(folder / f"walks_{day}" / f"walk_{n}", seed=5, trial=2 * day + n, cameras=3, frames=60)
            for n in range(2)
        ]
        sessions.append(maquette.session(trials, out=folder / f"day_{day}", body="human-ellipsoids"))
    return sessions


def test_a_session_is_the_programs_byte_for_byte(
    days: list[maquette.Session], tmp_path: pathlib.Path, program: Program
) -> None:
    """And holds one body for all trials."""
    first = days[0]
    walks = first.folder.parent / "walks_0"
    made = program("session", walks, "--out", tmp_path / "out", "--body", "human-ellipsoids", "--quiet")
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "out" / "session.json").read_bytes() == (first.folder / "session.json").read_bytes()
    assert first.names == ["walk_0", "walk_1"]
    assert (first.folder / "alone" / "walk_0").is_dir()
    lengths = [first.trial(name).lengths["length"] for name in first.names]
    assert lengths[0].equals(lengths[1])
    assert lengths[0].equals(first.lengths["length"])
    page = first.report(tmp_path / "report.html").read_text()
    assert "walk_1" in page
    german = first.report(tmp_path / "bericht.html", language="de").read_text()
    assert '<html lang="de">' in german
    with pytest.raises(maquette.ResultError, match="walk_0, walk_1"):
        first.trial("walk_7")


def test_a_comparison_is_the_programs(days: list[maquette.Session], tmp_path: pathlib.Path, program: Program) -> None:
    """The same numbers as a table."""
    comparison = days[0].compare(days[1])
    folders = [day.folder for day in days]
    told = program("compare", *folders, "--out", tmp_path / "out", "--json", "--quiet")
    assert told.returncode == 0, told.stderr
    expected = json.loads(told.stdout)["changes"]
    table = comparison.changes
    assert list(table["change"]) == [part["change"] for part in expected]
    assert list(table["unit"]) == [part["unit"] for part in expected]
    assert ("speed", "left") in table.index or ("step_length", "left") in table.index
    comparison.report(tmp_path / "change.html")
    assert (tmp_path / "change.html").stat().st_size > 10_000


def test_two_conditions_of_a_session_are_compared(days: list[maquette.Session], tmp_path: pathlib.Path) -> None:
    """Where its trials have two."""
    one = days[0]
    with pytest.raises(maquette.MaquetteError, match="expected two, found none"):
        one.compare_conditions()
    copy = tmp_path / "conditions"
    shutil.copytree(one.folder, copy)
    result = json.loads((copy / "session.json").read_text())
    for trial, condition in zip(result["trials"], ["barefoot", "shoes"], strict=True):
        trial["condition"] = condition
    (copy / "session.json").write_text(json.dumps(result))
    session = maquette.Session(copy)
    with pytest.raises(maquette.MaquetteError, match="barefoot, shoes"):
        session.compare_conditions(("barefoot", "sandals"))
    table = session.compare_conditions(("shoes", "barefoot")).changes
    assert list(table["change"]) == [-change for change in session.compare_conditions().changes["change"]]


def test_the_sides_of_a_session_are_compared(days: list[maquette.Session]) -> None:
    """The right one less the left one."""
    table = days[0].compare_sides().changes
    assert set(table.index.get_level_values("side")) == {"both"}
    assert list(table["change"]) == pytest.approx(list(table["after"] - table["before"]))


def test_a_folder_without_a_session_is_refused(tmp_path: pathlib.Path) -> None:
    """As is a session of nothing."""
    with pytest.raises(maquette.ResultError, match="expected the folder of a finished"):
        maquette.Session(tmp_path)
    with pytest.raises(maquette.MaquetteError):
        maquette.session([tmp_path], out=tmp_path / "out")
