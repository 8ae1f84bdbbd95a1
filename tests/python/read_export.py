"""Reads what `phalanx export` wrote with NumPy, SciPy, PyArrow and the csv module, and compares all four value by value.

    read_export.py STEM      (STEM.npz, STEM.mat and the folders STEM-csv, STEM-parquet)

Prints scenario, variant and the number of samples; exit code 1 if two of them differ.
"""

import csv
import sys
from pathlib import Path

import numpy
import pyarrow.parquet
import scipy.io


def main(stem):
    archive = numpy.load(f"{stem}.npz")
    matlab = scipy.io.loadmat(f"{stem}.mat")
    for name in archive.files:
        # MATLAB knows nothing but matrices.
        expected = archive[name].reshape(len(archive[name]), -1)
        if not numpy.array_equal(matlab[name], expected):
            sys.exit(f"{name}: MATLAB's file and NumPy's differ")
    for table in sorted(Path(f"{stem}-csv").iterdir()):
        with open(table, newline="") as stream:
            rows = list(csv.reader(stream))
        values = numpy.array(rows[1:], dtype=float)
        parquet = pyarrow.parquet.read_table(f"{stem}-parquet/{table.stem}.parquet")
        if parquet.column_names != rows[0]:
            sys.exit(f"{table.stem}: the table and Parquet's file have other columns")
        if not numpy.array_equal(numpy.column_stack([column.to_numpy() for column in parquet.columns]), values):
            sys.exit(f"{table.stem}: the table and Parquet's file differ")
        if parquet.schema.metadata[b"scenario"].decode() != matlab["scenario"][0]:
            sys.exit(f"{table.stem}: Parquet's file is not of the scenario")
        columns = ["t", "step"] + [f"{table.stem}_{name.split('[')[0]}" for name in rows[0][2:]]
        for name in dict.fromkeys(columns):
            chosen = values[:, [column == name for column in columns]]
            if not numpy.array_equal(chosen, archive[name].reshape(len(chosen), -1)):
                sys.exit(f"{name}: the table and NumPy's file differ")
    print(matlab["scenario"][0], matlab["variant"][0], len(archive["t"]), "samples,", len(archive.files), "arrays agree")


main(sys.argv[1])
