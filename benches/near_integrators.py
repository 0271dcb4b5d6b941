"""Random near-integrator plants: gamma of `squid lpv synth` against SLICOT's SB10AD and the norms of closed loops.

near_integrators.py SQUID [COUNT]   needs slycot 0.7.1, scipy and mpmath

Four kinds in turn, with seeds 0, 1, ...: poles and zeros in series, from disturbance and noise to output and control,
without and with slow zeros; multivariable systems, half of them in a random orthogonal basis; mixed sensitivity with a
near-integrator as weight.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import mpmath as mp
import numpy as np
import slycot
from scipy.optimize import minimize_scalar
from scipy.signal import zpk2ss

Plant = dict[str, np.ndarray]


def slow(rng: np.random.Generator) -> float:
    """Return a rate from 1e-7 to 1e-5 rad/s."""
    return 10.0 ** rng.uniform(-7, -5)


def moderate(rng: np.random.Generator, stable: float) -> float:
    """Return a real pole or zero of order 1, in the left half-plane with this probability."""
    return -rng.uniform(0.3, 3) * (1 if rng.random() < stable else -1)


def four_block(rng: np.random.Generator, modes: int, slow_zeros: bool) -> Plant:
    """Return w = (disturbance at the input, noise), z = (output, control) of poles and zeros in series."""
    count = int(rng.integers(1, 3))
    poles: list[complex] = []
    while len(poles) < modes:
        if modes - len(poles) >= 2 and rng.random() < 0.4:
            w, d = rng.uniform(0.3, 3), rng.uniform(0.05, 0.9)
            poles += [complex(-d * w, sign * w * np.sqrt(1 - d * d)) for sign in (1, -1)]
        else:
            poles.append(moderate(rng, 0.8))
    number = int(rng.integers(0, modes))
    zeros = [moderate(rng, 0.85) for _ in range(number)]
    for _ in range(count):
        poles.append(-slow(rng))
        if slow_zeros and rng.random() < 0.8:
            zeros.append(-slow(rng))
    a, b, c, _ = zpk2ss(zeros, poles, rng.uniform(0.3, 3))
    n = len(a)
    b1, c1 = np.hstack([b, np.zeros((n, 1))]), np.vstack([c, np.zeros((1, n))])
    d12, d21 = np.array([[0.0], [1.0]]), np.array([[0.0, 1.0]])
    return {"A": a, "B1": b1, "B2": b, "C1": c1, "C2": c, "D11": np.zeros((2, 2)), "D12": d12, "D21": d21}


def several(rng: np.random.Generator, modes: int) -> Plant:
    """Return a system of one or two controls, measurements, disturbances and outputs, all weights and noises 1."""
    nu, ny = int(rng.integers(1, 3)), int(rng.integers(1, 3))
    nw, nz = int(rng.integers(1, 3)), int(rng.integers(1, 3))
    count, blocks, k = int(rng.integers(1, 3)), [], 0
    while k < modes:
        if modes - k >= 2 and rng.random() < 0.5:
            w, d = rng.uniform(0.3, 3), rng.uniform(-0.2, 0.9)
            turn = w * np.sqrt(1 - d * d)
            blocks.append(np.array([[-d * w, turn], [-turn, -d * w]]))
            k += 2
        else:
            blocks.append(np.array([[moderate(rng, 0.8)]]))
            k += 1
    blocks += [np.array([[-slow(rng)]]) for _ in range(count)]
    n = sum(len(b) for b in blocks)
    a, i = np.zeros((n, n)), 0
    for b in blocks:
        a[i : i + len(b), i : i + len(b)] = b
        i += len(b)
    if rng.random() < 0.5:
        q, _ = np.linalg.qr(rng.normal(size=(n, n)))
        a = q @ a @ q.T
    b1, b2 = np.hstack([rng.normal(size=(n, nw)), np.zeros((n, ny))]), rng.normal(size=(n, nu))
    c1, c2 = np.vstack([rng.normal(size=(nz, n)), np.zeros((nu, n))]), rng.normal(size=(ny, n))
    d12 = np.vstack([np.zeros((nz, nu)), np.eye(nu)])
    d21 = np.hstack([np.zeros((ny, nw)), np.eye(ny)])
    d11 = np.zeros((nz + nu, nw + ny))
    return {"A": a, "B1": b1, "B2": b2, "C1": c1, "C2": c2, "D11": d11, "D12": d12, "D21": d21}


def weighted(rng: np.random.Generator, modes: int) -> Plant:
    """Return S weighted by a near-integrator and KS by 1, for a reference and a disturbance at the input."""
    poles = [-rng.uniform(0.3, 3) for _ in range(modes)]
    number = int(rng.integers(0, modes))
    zeros = [moderate(rng, 0.85) for _ in range(number)]
    ag, bg, cg, _ = zpk2ss(zeros, poles, rng.uniform(0.3, 3))
    p, m, wb = slow(rng), rng.uniform(1.2, 3), rng.uniform(0.05, 1)
    n = modes + 1
    a, b1, b2 = np.zeros((n, n)), np.zeros((n, 2)), np.zeros((n, 1))
    c1, c2 = np.zeros((2, n)), np.zeros((1, n))
    a[:modes, :modes], a[modes, :modes], a[modes, modes] = ag, -cg[0], -p
    b1[modes, 0], b1[:modes, 1], b2[:modes, 0] = 1.0, bg[:, 0], bg[:, 0]
    c1[0, :modes], c1[0, modes], c2[0, :modes] = -cg[0] / m, wb - p / m, -cg[0]
    d11, d12, d21 = np.array([[1 / m, 0.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    return {"A": a, "B1": b1, "B2": b2, "C1": c1, "C2": c2, "D11": d11, "D12": d12, "D21": d21}


def plant(seed: int) -> Plant:
    """Return the plant of a seed."""
    rng = np.random.default_rng(seed)
    modes = int(rng.integers(1, 5))
    kind = seed % 4
    if kind < 2:
        return four_block(rng, modes, kind == 1)
    return several(rng, modes) if kind == 2 else weighted(rng, modes)


def sb10ad(p: Plant, start: float) -> dict:
    """Run SLICOT in its own process, because it may hang; return gamma and its controller, or None."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(10)
        zero = np.zeros((len(p["C2"]), p["B2"].shape[1]))
        b, c = np.hstack([p["B1"], p["B2"]]), np.vstack([p["C1"], p["C2"]])
        d = np.block([[p["D11"], p["D12"]], [p["D21"], zero]])
        sizes = (len(p["A"]), b.shape[1], len(c), p["B2"].shape[1], len(p["C2"]))
        try:
            found = slycot.sb10ad(*sizes, start, A=p["A"], B=b, C=c, D=d, job=1, gtol=1e-7)
            answer = {"gamma": float(found[0]), "k": [np.array(m).tolist() for m in found[1:5]]}
        except Exception:
            answer = {}
        os.write(write, json.dumps(answer).encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return json.loads(text) if text else {}


def exact_loop(p: Plant, k: list[np.ndarray]) -> list[mp.matrix]:
    """Return the closed loop in 40 digits: in f64 the fast modes near the optimum hide the slow ones."""
    mp.mp.dps = 40

    def exact(m: np.ndarray) -> mp.matrix:
        return mp.matrix(np.real(m).tolist())

    ak, bk, ck, dk = (exact(m) for m in k)
    n, nk = len(p["A"]), ak.rows
    a = mp.matrix(n + nk)
    a[:n, :n] = exact(p["A"]) + exact(p["B2"]) * dk * exact(p["C2"])
    a[:n, n:] = exact(p["B2"]) * ck
    a[n:, :n] = bk * exact(p["C2"])
    a[n:, n:] = ak
    b, c = mp.matrix(n + nk, p["B1"].shape[1]), mp.matrix(len(p["C1"]), n + nk)
    b[:n, :] = exact(p["B1"]) + exact(p["B2"]) * dk * exact(p["D21"])
    b[n:, :] = bk * exact(p["D21"])
    c[:, :n] = exact(p["C1"]) + exact(p["D12"]) * dk * exact(p["C2"])
    c[:, n:] = exact(p["D12"]) * ck
    return [a, b, c, exact(p["D11"]) + exact(p["D12"]) * dk * exact(p["D21"])]


def gain(loop: list[mp.matrix], omega: float) -> float:
    """Return the largest singular value at a frequency."""
    a, b, c, d = loop
    system = mp.mpc(0, omega) * mp.eye(a.rows) - a
    columns = [mp.lu_solve(system, b[:, j]) for j in range(b.cols)]
    state = mp.matrix([[column[i] for column in columns] for i in range(a.rows)])
    return float(np.linalg.norm(np.array((c * state + d).tolist(), dtype=complex), 2))


def loop_norm(p: Plant, k: list[np.ndarray], points: int = 400) -> float:
    """Return the largest gain of the loop over frequency, its peak refined; infinite if it is unstable."""
    loop = exact_loop(p, k)
    poles = [complex(v) for v in mp.eig(loop[0], left=False, right=False)]
    if max(v.real for v in poles) >= 0:
        return float("inf")
    near = np.log10(np.abs(poles))
    grid = np.unique(np.concatenate([np.linspace(near.min() - 3, near.max() + 2, points), near]))
    gains = [gain(loop, 10.0 ** float(x)) for x in grid]
    i = int(np.argmax(gains))
    ends = (grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)])
    peak = minimize_scalar(
        lambda x: -gain(loop, 10.0 ** float(x)), bounds=ends, method="bounded", options={"maxiter": 12}
    )
    return max([*gains, gain(loop, 0.0), -float(peak.fun)])


def main(command: str, count: int) -> None:
    """Print disagreements and totals."""
    proved = compared = off = above = 0
    for seed in range(count):
        p = plant(seed)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "p.json"
            data = {name: np.real(m).tolist() for name, m in p.items()}
            path.write_text(json.dumps({"kind": "hinfsyn", "data": data}), encoding="utf-8")
            words = [command, "lpv", "synth", str(path), "--json", "--out", folder]
            ours = json.loads(subprocess.run(words, capture_output=True, text=True, check=False).stdout)
            own = Path(folder) / "controller.json"
            k = json.loads(own.read_text(encoding="utf-8")) if own.exists() else None
        gamma, lower = ours["gamma"] or float("inf"), ours["gamma_lower"]
        norms = []
        if k is not None:
            norms.append(loop_norm(p, [np.array(k[name], dtype=float) for name in ("A", "By", "Cu", "Duy")]))
        theirs = min((sb10ad(p, s * min(gamma, 1e6)) for s in (3, 100)), key=lambda r: r.get("gamma", np.inf))
        if "gamma" in theirs:
            norms.append(loop_norm(p, [np.array(m) for m in theirs["k"]]))
        proved += lower is not None
        if lower is not None and lower > min(norms, default=float("inf")):
            above += 1
            print(f"seed {seed}: lower bound {lower:.8g} above the norm {min(norms):.8g} of a loop")
        # SLICOT has solved a plant if the norm of the loop is the gamma returned.
        if "gamma" in theirs and norms[-1] <= theirs["gamma"] * (1 + 1e-3):
            compared += 1
            if gamma > theirs["gamma"] * (1 + 1e-3):
                off += 1
                print(
                    f"seed {seed}: gamma {gamma:.8g}, SLICOT {theirs['gamma']:.8g}, its loop {norms[-1]:.8g}"
                )
    print(f"{count} plants, {compared} solved by SLICOT: {off} gammas more than 1e-3 above its own")
    print(f"{proved} lower bounds proved, {above} of them above the norm of a loop")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 300)
