"""Where results are: a folder on a disk, or an object store.

``fits/<key>/`` holds a fit, its rows, and last of all ``outcome.json``: where that stands, all of it stands.
"""

from __future__ import annotations

import json
import os
import pathlib
import uuid
from typing import Any

from .._optional import imported

_OUTCOME = "outcome.json"


class Store:
    """The results of a study.

    Parameters
    ----------
    address
        A folder, or an address that fsspec knows.
    """

    def __init__(self, address: str) -> None:
        self._files, self._root = imported("fsspec.core", "study").url_to_fs(address)

    def path(self, *names: str) -> str:
        """The path of something below the root."""
        return "/".join((self._root.rstrip("/"), *names))

    def outcome(self, key: str) -> dict[str, Any] | None:
        """What became of the task of this key; None if it was not done."""
        try:
            outcome: dict[str, Any] = json.loads(self._files.cat_file(self.path("fits", key, _OUTCOME)))
        except FileNotFoundError:
            return None
        return outcome

    def publish(self, key: str, folder: pathlib.Path, outcome: dict[str, Any]) -> None:
        """Put the files of a folder into that of the key; what begins with a dot stays behind."""
        for directory, folders, names in os.walk(folder):
            folders[:] = [name for name in folders if not name.startswith(".")]
            below = pathlib.Path(directory).relative_to(folder).parts
            self._files.makedirs(self.path("fits", key, *below), exist_ok=True)
            for name in names:
                file = pathlib.Path(directory) / name
                self.put(self.path("fits", key, *below, name), file.read_bytes())
        self.put(self.path("fits", key, _OUTCOME), json.dumps(outcome).encode())

    def put(self, path: str, content: bytes) -> None:
        """Write a file that is there as a whole or not at all."""
        part = f"{path}.{uuid.uuid4().hex}.part"
        self._files.pipe_file(part, content)
        self._files.mv(part, path)

    def content(self, path: str) -> bytes:
        """The content of a file."""
        content: bytes = self._files.cat_file(path)
        return content

    def contents(self, paths: list[str]) -> dict[str, bytes]:
        """The content of those files that are there, read side by side where that is faster."""
        found: dict[str, bytes] = self._files.cat(paths, on_error="omit")
        return found

    def paths(self, folder: str, ending: str) -> list[str]:
        """The files of a folder below the root that end so, in order."""
        try:
            found = self._files.ls(self.path(folder), detail=False)
        except FileNotFoundError:
            return []
        return sorted(path for path in found if path.endswith(ending))

    def make(self, folder: str) -> None:
        """Empty a folder below the root, which is made where there is none."""
        if self._files.exists(self.path(folder)):
            self._files.rm(self.path(folder), recursive=True)
        self._files.makedirs(self.path(folder), exist_ok=True)

    def open(self, path: str) -> Any:
        """A file that is written piece by piece."""
        return self._files.open(path, "wb")

    def file(self, path: str) -> Any:
        """A file that is read piece by piece."""
        return self._files.open(path, "rb")

    def get(self, key: str, folder: pathlib.Path) -> None:
        """Copy the folder of a key."""
        _copy(self._files, self.path("fits", key), folder)


def local(recording: str, scratch: pathlib.Path) -> pathlib.Path:
    """The recording on this machine: where it is, or a copy of what an object store has."""
    if "://" not in recording:
        return pathlib.Path(recording)
    files, path = imported("fsspec.core", "study").url_to_fs(recording)
    copy = scratch / uuid.uuid4().hex / str(path).rstrip("/").rpartition("/")[2]
    copy.parent.mkdir()
    _copy(files, path, copy)
    return copy


def _copy(files: Any, path: str, folder: pathlib.Path) -> None:
    """Copy a folder of a file system, under another name; the slashes say that neither is a parent."""
    files.get(path.rstrip("/") + "/", f"{folder}/", recursive=True)
