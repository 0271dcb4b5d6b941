"""The inequalities of a loop whose commands are cut off, written in cvxpy and solved by Clarabel.

The gain of such a loop for w of bounded energy, and the anti-windup gain that is best for it, as convex programs: T.
Hu, A. R. Teel, L. Zaccarian, IEEE Trans. Automatic Control 51(11), 2006; the sector condition: J. M. Gomes da Silva
Jr., S. Tarbouriech, IEEE Trans. Automatic Control 50(1), 2005. The same inequalities that the crate `lpv` solves, for
the same plant, controller and limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import cvxpy as cp
import numpy as np
from claims import claim
from lpv_cvxpy import solve
from scipy.linalg import solve_continuous_lyapunov, sqrtm

GAINS = (1.25, 2.0, 5.0)
"""At which the largest energy is sought, in units of that without limits; the anti-windup gain is made at the
second."""
LARGEST = 1e4
"""Of the anti-windup gain: without a bound it grows without limit."""


@dataclass
class Limited:
    """x' = A x + cut phi + B w, u = K x + L w, z = C x + reach phi + D w: phi = u - sat(u) is missing in the plant."""

    m: dict[str, np.ndarray]
    states: int
    limits: list[float]

    @classmethod
    def of(cls, certificate: dict) -> Limited:
        """Close the loop of plant and controller of a certificate, without parameters and without anti-windup."""
        parts = ("plant", "controller")
        p, k = ({key: np.array(value, float) for key, value in certificate[name].items()} for name in parts)
        n, nk, m = len(p["A"]), len(k["A"]), p["B2"].shape[1]
        command, of_w = np.hstack([k["Duy"] @ p["C2"], k["Cu"]]), k["Duy"] @ p["D21"]
        of_plant = np.vstack([p["B2"], np.zeros((nk, m))])
        open_loop = np.block([[p["A"], np.zeros((n, nk))], [k["By"] @ p["C2"], k["A"]]])
        c = np.hstack([p["C1"], np.zeros((len(p["C1"]), nk))])
        matrices = {
            "A": open_loop + of_plant @ command,
            "B": np.vstack([p["B1"], k["By"] @ p["D21"]]) + of_plant @ of_w,
            "cut": -of_plant,
            "K": command,
            "L": of_w,
            "C": c + p["D12"] @ command,
            "D": p["D11"] + p["D12"] @ of_w,
            "reach": -p["D12"],
        }
        enters = np.vstack([np.zeros((n, nk)), np.eye(nk)])
        size = np.linalg.cholesky(middle(matrices))
        for name in ("A", "B", "cut"):
            matrices[name] = np.linalg.solve(size, matrices[name])
        for name in ("A", "K", "C"):
            matrices[name] = matrices[name] @ size
        return cls(matrices | {"enters": np.linalg.solve(size, enters)}, nk, claim(certificate, "energy")["limits"])

    def __getattr__(self, name: str) -> np.ndarray:
        return self.m[name]


def middle(m: dict[str, np.ndarray]) -> np.ndarray:
    """Return the mean of what w and phi reach and of what z and u show: as they stand Clarabel fails at most gains."""
    inputs, outputs = np.hstack([m["B"], m["cut"]]), np.vstack([m["C"], m["K"]])
    reached = solve_continuous_lyapunov(m["A"], -inputs @ inputs.T)
    shown = np.linalg.inv(solve_continuous_lyapunov(m["A"].T, -outputs.T @ outputs))
    root = sqrtm(reached).real
    half = np.linalg.inv(root)
    mean = root @ sqrtm(half @ shown @ half).real @ root
    return 0.5 * (mean + mean.T)


def program(of: Limited, gain: np.ndarray | None, *, any_w: bool) -> tuple[cp.Expression, list, tuple]:
    """Return gamma, the constraints but for the limits, and the unknowns Q = X^-1, W = U^-1, H Q, G W."""
    n, m, q = len(of.A), len(of.limits), cp.Variable((len(of.A), len(of.A)), symmetric=True)
    weights, gamma = cp.diag(cp.Variable(m)), cp.Variable()
    h = cp.Constant(np.zeros((m, n))) if any_w else cp.Variable((m, n))
    moved = cp.Variable((of.states, m)) if gain is None else gain @ weights
    by_phi = of.cut @ weights + of.enters @ moved
    cross = by_phi + (of.K @ q - h).T
    w, z = of.B.shape[1], len(of.C)
    upper = cp.bmat(
        [
            [of.A @ q, cross, of.B, (of.C @ q).T],
            [np.zeros((m, n)), -weights, of.L, (of.reach @ weights).T],
            [np.zeros((w, n)), np.zeros((w, m)), -0.5 * gamma * np.eye(w), of.D.T],
            [np.zeros((z, n)), np.zeros((z, m)), np.zeros((z, w)), -0.5 * gamma * np.eye(z)],
        ]
    )
    holds = [upper + upper.T << 0, q >> 0, weights - 1e-9 * np.eye(m) >> 0]
    if gain is None:
        holds += [cp.abs(moved[:, j]) <= LARGEST * weights[j, j] for j in range(m)]
    return gamma, holds, (q, weights, h, moved)


def largest_energy(of: Limited, level: float, gain: np.ndarray | None) -> tuple[float, np.ndarray]:
    """Return the largest energy of w for a gain below `level`, and the anti-windup gain, given or found."""
    gamma, holds, (q, weights, h, moved) = program(of, gain, any_w=False)
    inverse = cp.Variable()
    for row, limit in enumerate(of.limits):
        border = h[row : row + 1, :]
        corner = cp.reshape(inverse * limit**2 / level, (1, 1), order="F")
        holds.append(cp.bmat([[q, border.T], [border, corner]]) >> 0)
    least = solve(cp.Minimize(inverse), [*holds, gamma == level])
    found = gain if gain is not None else moved.value @ np.linalg.inv(weights.value)
    return 1.0 / least, found


def least_gain(of: Limited, gain: np.ndarray) -> float:
    """Return the least gain for any w."""
    gamma, holds, _ = program(of, gain, any_w=True)
    return solve(cp.Minimize(gamma), holds)


def energies(of: Limited, gamma: float, gain: np.ndarray) -> list[float]:
    """Seek an anti-windup gain as the crate `lpv` does, and return the energies at the three gains with a given one."""
    largest_energy(of, GAINS[1] * gamma, None)
    return [largest_energy(of, factor * gamma, gain)[0] for factor in GAINS]


def least_or_none(of: Limited, gain: np.ndarray) -> float | None:
    """Return the least gain for any w; None where Clarabel fails."""
    try:
        return least_gain(of, gain)
    except (ArithmeticError, cp.error.SolverError):
        return None
