"""The rows of all tasks as one dataset: ``dataset/<table>/part-*.parquet``, for DuckDB, Polars, pandas and R."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._optional import imported
from . import _rows
from ._run import outcomes
from ._store import Store
from ._study import Study
from ._task import Outcome

if TYPE_CHECKING:
    import pandas as pd

#: Of pyarrow, which states no types.
Table = Any
Schema = Any

#: Folder of the dataset, below the results.
DATASET = "dataset"
#: Rows that are written at once, and rows after which another file begins: some 10 to 50 MB.
_GROUP, _FILE = 100_000, 1_000_000
#: So many tables that wait are joined.
_TABLES = 1000


def gather(study: Study) -> str:
    """Write the dataset of a study's last run.

    Rows are read fit by fit, in the order of the study, so that memory hardly grows with their number.

    Parameters
    ----------
    study
        What :func:`read` has read.

    Returns
    -------
    str
        Its folder or address. It has a folder of Parquet files for each table: ``trials``, a row for each trial, also
        for those that failed, with what the study's own table says of it; ``lengths``, ``strides``, ``curves`` and
        ``scores``. docs/scale.md of the repository has the columns.
    """
    store = Store(study.results)
    store.make(DATASET)
    trials = _Trials(study)
    schemas = {table: _rows.schema(table) for table in _rows.TABLES} | {"trials": trials.schema}
    writers = {table: _Writer(store, table, schema) for table, schema in schemas.items()}
    ended = {outcome.name: outcome for outcome in outcomes(study)}
    for name in study.names:
        outcome = ended.get(name, Outcome(name, "lost", "not run"))
        rows = _rows_of(store, outcome, study)
        writers["trials"].add(trials.of(outcome, rows.pop("trials", None)))
        for table, found in rows.items():
            writers[table].add(found)
    for writer in writers.values():
        writer.close()
    return store.path(DATASET)


def _rows_of(store: Store, outcome: Outcome, study: Study) -> dict[str, Table]:
    """The rows of a fit by table."""
    if outcome.key is None:
        return {}
    parquet, pyarrow = imported("pyarrow.parquet", "study"), imported("pyarrow", "study")
    paths = {store.path("fits", outcome.key, "rows", f"{table}.parquet"): table for table in _rows.TABLES}
    found: dict[str, Table] = {}
    for path, content in store.contents(list(paths)).items():
        rows = parquet.read_table(pyarrow.BufferReader(content))
        if study.unit == "trial":
            # two trials of one content share a fit, which has the name of the first
            rows = rows.set_column(0, "trial", pyarrow.repeat(outcome.name, len(rows)))
        found[paths[path]] = rows
    return found


class _Trials:
    """The table of trials: what the study says of each, and what became of it."""

    def __init__(self, study: Study) -> None:
        pyarrow = imported("pyarrow", "study")
        described = study.described
        columns = pyarrow.Schema.from_pandas(described, preserve_index=False)
        self._columns = list(columns.names)
        self._described = described
        self._unit = study.unit
        text, of_task = pyarrow.field("trial", pyarrow.string()), _rows.schema_of(_rows.OF_TASK)
        own = [columns.field(column) for column in self._columns]
        self.schema = pyarrow.schema([text, *own, *list(_rows.schema("trials"))[1:], *of_task])

    def of(self, outcome: Outcome, rows: Table | None) -> Table:
        """A row for each trial of a task: also of one that has no fit."""
        fitted = {row["trial"]: row for row in rows.to_pylist()} if rows is not None else {}
        task = {"key": outcome.key, "wall_s": outcome.wall_s, "cpu_s": outcome.cpu_s}
        without = {"status": "unusable" if fitted else outcome.status, "reason": outcome.reason}
        names = [outcome.name]
        if self._unit == "session":
            names = list(self._described.index[self._described["session"] == outcome.name])
        return self._table([fitted.get(name, without) | task | {"trial": name} for name in names])

    def _table(self, rows: list[dict[str, Any]]) -> Table:
        own: pd.DataFrame = self._described.loc[[row["trial"] for row in rows], self._columns]
        merged = [mine | row for mine, row in zip(own.to_dict("records"), rows, strict=True)]
        pyarrow = imported("pyarrow", "study")
        table: Table = pyarrow.Table.from_pylist(merged, schema=self.schema)
        return table


class _Writer:
    """The Parquet files of one table."""

    def __init__(self, store: Store, table: str, schema: Schema) -> None:
        self._store, self._table, self._schema = store, table, schema
        self._waiting: list[Table] = []
        self._rows = self._of_file = self._files = 0
        self._file: Any = None
        self._writer: Any = None
        store.make(f"{DATASET}/{table}")

    def add(self, rows: Table) -> None:
        """Add rows, which are written once they are many."""
        self._waiting.append(rows.select(self._schema.names))
        self._rows += len(rows)
        if self._rows >= _GROUP:
            self._write()
        elif len(self._waiting) >= _TABLES:
            # a table of few rows takes much more memory than its rows
            self._waiting = [self._joined()]

    def close(self) -> None:
        """Write what waits, and a file without rows where there are none."""
        if self._rows or not self._files:
            self._write()
        self._end()

    def _write(self) -> None:
        if self._writer is None:
            parquet = imported("pyarrow.parquet", "study")
            path = self._store.path(DATASET, self._table, f"part-{self._files:05}.parquet")
            self._file = self._store.open(path)
            self._writer = parquet.ParquetWriter(self._file, self._schema, compression="zstd")
            self._files += 1
        self._writer.write_table(self._joined())
        self._of_file += self._rows
        self._waiting, self._rows = [], 0
        if self._of_file >= _FILE:
            self._end()

    def _joined(self) -> Table:
        """All that waits as one table."""
        concat = imported("pyarrow", "study").concat_tables
        return concat([self._schema.empty_table(), *self._waiting]).combine_chunks()

    def _end(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._file.close()
            self._writer, self._of_file = None, 0
