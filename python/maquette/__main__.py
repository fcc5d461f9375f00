"""The command ``maquette``."""

from __future__ import annotations

import sys

from . import _maquette


def main() -> int:
    """Run the program with the words of the command line, and give its exit code."""
    if sys.argv[1:2] == ["study"]:
        from .study._command import main as study

        return study(sys.argv[2:])
    return _maquette.main(["maquette", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
