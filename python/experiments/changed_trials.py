"""Some trials of a study change: whether these are computed again, and no other."""

from __future__ import annotations

import argparse
import pathlib
import random
import tempfile

from cohort import written

from maquette import study


def main() -> None:
    """Run, change one mask of each of some trials, and run again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--changed", type=int, default=10)
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        cohort = written(pathlib.Path(scratch), words.trials)
        print("at first:", study.run(cohort))
        print("once more:", study.run(cohort))
        for task in random.Random(1).sample(list(cohort.tasks()), words.changed):
            masks = sorted(pathlib.Path(task.trials[0][1], "masks", "cam_01").glob("*.png"))
            # the second frame shows what the third does
            masks[1].write_bytes(masks[2].read_bytes())
        print(f"{words.changed} changed:", study.run(cohort))


if __name__ == "__main__":
    main()
