"""Records of simulations as FMPy writes them, and the differences between two."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from fly.master import References, Signals

LOGICAL = {"True": 1.0, "False": 0.0}


def read(path: Path) -> Signals:
    """Read a CSV file with a header line into a column for each name."""
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    columns = zip(*rows, strict=True)
    values = ([LOGICAL[cell] if cell in LOGICAL else float(cell) for cell in column] for column in columns)
    return {name: np.array(column) for name, column in zip(names, values, strict=True)}


def references_in(loop: Signals) -> References:
    """Return the references of a closed-loop simulation; those used at a sample are in the row after it."""
    used = {
        name.removesuffix("_used"): values
        for name, values in loop.items()
        if name.endswith("_reference_used")
    }
    return lambda k, _: {name: float(values[k + 1]) for name, values in used.items()}


def differences(one: Signals, other: Signals) -> dict[str, float]:
    """Return the largest difference of each shared signal, relative to the larger of 1 and its largest value."""
    shared = [name for name in one if name in other and name != "time"]
    return {name: _difference(one[name], other[name]) for name in shared}


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    scale = max(1.0, float(np.max(np.abs(one))))
    return float(np.max(np.abs(one - other))) / scale
