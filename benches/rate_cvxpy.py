"""The synthesis inequalities for a parameter that moves at a bounded rate, written in cvxpy and solved by Clarabel.

F. Wu, X. H. Yang, A. Packard, G. Becker, Int. J. Robust Nonlinear Control 6, 1996: the same inequalities at the same
values of the parameter, for the same polynomials X and Y in it, that the crate `lpv` solves.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np
from lpv_cvxpy import Plant, solve
from scipy.linalg import block_diag, null_space

POINTS = 7
ORDER = 2
VARYING = ("XY", "X", "Y")


def frozen(p: Plant, theta: float) -> Plant:
    """Return the plant at a value of its only parameter."""
    inner = np.linalg.solve(np.eye(len(p.Dtt)) - theta * p.Dtt, theta * np.eye(len(p.Dtt)))
    rows = {"Bt": ("A", "B1", "B2"), "D1t": ("C1", "D11", "D12"), "D2t": ("C2", "D21")}
    closed = {}
    for left, names in rows.items():
        for name, right in zip(names, ("Ct", "Dt1", "Dt2"), strict=False):  # D22 is 0.
            closed[name] = p.m[name] + p.m[left] @ inner @ p.m[right]
    return Plant(closed, [])


def projected(p: Plant, gamma: cp.Expression, x: cp.Expression, drift: cp.Expression) -> cp.Expression:
    """Return the bounded-real matrix of the open plant on the kernel of [C2 D21], with X' in its first block."""
    n, w, z = len(p.A), p.B1.shape[1], len(p.C1)
    kernel = block_diag(null_space(np.hstack([p.C2, p.D21])), np.eye(z))
    state, inputs, outputs = (m.T @ kernel for m in np.split(np.eye(n + w + z), np.cumsum([n, w]), axis=1))
    half = state.T @ x @ (p.A @ state + p.B1 @ inputs) + outputs.T @ (p.C1 @ state + p.D11 @ inputs)
    levels = inputs.T @ inputs + outputs.T @ outputs
    return half + half.T + state.T @ drift @ state - gamma * levels


def least_of(p: Plant, rate: float, varying: str) -> float:
    """Return the least gamma with X, Y or both polynomials in the parameter."""
    n = len(p.A)
    family = {
        name: [cp.Variable((n, n), symmetric=True) for _ in range(ORDER + 1 if name in varying else 1)]
        for name in "XY"
    }
    gamma = cp.Variable()
    constraints = []
    for theta in np.linspace(-1.0, 1.0, POINTS):
        plant = frozen(p, theta)
        values = {name: sum(m * theta**k for k, m in enumerate(terms)) for name, terms in family.items()}
        for name, side in (("X", plant), ("Y", plant.dual())):
            terms = family[name]
            slope = sum((m * (k * theta ** (k - 1)) for k, m in enumerate(terms) if k), np.zeros((n, n)))
            for sign in (1, -1) if len(terms) > 1 else (0,):
                constraints.append(projected(side, gamma, values[name], sign * rate * slope) << 0)
        constraints.append(cp.bmat([[values["X"], np.eye(n)], [np.eye(n), values["Y"]]]) >> 0)
    return solve(cp.Minimize(gamma), constraints)


def least_gamma(p: Plant, rate: float) -> float:
    """Return the least gamma over the choices of varying matrices; a choice that Clarabel cannot solve is left out."""
    found = []
    for varying in VARYING:
        try:
            found.append(least_of(p, rate, varying))
        except (ArithmeticError, cp.error.SolverError):
            continue
    return min(found, default=float("nan"))
