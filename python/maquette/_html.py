"""What notebooks show of a result."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Any


def fit(result: dict[str, Any], why_unusable: str | None) -> str:
    """The lengths of a fit, and what a person should know of it."""
    recording = result["recording"]
    head = f"{recording['frames']} frames of {len(recording['cameras'])} cameras, {result['body']}"
    verdict = [] if why_unusable is None else [f"Not to be used: {why_unusable}"]
    rows = [] if verdict else [_length(part) for part in result["shape"]["lengths"]]
    # an unusable fit's first warning is its verdict
    warnings = result["warnings"][len(verdict) :]
    return _block(head, ("length", "cm", "± SD"), rows, [*verdict, *warnings])


def _length(part: dict[str, Any]) -> tuple[str, str, str]:
    sd = part["sd_m"]
    spread = "" if sd is None else f"{100 * sd:.1f}"
    return part["name"].replace("_", " "), f"{100 * part['length_m']:.1f}", spread


def gait(result: dict[str, Any]) -> str:
    """The parameters of a walk, and what a person should know of it."""
    rows = [
        (part["name"].replace("_", " "), side, f"{part[side]['mean']:.2f}", part["unit"])
        for part in result["parameters"]
        for side in ("left", "right")
        if part[side] is not None
    ]
    head = f"{len(result['events'])} events in {result['frames']} frames"
    return _block(head, ("parameter", "side", "mean", "unit"), rows, result["notes"])


def _block(head: str, columns: Iterable[str], rows: Iterable[Iterable[str]], lines: Iterable[str]) -> str:
    """A heading, a table, and lines below it."""
    table = "".join(_row("td", row) for row in rows)
    below = "".join(f"<p>{escape(line)}</p>" for line in lines)
    whole = f"<table><thead>{_row('th', columns)}</thead><tbody>{table}</tbody></table>"
    return f"<div><p><b>{escape(head)}</b></p>{whole if table else ''}{below}</div>"


def _row(tag: str, cells: Iterable[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"
