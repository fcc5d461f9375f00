"""The fitted body in 3-D."""

from __future__ import annotations

import html
import json
import pathlib
import re

import maquette


def test_a_notebook_shows_the_body_in_a_frame_that_asks_for_nothing(fit: maquette.Fit) -> None:
    """The page is the frame's own, its scene the fit's; its scripts reach nothing outside."""
    viewer = fit.show(width=600, height=300)
    frame = viewer._repr_html_()
    found = re.fullmatch(r'<iframe ([^>]*?) srcdoc="([^"]*)"></iframe>', frame)
    assert found is not None
    assert 'width="600" height="300"' in found[1]
    assert 'sandbox="allow-scripts"' in found[1]
    page = html.unescape(found[2])
    assert not re.search(r'(src|href)="(?!#)', page)
    scene = re.search(r'<script type="application/json" id="scene">(.*?)</script>', page, flags=re.DOTALL)
    assert scene is not None
    shown = json.loads(scene[1])
    assert shown["frames"] == 64
    assert shown["fps"] == 50.0
    assert len(shown["body"]["flesh"]["ellipsoids"]) > 10
    assert "human-ellipsoids" in repr(viewer)


def test_the_page_can_be_saved(fit: maquette.Fit, tmp_path: pathlib.Path) -> None:
    """As one file, smaller than a megabyte and a half."""
    path = fit.show().save(tmp_path / "body.html")
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert path.stat().st_size < 1_500_000
