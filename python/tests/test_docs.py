"""What the documentation shows works."""

from __future__ import annotations

import pathlib
import re

import pytest
from conftest import REPOSITORY

pytest.importorskip("matplotlib").use("agg")


def _snippets(text: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def test_every_snippet_of_the_page_runs(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One after the other, in a folder that holds the sample recording."""
    (tmp_path / "data").symlink_to(REPOSITORY / "data")
    monkeypatch.chdir(tmp_path)
    snippets = _snippets((REPOSITORY / "docs" / "python.md").read_text(encoding="utf-8"))
    assert len(snippets) == 4
    names: dict[str, object] = {}
    for snippet in snippets:
        exec(compile(snippet, "docs/python.md", "exec"), names)

    made = {path.name for path in tmp_path.iterdir()}
    assert made == {"data", "knees.png", "report.html", "body.html", "walker.c3d", "out", "walks", "before.html"}
    assert "no frame of the recording lies in this range" in capsys.readouterr().out
