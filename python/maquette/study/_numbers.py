"""What a study's page says in numbers: one value of each quantity for each trial, and which of them are odd."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._optional import imported
from ._store import Store

if TYPE_CHECKING:
    import pandas as pd

#: A value is odd whose modified z is beyond this.
ODD_Z = 3.5
#: So many values at least say what is usual.
_ENOUGH = 10


def table(store: Store, name: str) -> pd.DataFrame:
    """A table of the dataset."""
    pandas = imported("pandas", "study")
    files: list[pd.DataFrame] = [
        pandas.read_parquet(store.file(path)) for path in store.paths(f"dataset/{name}", ".parquet")
    ]
    whole: pd.DataFrame = pandas.concat(files, ignore_index=True)
    return whole


def quantities(store: Store) -> pd.DataFrame:
    """One value of each quantity for each trial, in long form.

    Returns
    -------
    pandas.DataFrame
        ``group``, ``quantity``, ``unit``, ``trial``, ``value``, and ``u``: the standard uncertainty of the value that
        the fit states, not a number where there is none. Of a parameter of several strides it is their mean, and u that
        of a single one, for what is wrong with the fit is the same in all.
    """
    pandas = imported("pandas", "study")
    lengths = table(store, "lengths")
    lengths = lengths.assign(group="length", quantity=lengths["name"], unit="m", value=lengths["length_m"])
    lengths = lengths.rename(columns={"sd_m": "u"})

    strides = table(store, "strides")
    by = ["trial", "name", "side", "unit"]
    strides = strides.groupby(by, as_index=False).agg(value=("value", "mean"), u=("uncertainty", "mean"))
    strides = strides.assign(group="step or stride", quantity=strides["name"] + " " + strides["side"])

    trials = table(store, "trials")
    overlap = trials[["trial"]].assign(group="fit", quantity="overlap", unit="", value=trials["overlap"])
    gps = trials[["trial"]].assign(group="score", quantity="gps", unit="deg", value=trials["gps_deg"])

    columns = ["group", "quantity", "unit", "trial", "value", "u"]
    parts = [part.reindex(columns=columns) for part in (lengths, strides, gps, overlap)]
    whole: pd.DataFrame = pandas.concat([part for part in parts if part["value"].notna().any()], ignore_index=True)
    return whole.dropna(subset="value")


def odd(values: pd.DataFrame) -> pd.DataFrame:
    """Values that are far from those of the others: ``z`` beyond :data:`ODD_Z`, the farthest first.

    Modified z, 0.6745 (x - median) / MAD, of quantities with ten values or more.

    Notes
    -----
    Iglewicz & Hoaglin 1993, *How to Detect and Handle Outliers*, ASQC Quality Press, p. 11: 3.5 is theirs.
    """
    groups = values.groupby(["group", "quantity"])["value"]
    median = groups.transform("median")
    deviation = (values["value"] - median).abs()
    mad = deviation.groupby([values["group"], values["quantity"]]).transform("median")
    z = 0.6745 * (values["value"] - median) / mad.where(mad > 0)
    found = values.assign(median=median, z=z)[groups.transform("size") >= _ENOUGH]
    found = found[found["z"].abs() > ODD_Z]
    return found.sort_values("z", key=abs, ascending=False, ignore_index=True)
