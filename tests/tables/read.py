#!/usr/bin/env python3
"""Opens the tables that the example `tables` writes by pandas and polars, and compares them with x = cos(omega t).

    pip install pandas pyarrow polars
    cargo run -p lagrange-runtime --features parquet --example tables -- FOLDER
    python3 tests/tables/read.py FOLDER
"""

import math
import pathlib
import sys

import pandas
import polars

COLUMNS = ["index", "omega", "x", "first_zero"]
ROWS = 5000


def rows(frame):
    """Rows as tuples, what is missing as None."""
    missing = lambda value: value is None or isinstance(value, float) and math.isnan(value)
    return [tuple(None if missing(value) else value for value in row) for row in frame]


def main():
    folder = pathlib.Path(sys.argv[1])
    parquet, csv = folder / "oscillators.parquet", folder / "oscillators.csv"
    tables = {
        "pandas, Parquet": pandas.read_parquet(parquet),
        "pandas, CSV": pandas.read_csv(csv),
        "polars, Parquet": polars.read_parquet(parquet),
        "polars, CSV": polars.read_csv(csv),
    }
    first = None
    for name, table in tables.items():
        assert list(table.columns) == COLUMNS, (name, table.columns)
        found = rows(table.itertuples(index=False) if isinstance(table, pandas.DataFrame) else table.iter_rows())
        assert len(found) == ROWS, (name, len(found))
        first = first or found
        assert found == first, f"{name} differs from the first table"
        for place, (index, omega, x, zero) in enumerate(found):
            assert index == place
            assert abs(x - math.cos(omega)) < 1e-10, (name, index)
            quarter = math.pi / (2 * omega)
            assert (zero is None) == (quarter > 1), (name, index)
            assert zero is None or abs(zero - quarter) < 1e-8, (name, index)
        print(f"{name}: {len(found)} rows, the same numbers to the last bit, as in closed form")


main()
