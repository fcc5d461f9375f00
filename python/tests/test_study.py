"""A study: what is computed, what is not computed again, and what fails."""

from __future__ import annotations

import pathlib
import pickle
import shutil
from importlib import import_module

import pytest
from conftest import Program
from study_files import HEAD, OF_SESSIONS, contents, walks, written

import maquette
from maquette import study
from maquette.study import Outcome, Task

pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """Three walks."""
    folder = tmp_path_factory.mktemp("study")
    walks(folder / "walks", 3)
    return folder


@pytest.fixture(scope="module")
def cohort(folder: pathlib.Path) -> study.Study:
    """A study of them, of the same walk twice, and of two that cannot be fitted; it has run."""
    (folder / "walks" / "empty").mkdir()
    rows = ("a,walks/0,41", "b,walks/1,52", "twin,walks/0,63", "gone,walks/9,64", "c,walks/2,75", "empty,walks/empty,")
    cohort = written(folder, *rows, columns="trial,recording,age")
    tally = study.run(cohort, jobs=2)
    assert (tally.of, tally.computed) == ({"usable": 4, "failed": 2}, 3)
    study.gather(cohort)
    return cohort


def test_a_fit_of_a_study_is_the_program_s(cohort: study.Study, program: Program, tmp_path: pathlib.Path) -> None:
    """To the last bit."""
    recording = cohort.task("a").trials[0][1]
    options = ("--body", "human-ellipsoids", "--keyframe-every", "4")
    made = program("fit", recording, "--out", tmp_path / "a", *options, "--quiet")
    assert made.returncode == 0, made.stderr
    key = next(outcome.key for outcome in study.outcomes(cohort) if outcome.name == "a")
    result = pathlib.Path(cohort.results, "fits", str(key), "result.json")
    assert result.read_bytes() == (tmp_path / "a" / "result.json").read_bytes()


def test_what_was_done_is_not_done_again(cohort: study.Study) -> None:
    """Also by another run, and two trials of one content share a fit."""
    before = contents(cohort)
    assert study.run(cohort, jobs=1).computed == 0
    assert contents(cohort) == before
    keys = {outcome.name: outcome.key for outcome in study.outcomes(cohort)}
    assert keys["a"] == keys["twin"] != keys["b"]


def test_a_trial_that_changed_is_computed_again_and_no_other(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """A mask, or an option."""
    shutil.copytree(folder / "walks", tmp_path / "walks")
    rows = ("a,walks/0,50", "b,walks/1,50")
    cohort = written(tmp_path, *rows, columns="trial,recording,fit.fps")
    assert study.run(cohort, jobs=2).computed == 2

    masks = sorted((tmp_path / "walks" / "1" / "masks" / "cam_01").glob("*.png"))
    masks[1].write_bytes(masks[2].read_bytes())
    assert study.run(cohort, jobs=2).computed == 1
    cohort = written(tmp_path, "a,walks/0,25", "b,walks/1,50", columns="trial,recording,fit.fps")
    assert study.run(cohort, jobs=2).computed == 1


def test_a_recording_that_moves_keeps_its_fit(
    cohort: study.Study, folder: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    """The name of a fit is made of contents."""
    shutil.copytree(folder / "walks" / "0", tmp_path / "elsewhere")
    there = Task("x", (("x", str(tmp_path / "elsewhere")),), cohort.options, {}, False, cohort.results)
    assert not study.compute(there).is_new


def test_the_dataset_has_a_row_for_every_trial(cohort: study.Study) -> None:
    """In the order of the study, with what its table says; of those that fail the line that says why."""
    pandas = import_module("pandas")
    trials = pandas.read_parquet(f"{cohort.results}/dataset/trials").set_index("trial")
    assert list(trials.index) == ["a", "b", "twin", "gone", "c", "empty"]
    assert list(trials["age"].dropna()) == [41, 52, 63, 64, 75]
    assert list(trials["status"]) == ["usable", "usable", "usable", "failed", "usable", "failed"]
    assert trials.loc["gone", "reason"].endswith("walks/9: no such folder or file")
    assert "no masks" in trials.loc["empty", "reason"]
    assert trials.loc["a", "frames"] == 8


def test_the_dataset_has_the_numbers_of_the_fits(cohort: study.Study) -> None:
    """As the package gives them, and under each trial's own name."""
    pandas = import_module("pandas")
    lengths = pandas.read_parquet(f"{cohort.results}/dataset/lengths").set_index(["trial", "name"])
    key = next(outcome.key for outcome in study.outcomes(cohort) if outcome.name == "twin")
    fit = maquette.load(pathlib.Path(cohort.results, "fits", str(key)))
    assert list(lengths.loc["twin"]["sd_m"]) == list(fit.lengths["sd"])
    assert set(lengths.index.unique("trial")) == {"a", "b", "twin", "c"}


@pytest.mark.parametrize("reader", ["duckdb", "polars"])
def test_other_programs_read_the_dataset(cohort: study.Study, reader: str) -> None:
    """Two that share no reader with pandas."""
    package = pytest.importorskip(reader)
    where = f"{cohort.results}/dataset/lengths/*.parquet"
    if reader == "duckdb":
        ((count,),) = package.sql(f"select count(*) from '{where}' where trial = 'a'").fetchall()
    else:
        count = package.scan_parquet(where).filter(package.col("trial") == "a").collect().height
    assert count == 8


def test_a_session_has_one_body_for_its_trials(tmp_path: pathlib.Path) -> None:
    """The trials keep the names of the table."""
    for number in range(2):
        maquette.synth(tmp_path / f"{number}", seed=100, trial=number, cameras=3, frames=8)
    rows = ("first,p,0", "second,p,1")
    cohort = written(tmp_path, *rows, columns="trial,session,recording", head=OF_SESSIONS)
    assert study.run(cohort, jobs=1).of == {"usable": 1}
    study.gather(cohort)
    pandas = import_module("pandas")
    lengths = pandas.read_parquet(f"{cohort.results}/dataset/lengths").pivot(index="name", columns="trial")["length_m"]
    assert list(lengths["first"]) == list(lengths["second"])


def test_files_of_options_are_found_from_everywhere(tmp_path: pathlib.Path) -> None:
    """They are seen from the study's folder, and shipped bodies are no files."""
    cohort = written(tmp_path, "a,x,mine.toml", "b,x,human-ellipsoids", columns="trial,recording,fit.body", head="")
    assert cohort.task("a").options == {"body": str(tmp_path / "mine.toml")}
    assert cohort.task("b").options == {"body": "human-ellipsoids"}


def test_a_process_that_ends_is_a_row_and_not_the_end(cohort: study.Study, tmp_path: pathlib.Path) -> None:
    """One that needs more memory than its share."""
    alone = written(tmp_path, f"a,{cohort.task('a').trials[0][1]}")
    assert study.run(alone, jobs=1, memory_gib=0.02).of == {"lost": 1}
    (outcome,) = study.outcomes(alone)
    assert outcome.reason is not None
    assert "(3 attempts)" in outcome.reason
    assert study.run(alone, jobs=1, memory_gib=4).of == {"usable": 1}


def test_a_task_can_be_pickled_and_written(cohort: study.Study) -> None:
    """For engines that hand it on."""
    task = cohort.task("b")
    assert pickle.loads(pickle.dumps(task)) == task == Task.of_json(task.json())
    outcome = Outcome("b", "failed", "why", "key", True, 1.5, 0.5)
    assert Outcome.of_json(outcome.json()) == outcome


def test_the_command_does_all_of_it(cohort: study.Study, program: Program, tmp_path: pathlib.Path) -> None:
    """Run, gather, report; failures are told, and are no failure of the study."""
    ran = program("study", cohort.path, "--quiet", "--jobs", "1")
    assert ran.returncode == 0, ran.stderr
    assert "6 tasks: 2 failed, 4 usable; 0 computed now" in ran.stdout
    assert "gone: failed: " in ran.stderr
    done = program("study", "task", cohort.path, "a")
    assert Outcome.of_json(done.stdout).status == "usable"
    page = tmp_path / "page.html"
    assert program("study", "report", cohort.path, "--out", page).returncode == 0
    text = page.read_text(encoding="utf-8")
    assert "6 trials" in text
    assert "walks/9: no such folder or file" in text
    assert "thigh, m" in text


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--jobs", "0"], "error: jobs: expected 1 or more, found 0"),
        (["--memory-gib", "much"], "error: argument --memory-gib: invalid float value: 'much'"),
        (["--speed", "9"], "error: unrecognized arguments: --speed 9"),
    ],
)
def test_words_that_make_no_sense_are_refused(
    cohort: study.Study, program: Program, words: list[str], told: str
) -> None:
    """In one line."""
    failed = program("study", cohort.path, "--quiet", *words)
    assert (failed.returncode, failed.stderr) == (2, told + "\n")


def test_a_page_before_a_dataset_is_refused(tmp_path: pathlib.Path, program: Program) -> None:
    """In one line."""
    written(tmp_path, "a,nowhere")
    failed = program("study", "report", tmp_path / "study.toml")
    assert failed.returncode == 2
    assert failed.stderr.startswith("error: ")
    assert "`maquette study gather` writes it" in failed.stderr


@pytest.mark.parametrize(
    ("head", "columns", "row", "told"),
    [
        (HEAD + "bdoy = 1\n", "trial,recording", "a,x", "'bdoy' is none of"),
        ("[fti]\n", "trial,recording", "a,x", "'fti' is none of"),
        ("[fit\n", "trial,recording", "a,x", "study.toml: "),
        ('unit = "person"\n', "trial,recording", "a,x", "unit: expected"),
        (HEAD, "trial,path", "a,x", "expected a column 'recording', found trial, path"),
        ('unit = "session"\n', "trial,recording", "a,x", "expected a column 'session'"),
        (HEAD, "trial,recording", "a/b,x", "row 1: trial 'a/b': expected letters"),
        (HEAD, "trial,recording", "a,", "row 1: recording is empty"),
        (HEAD, "trial,recording", "a,x\na,y", "trial a stands there twice"),
        (HEAD, "trial,recording,fit.speed", "a,x,1", "'fit.speed' is none of"),
        (HEAD, "trial,recording,key", "a,x,1", "column 'key' is one of the dataset's own"),
    ],
)
def test_a_study_that_cannot_be_is_refused(
    tmp_path: pathlib.Path, head: str, columns: str, row: str, told: str
) -> None:
    """In one line that says where and what."""
    with pytest.raises(maquette.OptionError) as fault:
        written(tmp_path, row, head=head, columns=columns)
    assert told in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_study_without_a_table_is_refused(tmp_path: pathlib.Path) -> None:
    """And one that is not there."""
    with pytest.raises(maquette.OptionError, match=r"cannot read .*study\.toml"):
        study.read(tmp_path / "study.toml")
    (tmp_path / "study.toml").write_text("", encoding="utf-8")
    with pytest.raises(maquette.OptionError, match=r"cannot read .*trials\.csv"):
        study.read(tmp_path / "study.toml")
