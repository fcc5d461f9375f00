"""The fitted body in 3-D, in a notebook."""

from __future__ import annotations

import pathlib
from html import escape

from ._folder import written_page
from ._words import Path


class Viewer:
    """The moving body as a page that needs nothing else; a notebook shows it in a frame.

    Made by :meth:`Fit.show`. It is the viewer of the report, and asks no network for anything.
    """

    def __init__(self, page: str, body: str, width: int | str, height: int) -> None:
        self._page = page
        self._body = body
        self._width = width
        self._height = height

    def save(self, path: Path) -> pathlib.Path:
        """Write the page as one HTML file that fills its window."""
        return written_page(path, self._page)

    def __repr__(self) -> str:
        """The body, and where it can be seen."""
        return f"<Viewer of {self._body}: in a notebook, or as a page by save()>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        frame = f'width="{escape(str(self._width))}" height="{self._height}" style="border: 1px solid #d8dce1"'
        title = f"{self._body} in 3-D"
        # scripts run, and reach nothing of the notebook
        return (
            f'<iframe sandbox="allow-scripts" title="{escape(title)}" {frame} srcdoc="{escape(self._page)}"></iframe>'
        )
