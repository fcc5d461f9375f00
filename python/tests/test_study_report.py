"""Who is odd among the trials of a study."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

import pytest

from maquette.study import _numbers

if TYPE_CHECKING:
    import pandas as pd

pytest.importorskip("pandas")


def _values(values: list[float]) -> pd.DataFrame:
    rows = [
        {"group": "length", "quantity": "thigh", "trial": f"t{at}", "value": value} for at, value in enumerate(values)
    ]
    table: pd.DataFrame = import_module("pandas").DataFrame(rows)
    return table


def test_a_value_far_from_the_others_is_odd() -> None:
    """By the median and the median deviation: 0.6745 (60 - 44.5) / 2.5 = 4.18."""
    odd = _numbers.odd(_values([40, 41, 42, 43, 44, 45, 46, 47, 48, 60]))
    assert list(odd["trial"]) == ["t9"]
    assert odd["z"].iloc[0] == pytest.approx(0.6745 * 15.5 / 2.5)


def test_few_values_do_not_say_what_is_usual() -> None:
    """Nine are not enough."""
    assert _numbers.odd(_values([40, 41, 42, 43, 44, 45, 46, 47, 60])).empty


def test_values_that_are_all_the_same_make_nobody_odd() -> None:
    """There is no deviation to compare with."""
    assert _numbers.odd(_values([40.0] * 11 + [60.0])).empty
