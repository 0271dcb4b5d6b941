"""The inequality for constant parameters, with filters on their channels, written in cvxpy and solved by Clarabel.

A. Megretski, A. Rantzer, IEEE Trans. Automatic Control 42(6), 1997, theorem 1: the inequality of docs/constant.md for
the same loop, filters and model errors, whose multipliers the crate `lpv` seeks at frequencies, without X.
"""

from __future__ import annotations

from dataclasses import dataclass

import cvxpy as cp
import numpy as np
from claims import claim
from decimals import Ball, Loop, closed_loop
from lpv_cvxpy import solve
from scipy.linalg import solve_continuous_lyapunov

OMEGA = np.logspace(-4, 3, 60)
"""Frequencies at which channels are evened, rad/s."""
SWEEPS = 30
TINY = 1e-9
"""Of a peak: channels that nothing reaches keep a size."""
LEAST = 1e-3
"""What every state is reached and seen by at least, in units of the Lyapunov matrix, before the loop is balanced."""


@dataclass
class Filtered:
    """Maps from (x, f | wt, w_D, w) to x' and f', to zt and wt with their filtered values, to z_D and w_D, and to z."""

    dynamics: np.ndarray
    into: np.ndarray
    source: np.ndarray
    errors: list[tuple[np.ndarray, np.ndarray]]
    output: np.ndarray
    states: int
    inputs: int
    parameters: np.ndarray
    unit: float

    @classmethod
    def of(cls, certificate: dict) -> Filtered:
        """Close the loop of a certificate whose filters have no rates."""
        claimed = claim(certificate, "constant")
        loop = in_good_coordinates(closed_loop(certificate, certificate["errors"]), claimed)
        n, r, w = loop.sizes
        lengths = (certificate[key] for key in ("blocks", "controller_blocks"))
        channels = np.concatenate([np.repeat(np.arange(len(counts)), counts) for counts in lengths])
        own = [(f["pole"], j) for f in claimed["filters"] for j in np.flatnonzero(channels == f["parameter"])]
        k, wd = len(own), sum(e.shape[1] for e, _ in loop.balls)
        units = np.eye(n + 2 * k + r + wd + w)

        def spread(m: np.ndarray) -> np.ndarray:
            between = np.zeros((len(m), 2 * k)), np.zeros((len(m), wd))
            return np.hstack([m[:, :n], between[0], m[:, n : n + r], between[1], m[:, n + r :]])

        zt, wt, at = spread(loop.t), units[n + 2 * k : n + 2 * k + r], n + 2 * k + r
        moved, errors = spread(loop.x), []
        for e, z in loop.balls:
            source = units[at : at + e.shape[1]]
            moved, at = moved + e @ source, at + e.shape[1]
            errors.append((spread(z), source))
        behind = [
            source[j] - pole * units[start + i]
            for source, start in ((zt, n), (wt, n + k))
            for i, (pole, j) in enumerate(own)
        ]
        return cls(
            dynamics=np.vstack([moved, *behind]),
            into=np.vstack([zt, units[n : n + k]]),
            source=np.vstack([wt, units[n + k : n + 2 * k]]),
            errors=errors,
            output=spread(loop.z),
            states=n + 2 * k,
            inputs=w,
            parameters=np.concatenate([channels, channels[[j for _, j in own]]]),
            unit=claimed["gamma"],
        )


def in_good_coordinates(loop: Loop, claimed: dict) -> Loop:
    """Return the loop with balanced states, equilibrated channels, and the claim's gamma as the unit of gain.

    Clarabel fails if the channels are not equilibrated.
    """
    n, r, _ = loop.sizes
    x, t, z = (m.astype(float) for m in (loop.x, loop.t, loop.z))
    balls = [Ball(e.astype(float), seen.astype(float)) for e, seen in loop.balls]
    scale, root = even(x, t, n, r), np.sqrt(claimed["gamma"])
    t, z = t / scale[:, None], z / root
    for m in (x, t, z, *(ball.z for ball in balls)):
        m[:, n : n + r] *= scale
        m[:, n + r :] /= root
    to = np.linalg.cholesky(np.array(claimed["L"])).T
    back = np.linalg.inv(to)
    reached = np.hstack([x[:, n:], *(ball.e for ball in balls)])
    seen = np.vstack([t, z, *(ball.z for ball in balls)])[:, :n]
    back = back @ balancing(to @ x[:, :n] @ back, to @ reached, seen @ back)
    to = np.linalg.inv(back)
    for m in (x, t, z, *(ball.z for ball in balls)):
        m[:, :n] = m[:, :n] @ back
    return Loop(to @ x, t, z, loop.sizes, [Ball(to @ ball.e, ball.z) for ball in balls])


def even(state: np.ndarray, channel: np.ndarray, n: int, r: int) -> np.ndarray:
    """Return d of zt = d zt~, wt = d wt~ that equilibrates rows and columns of the peaks from wt~ to zt~."""
    peaks = np.abs(channel[:, n : n + r])
    for omega in OMEGA:
        inner = np.linalg.solve(1j * omega * np.eye(n) - state[:, :n], state[:, n : n + r])
        peaks = np.maximum(peaks, np.abs(channel[:, :n] @ inner + channel[:, n : n + r]))
    scale = np.ones(r)
    for _ in range(SWEEPS):
        for j in range(r):
            row, column = peaks[j] * scale / scale[j], peaks[:, j] / scale * scale[j]
            scale[j] *= np.sqrt((np.linalg.norm(row) + TINY) / (np.linalg.norm(column) + TINY))
    return scale


def balancing(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return T of x = T x~ for which both gramians are equal and diagonal."""
    floor = LEAST**2 * np.eye(len(a))
    reached = np.linalg.cholesky(solve_continuous_lyapunov(a, -b @ b.T - floor))
    shown = np.linalg.cholesky(solve_continuous_lyapunov(a.T, -c.T @ c - floor))
    _, values, right = np.linalg.svd(shown.T @ reached)
    return reached @ right.T / np.sqrt(values)


def commuting(parameters: np.ndarray, sign: int) -> cp.Expression:
    """Return a symmetric (sign 1) or skew (sign -1) unknown that is zero between channels of different parameters."""
    size = len(parameters)
    pairs = [
        (i, j) for i in range(size) for j in range(i + (sign < 0), size) if parameters[i] == parameters[j]
    ]
    basis = np.zeros((size * size, len(pairs)))
    for column, (i, j) in enumerate(pairs):
        basis[size * i + j, column] = sign
        basis[size * j + i, column] = 1.0
    return cp.reshape(basis @ cp.Variable(len(pairs)), (size, size), order="F")


def least_gamma(of: Filtered) -> float:
    """Return the least gamma that the solver reports."""
    width, gamma = of.dynamics.shape[1], cp.Variable()
    x = cp.Variable((of.states, of.states), symmetric=True)
    s, t = (commuting(of.parameters, sign) for sign in (1, -1))
    state, inputs = np.eye(width)[: of.states], np.eye(width)[width - of.inputs :]
    half = state.T @ x @ of.dynamics + of.source.T @ t @ of.into
    upper = half + half.T + of.into.T @ s @ of.into - of.source.T @ s @ of.source - gamma * inputs.T @ inputs
    signs = [
        s[np.ix_(own, own)] >> 0 for own in (np.flatnonzero(of.parameters == p) for p in set(of.parameters))
    ]
    for into, source in of.errors:
        factor = cp.Variable(nonneg=True)
        upper = upper + factor * (into.T @ into - source.T @ source)
    whole = cp.bmat([[upper, of.output.T], [of.output, -gamma * np.eye(len(of.output))]])
    return of.unit * solve(cp.Minimize(gamma), [whole << 0, *signs])
