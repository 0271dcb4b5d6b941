"""The synthesis inequalities of an LPV controller written in cvxpy and solved by Clarabel.

P. Apkarian, P. Gahinet, IEEE Trans. Automatic Control 40(5), 1995, with the skew scalings of G. Scorletti,
L. El Ghaoui, Int. J. Robust Nonlinear Control 8, 1998: the same inequalities, in the same compact form, that the
crate `lpv` solves, and then the bounded-real inequality of the closed loop, affine in the controller.
"""

from __future__ import annotations

from dataclasses import dataclass

import cvxpy as cp
import numpy as np
from scipy.linalg import block_diag, null_space

BACK_OFF = 0.1
GROWTH = 10.0  # Allowed size of the unknowns in the centred point, relative to their least size.


@dataclass
class Plant:
    """x' = A x + Bt wt + B1 w + B2 u, zt = Ct x + ..., z = C1 x + ..., y = C2 x + D2t wt + D21 w."""

    m: dict[str, np.ndarray]
    blocks: list[int]

    def __getattr__(self, name: str) -> np.ndarray:
        return self.m[name]

    def dual(self) -> Plant:
        """Return the plant with inputs and outputs exchanged."""
        names = {"A": "A", "Bt": "Ct", "Ct": "Bt", "B1": "C1", "C1": "B1", "B2": "C2", "C2": "B2", "Dtt": "Dtt"}
        names |= {"Dt1": "D1t", "D1t": "Dt1", "Dt2": "D2t", "D2t": "Dt2", "D11": "D11", "D12": "D21", "D21": "D12"}
        return Plant({new: self.m[old].T for new, old in names.items() if old in self.m}, self.blocks)


def scaling(blocks: list[int], sign: int) -> cp.Expression:
    """Return a symmetric (sign 1) or skew (sign -1) unknown that commutes with every Theta."""
    r, top, columns = sum(blocks), 0, []
    for size in blocks:
        for i in range(size):
            for j in range(i + 1 if sign < 0 else i, size):
                basis = np.zeros((r, r))
                basis[top + j, top + i] = sign
                basis[top + i, top + j] = 1.0
                columns.append(basis.reshape(-1, order="F"))
        top += size
    if not columns:
        return cp.Constant(np.zeros((r, r)))
    return cp.reshape(np.array(columns).T @ cp.Variable(len(columns)), (r, r), order="F")


def projected(p: Plant, gamma: cp.Expression, x: cp.Expression, s: cp.Expression, t: cp.Expression) -> cp.Expression:
    """Return the bounded-real matrix of the open plant on the kernel of [C2 D2t D21], symmetric by construction."""
    n, r, w, z = len(p.A), len(p.Dtt), p.B1.shape[1], len(p.C1)
    e = np.split(np.eye(n + r + w + z), np.cumsum([n, r, w]), axis=1)
    state, channel, inputs, outputs = (part.T for part in e)
    rate = p.A @ state + p.Bt @ channel + p.B1 @ inputs
    inner = p.Ct @ state + p.Dtt @ channel + p.Dt1 @ inputs
    error = p.C1 @ state + p.D1t @ channel + p.D11 @ inputs
    kernel = block_diag(null_space(np.hstack([p.C2, p.D2t, p.D21])), np.eye(z))
    state, channel, inputs, outputs, rate, inner, error = (
        m @ kernel for m in (state, channel, inputs, outputs, rate, inner, error)
    )
    half = state.T @ x @ rate + channel.T @ t @ inner + outputs.T @ error
    levels = inputs.T @ inputs + outputs.T @ outputs
    return half + half.T - channel.T @ s @ channel + inner.T @ s @ inner - gamma * levels


class Inequalities:
    """The unknowns and the primal, dual and coupling inequalities."""

    def __init__(self, p: Plant, gamma: cp.Expression) -> None:
        n = len(p.A)
        self.x, self.y = cp.Variable((n, n), symmetric=True), cp.Variable((n, n), symmetric=True)
        self.s, self.sigma = scaling(p.blocks, 1), scaling(p.blocks, 1)
        self.t, self.skew = scaling(p.blocks, -1), scaling(p.blocks, -1)
        self.primal = projected(p, gamma, self.x, self.s, self.t)
        self.dual = projected(p.dual(), gamma, self.y, self.sigma, self.skew)

    def coupling(self, room: cp.Expression | float) -> cp.Constraint:
        """Return [X tI; tI Y] >= 0."""
        identity = np.eye(self.x.shape[0]) * room
        return cp.bmat([[self.x, identity], [identity, self.y]]) >> 0

    def hold(self, clear: cp.Expression | float = 0.0) -> list[cp.Constraint]:
        """Return primal, dual <= -clear I and S, Sigma >= clear I."""
        first, second, third = (np.eye(m.shape[0]) for m in (self.primal, self.dual, self.s))
        return [
            self.primal << -clear * first,
            self.dual << -clear * second,
            self.s >> clear * third,
            self.sigma >> clear * third,
        ]


def solve(objective: cp.Minimize | cp.Maximize, constraints: list[cp.Constraint]) -> float:
    """Solve with Clarabel; raise an error unless the status is optimal."""
    problem = cp.Problem(objective, constraints)
    problem.solve(solver=cp.CLARABEL)
    if problem.status not in ("optimal", "optimal_inaccurate"):
        raise ArithmeticError(problem.status)
    return float(problem.value)


def least_gamma(p: Plant) -> float:
    """Return the least gamma that the solver reports."""
    gamma = cp.Variable()
    lmi = Inequalities(p, gamma)
    return solve(cp.Minimize(gamma), [*lmi.hold(), lmi.coupling(1.0)])


def centred(p: Plant, gamma: float) -> Inequalities:
    """Return a centred point at `gamma`: smallest matrices, then most room, then half of it and most clearance."""
    lmi = Inequalities(p, gamma)
    identity = np.eye(len(p.Dtt))
    scalings = cp.bmat([[lmi.s, identity], [identity, lmi.sigma]]) >> 0
    size = cp.trace(lmi.x) + cp.trace(lmi.y) + cp.trace(lmi.s) + cp.trace(lmi.sigma)
    solve(cp.Minimize(size), [*lmi.hold(), lmi.coupling(1.0), scalings])
    all_unknowns = (lmi.x, lmi.y, lmi.s, lmi.sigma)
    bounds = [unknown << GROWTH * (unknown.value + unknown.value.T) / 2 for unknown in all_unknowns]
    room = cp.Variable()
    most = solve(cp.Maximize(room), [*lmi.hold(), *bounds, lmi.coupling(room)])
    clear = cp.Variable()
    kept = 1.0 + max(most - 1.0, 0.0) / 2
    solve(cp.Maximize(clear), [*lmi.hold(clear), *bounds, lmi.coupling(kept)])
    return lmi


def reconstruct(p: Plant, lmi: Inequalities, gamma: float) -> tuple[np.ndarray, float]:
    """Return the controller's matrix, and the clearance of the closed loop's inequality at fixed X_c and W_e."""
    x, z = lmi.x.value, lmi.x.value - np.linalg.inv(lmi.y.value)
    lyapunov = np.block([[x, z], [z, z]])
    lyapunov = (lyapunov + lyapunov.T) / 2
    w, u = lmi.s.value + lmi.t.value, np.linalg.inv(lmi.sigma.value + lmi.skew.value)
    multiplier = np.block([[w, w - u], [w + u.T, w + u.T]])
    s, t = (multiplier + multiplier.T) / 2, (multiplier - multiplier.T) / 2
    n, r, nw, nu = len(p.A), len(p.Dtt), p.B1.shape[1], p.B2.shape[1]
    nz, ny = len(p.C1), len(p.C2)
    k = cp.Variable((n + nu + r, n + ny + r))
    into_x = np.block([[np.zeros((n, n)), p.B2, np.zeros((n, r))], [np.eye(n), np.zeros((n, nu + r))]])
    into_t = np.block([[np.zeros((r, n)), p.Dt2, np.zeros((r, r))], [np.zeros((r, n + nu)), np.eye(r)]])
    into_z = np.block([np.zeros((nz, n)), p.D12, np.zeros((nz, r))])
    of_x = np.block([[np.zeros((n, n)), np.eye(n)], [p.C2, np.zeros((ny, n))], [np.zeros((r, 2 * n))]])
    of_t = np.block([[np.zeros((n, 2 * r))], [p.D2t, np.zeros((ny, r))], [np.zeros((r, r)), np.eye(r)]])
    of_w = np.vstack([np.zeros((n, nw)), p.D21, np.zeros((r, nw))])
    zero = np.zeros
    a = block_diag(p.A, zero((n, n))) + into_x @ k @ of_x
    bt = block_diag(p.Bt, zero((n, r))) + into_x @ k @ of_t
    b1 = np.vstack([p.B1, zero((n, nw))]) + into_x @ k @ of_w
    ct = block_diag(p.Ct, zero((r, n))) + into_t @ k @ of_x
    dtt = block_diag(p.Dtt, zero((r, r))) + into_t @ k @ of_t
    dt1 = np.vstack([p.Dt1, zero((r, nw))]) + into_t @ k @ of_w
    c1 = np.hstack([p.C1, zero((nz, n))]) + into_z @ k @ of_x
    d1t = np.hstack([p.D1t, zero((nz, r))]) + into_z @ k @ of_t
    d11 = p.D11 + into_z @ k @ of_w
    inner, flow = t @ dtt, lyapunov @ a
    rows = [
        [flow + flow.T, lyapunov @ bt + ct.T @ t.T, lyapunov @ b1, ct.T @ s, c1.T],
        [None, inner + inner.T - s, t @ dt1, dtt.T @ s, d1t.T],
        [None, None, -gamma * np.eye(nw), dt1.T @ s, d11.T],
        [None, None, None, -s, zero((2 * r, nz))],
        [None, None, None, None, -gamma * np.eye(nz)],
    ]
    whole = cp.bmat([[rows[i][j] if j >= i else rows[j][i].T for j in range(5)] for i in range(5)])
    clear = cp.Variable()
    solve(cp.Maximize(clear), [whole << -clear * np.eye(whole.shape[0])])
    value = (whole.value + whole.value.T) / 2
    return k.value, -float(np.linalg.eigvalsh(value)[-1])


def synthesise(p: Plant) -> tuple[float, float]:
    """Return the least gamma, and the clearance of the closed loop at (1 + BACK_OFF) times it."""
    least = least_gamma(p)
    gamma = (1 + BACK_OFF) * least
    return least, reconstruct(p, centred(p, gamma), gamma)[1]
