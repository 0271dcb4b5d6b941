"""Upper bounds on mu: `lpv` against SLICOT's AB13MD and dkpy, a matrix at a time, and the sweep over all frequencies."""

from __future__ import annotations

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import dkpy
import numpy as np
import slycot

ROUNDS = 5
CALLS = 41
# Name, blocks in the usual notation, how often dkpy is asked: 0 where it does not know the blocks.
STRUCTURES = (
    ("AB13MD's example: 2 real, full 2 x 2, 2 complex", [[-1, 0], [-1, 0], [2, 2], [1, 1], [1, 1]], 0),
    ("4 complex", [[1, 1]] * 4, 1),
    ("10 complex", [[1, 1]] * 10, 1),
    ("10 real", [[-1, 0]] * 10, 0),
)


def matrix(blocks: list[list[int]], example: Path) -> np.ndarray:
    """Return the matrix of AB13MD's example, and a random one for other blocks."""
    if [2, 2] in blocks:
        return np.array(json.loads(example.read_text(encoding="utf-8"))["data"]["M"]) @ np.array([1.0, 1j])
    n, random = len(blocks), np.random.default_rng(len(blocks))
    return random.normal(size=(n, n)) + 1j * random.normal(size=(n, n))


def ours(program: Path, m: np.ndarray, blocks: list[list[int]]) -> dict:
    """Time `upper_bound` in its process: the median of many calls."""
    rows = [[[v.real, v.imag] for v in row] for row in m]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "m.json"
        path.write_text(json.dumps({"data": {"M": rows, "blocks": blocks}}), encoding="utf-8")
        done = subprocess.run([program, path, str(CALLS)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def slicot(m: np.ndarray, blocks: list[list[int]]) -> tuple[float, float]:
    """Return the median seconds of AB13MD and its bound."""
    sizes = np.array([max(1, q) for _, q in blocks])
    types = np.array([1 if p < 0 else 2 for p, _ in blocks])
    seconds = []
    for _ in range(CALLS):
        begin = time.perf_counter()
        bound = slycot.ab13md(m, sizes, types)[0]
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds), bound


def by_dkpy(m: np.ndarray, blocks: list[list[int]]) -> tuple[float, float]:
    """Return the seconds of dkpy's bisection and its bound."""
    structure = [dkpy.ComplexFullBlock(p, q) for p, q in blocks]
    begin = time.perf_counter()
    found = dkpy.SsvLmiBisection(n_jobs=None).compute_ssv(m[:, :, None], structure)[0]
    return time.perf_counter() - begin, float(np.max(found))


def rows(program: Path, example: Path) -> list[str]:
    """Return the table."""
    table = ["| blocks | lpv | AB13MD | AB13MD / lpv | dkpy | dkpy / lpv |", "|---" * 6 + "|"]
    for name, blocks, asked in STRUCTURES:
        m = matrix(blocks, example)
        mine, theirs, third = [], [], []
        for _ in range(ROUNDS):
            mine.append(ours(program, m, blocks))
            theirs.append(slicot(m, blocks))
            third += [by_dkpy(m, blocks) for _ in range(asked)]
        own = [found["seconds"] for found in mine]
        ratio = statistics.median(t / o for (t, _), o in zip(theirs, own, strict=True))
        cells = [name, cell(statistics.median(own), mine[0]["upper"])]
        cells += [cell(statistics.median(t for t, _ in theirs), theirs[0][1]), f"{ratio:.2f}"]
        if third:
            far = statistics.median(t / o for (t, _), o in zip(third, own, strict=True))
            cells += [cell(statistics.median(t for t, _ in third), third[0][1]), f"{far:.0f}"]
        else:
            cells += ["knows no real blocks", ""]
        table.append("| " + " | ".join(cells) + " |")
    return table


def cell(seconds: float, bound: float) -> str:
    """Return a bound with its time."""
    return f"{bound:.7g}; {1e3 * seconds:.3g} ms"
