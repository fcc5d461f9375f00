"""Files that are written: a temporary folder that lives as long as a result, and pages."""

from __future__ import annotations

import os
import pathlib
import shutil
import tempfile
import weakref


class Scratch:
    """A folder that is removed with this object, or at the end of the interpreter, by the process that made it."""

    def __init__(self) -> None:
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="maquette-"))
        self._removal = weakref.finalize(self, _remove, self.path, os.getpid())


def written_page(path: str | os.PathLike[str], page: str) -> pathlib.Path:
    """Write a page of HTML with the program's ends of lines."""
    pathlib.Path(path).write_text(page, encoding="utf-8", newline="\n")
    return pathlib.Path(path)


def copied(written: str | os.PathLike[str], path: pathlib.Path) -> pathlib.Path:
    """Copy a file, or all that a folder holds, to where it is wanted."""
    if pathlib.Path(written).is_dir():
        shutil.copytree(written, path, dirs_exist_ok=True)
    else:
        shutil.copyfile(written, path)
    return path


def _remove(path: pathlib.Path, owner: int) -> None:
    # a forked process has a copy of the object and not of the folder
    if os.getpid() == owner:
        shutil.rmtree(path, ignore_errors=True)
