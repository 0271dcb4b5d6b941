"""Matrices of decimals, and the closed loop of a certificate in them, shared by the independent checks."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

import numpy as np

DIGITS = 120


def exact(rows: list[list[float]], columns: int | None = None) -> np.ndarray:
    """Return a matrix of decimals, which represent every float exactly."""
    width = len(rows[0]) if rows and columns is None else columns or 0
    out = np.full((len(rows), width), Decimal(0), dtype=object)
    for i, row in enumerate(rows):
        out[i, :] = [Decimal(value) for value in row]
    return out


def zeros(rows: int, columns: int) -> np.ndarray:
    """Return a matrix of zeros."""
    return np.full((rows, columns), Decimal(0), dtype=object)


def is_positive(m: np.ndarray) -> bool:
    """Return True if a symmetric matrix is positive definite, by Cholesky's elimination."""
    a = m.copy()
    for k in range(len(a)):
        if a[k, k] <= 0:
            return False
        factors = a[k + 1 :, k] / a[k, k]
        a[k + 1 :, k + 1 :] -= np.outer(factors, a[k, k + 1 :])
    return True


class Ball(NamedTuple):
    """A model error: E of its input w_D, with rows for every state, and its output z_D in terms of x, wt, w."""

    e: np.ndarray
    z: np.ndarray


class Loop(NamedTuple):
    """The closed loop: its rows x', zt, z with columns x, wt, w, their numbers, and its model errors."""

    x: np.ndarray
    t: np.ndarray
    z: np.ndarray
    sizes: tuple[int, int, int]
    balls: list[Ball]


def _matrices(parts: dict, square: dict[str, str], *others: str) -> dict[str, np.ndarray]:
    """Return matrices that may have no rows: `square` names those with as many columns as another has rows."""
    columns = {key: len(parts[rows]) for rows, keys in square.items() for key in keys.split()}
    for keys in others:
        width = max((len(parts[key][0]) for key in keys.split() if parts.get(key)), default=0)
        columns |= dict.fromkeys(keys.split(), width)
    return {key: exact(rows, columns[key]) for key, rows in parts.items()}


def closed_loop(c: dict, errors: Sequence[dict]) -> Loop:
    """Close the loop of a certificate, with the model errors of the plant whose E, F, Fw and Fu are given."""
    p = _matrices(c["plant"], {"A": "A Ct C1 C2", "Ct": "Bt Dtt D1t D2t"}, "B1 Dt1 D11 D21", "B2 Dt2 D12 D22")
    k = _matrices(c["controller"], {"A": "A Cu Ct", "Ct": "Bt Dut Dtt"}, "By Duy Dty")
    n, nk = len(p["A"]), len(k["A"])
    rk = len(k["Ct"])
    y = np.hstack([p["C2"], zeros(len(p["C2"]), nk), p["D2t"], zeros(len(p["C2"]), rk), p["D21"]])
    u = k["Duy"] @ y
    nu, r, w = len(u), p["Bt"].shape[1], p["B1"].shape[1]
    u = u + np.hstack([zeros(nu, n), k["Cu"], zeros(nu, r), k["Dut"], zeros(nu, w)])

    def of_plant(x: str, t: str, w_: str, b: str) -> np.ndarray:
        rows = len(p[x])
        open_ = np.hstack([p[x], zeros(rows, nk), p[t], zeros(rows, rk), p[w_]])
        return open_ + p[b] @ u

    def of_controller(x: str, t: str, b: str) -> np.ndarray:
        rows = len(k[x])
        open_ = np.hstack([zeros(rows, n), k[x], zeros(rows, r), k[t], zeros(rows, w)])
        return open_ + k[b] @ y

    balls = []
    for ball in errors:
        e, f, fu = exact(ball["E"]), exact(ball["F"]), exact(ball["Fu"])
        fw = exact(ball["Fw"]) if "Fw" in ball else zeros(len(f), w)
        z = np.hstack([f, zeros(len(f), nk + r + rk), fw]) + fu @ u
        balls.append(Ball(np.vstack([e, zeros(nk, e.shape[1])]), z))
    return Loop(
        x=np.vstack([of_plant("A", "Bt", "B1", "B2"), of_controller("A", "Bt", "By")]),
        t=np.vstack([of_plant("Ct", "Dtt", "Dt1", "Dt2"), of_controller("Ct", "Dtt", "Dty")]),
        z=of_plant("C1", "D1t", "D11", "D12"),
        sizes=(n + nk, r + rk, w),
        balls=balls,
    )
