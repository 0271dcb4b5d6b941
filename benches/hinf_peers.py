"""Plain H-infinity synthesis by squid-lpv and its peers, and the norm of a closed loop computed from its matrices."""

from __future__ import annotations

import json
import time
import warnings
from pathlib import Path

import control
import dkpy
import numpy as np
import slycot  # noqa: F401 - loaded here, so that it is not timed
import squid_lpv
from scipy.optimize import minimize_scalar


def read(path: Path) -> tuple[dict[str, np.ndarray], float]:
    """Return the matrices of a case and its published gamma."""
    case = json.loads(path.read_text(encoding="utf-8"))
    names = ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21")
    return {name: np.array(case["data"][name]) for name in names}, case["expected"]["gamma"]


def closed_norm(p: dict[str, np.ndarray], k: tuple[np.ndarray, ...]) -> float:
    """Return the H-infinity norm from w to z with the controller k = (A, B, C, D), infinite if it is unstable.

    A grid of frequencies around the moduli of the poles, each peak refined: a lower bound, tight for a smooth response.
    """
    ak, bk, ck, dk = k
    a = np.block([[p["A"] + p["B2"] @ dk @ p["C2"], p["B2"] @ ck], [bk @ p["C2"], ak]])
    b = np.vstack([p["B1"] + p["B2"] @ dk @ p["D21"], bk @ p["D21"]])
    c = np.hstack([p["C1"] + p["D12"] @ dk @ p["C2"], p["D12"] @ ck])
    d = p["D11"] + p["D12"] @ dk @ p["D21"]
    poles = np.linalg.eigvals(a)
    if poles.real.max() >= 0.0:
        return float("inf")
    identity = np.eye(len(a))

    def gain(log_omega: float) -> float:
        return np.linalg.norm(c @ np.linalg.solve(1j * 10.0**log_omega * identity - a, b) + d, 2)

    near = np.log10(np.abs(poles))
    spread = np.linspace(near.min() - 3, near.max() + 3, 400)
    grid = np.unique(np.concatenate([spread, *(near + shift for shift in np.linspace(-0.3, 0.3, 13))]))
    gains = np.array([gain(at) for at in grid])
    best = max(gains.max(), np.linalg.norm(d, 2), np.linalg.norm(d - c @ np.linalg.solve(a, b), 2))
    for i in np.argsort(gains)[-8:]:
        low, high = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
        found = minimize_scalar(lambda at: -gain(at), bounds=(low, high), method="bounded")
        best = max(best, -found.fun)
    return float(best)


def synthesise(method: str, plant: control.StateSpace, nmeas: int, ncon: int) -> tuple[object, dict[str, float]]:
    """Return the controller of a method, and its message."""
    if method == "squid":
        found = squid_lpv.hinfsyn_proved(plant, nmeas, ncon)
        return found.synthesis.K, {"gamma": found.synthesis.gam, "least": found.gamma}
    if method == "hinfsyn":
        k, _, gamma, _ = control.hinfsyn(plant, nmeas, ncon)
    else:
        k, _, gamma, _ = getattr(dkpy, method)().synthesize(plant, nmeas, ncon)
    return k, {"gamma": float(np.squeeze(gamma))}


def run(method: str, p: dict[str, np.ndarray]) -> dict[str, float | str]:
    """Time one synthesis; return its gamma and the norm of its loop, or the reason of the failure."""
    zero = np.zeros((len(p["C2"]), p["B2"].shape[1]))
    d = np.block([[p["D11"], p["D12"]], [p["D21"], zero]])
    plant = control.ss(p["A"], np.hstack([p["B1"], p["B2"]]), np.vstack([p["C1"], p["C2"]]), d)
    begin = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            k, said = synthesise(method, plant, len(p["C2"]), p["B2"].shape[1])
    except Exception as error:  # Any exception is a finding.
        return {"seconds": time.perf_counter() - begin, "failure": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - begin
    if k is None:
        return {"seconds": seconds, "failure": "returns no controller"}
    return {"seconds": seconds, **said, "norm": closed_norm(p, (k.A, k.B, k.C, k.D))}
