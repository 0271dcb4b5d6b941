"""Upper bounds on mu of matrices, `lpv` against SLICOT's AB13MD and dkpy, and over all frequencies."""

from __future__ import annotations

import json
import os
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
# Name, blocks in the usual notation, number of calls of dkpy: 0 if it does not support the blocks.
STRUCTURES = (
    ("AB13MD's example: 2 real, full 2 x 2, 2 complex", [[-1, 0], [-1, 0], [2, 2], [1, 1], [1, 1]], 0),
    ("4 complex", [[1, 1]] * 4, 1),
    ("10 complex", [[1, 1]] * 10, 1),
    ("10 real", [[-1, 0]] * 10, 0),
    ("20 real", [[-1, 0]] * 20, 0),
)
# Aircraft of the last rows: its coefficients, and the frequency (rad/s) of the largest bound.
AIRCRAFT = "14 real: transport aircraft at 0.664 rad/s, the peak"
PEAK = 0.66409
SWEEPS = 2


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


def aircraft(case: Path) -> tuple[str, list[list[int]], int, np.ndarray]:
    """Return the row of the transport aircraft, with its response at the frequency of the peak."""
    data = json.loads(case.read_text(encoding="utf-8"))["data"]
    a, b, c, d = (np.array(data["P"][key]) for key in "ABCD")
    return AIRCRAFT, data["blocks"], 0, d + c @ np.linalg.solve(1j * PEAK * np.eye(len(a)) - a, b)


def rows(program: Path, cases: Path) -> list[str]:
    """Return the table of the bounds at one frequency."""
    table = ["| blocks | lpv | AB13MD | AB13MD / lpv | dkpy | dkpy / lpv |", "|---" * 6 + "|"]
    example = cases / "mu01_slicot_ab13md.json"
    problems = [(*structure, matrix(structure[1], example)) for structure in STRUCTURES]
    for name, blocks, asked, m in [*problems, aircraft(cases / "mu13_transport_aircraft.json")]:
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
            cells += ["no real blocks", ""]
        table.append("| " + " | ".join(cells) + " |")
    return table


def cell(seconds: float, bound: float) -> str:
    """Return a bound with its time."""
    return f"{bound:.7g}; {1e3 * seconds:.3g} ms"


def sweep_rows(program: Path, problems: list[Path]) -> list[str]:
    """Return the table of sweeps over all frequencies, with their perturbations and the processor time of one."""
    table = ["| speed, m/s | real scalars, repeated | states | s | mu <= | mu >= | intervals |", "|---" * 7 + "|"]
    for path in problems:
        file = json.loads(path.read_text(encoding="utf-8"))
        before = os.times()
        done = subprocess.run([program, path, str(SWEEPS)], capture_output=True, text=True, check=True)
        seconds = (os.times().children_user - before.children_user) / (SWEEPS + 1)  # Plus one warm-up sweep.
        found = json.loads(done.stdout)
        blocks = [-r for r, _ in file["data"]["blocks"]]
        cells = [path.stem, f"{len(blocks)}, in all {sum(blocks)}", str(len(file["data"]["P"]["A"]))]
        cells += [f"{seconds:.2f}", f"{found['upper']:.3f}", f"{found['lower']:.3f}", str(found["intervals"])]
        table.append("| " + " | ".join(cells) + " |")
    return table
