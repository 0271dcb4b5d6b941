"""The claim for a bounded rate, checked independently from the certificate's file alone, in decimals of 120 digits."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from decimal import Decimal, localcontext
from itertools import pairwise
from math import comb
from pathlib import Path

import numpy as np
import pytest
from claims import claim, claims
from conftest import Run, masked, messages, refusal
from decimals import DIGITS, Loop, closed_loop, exact, is_positive, zeros
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

GOLDEN = ROOT / "tests" / "certificates" / "remus100_bounded_rate.json"
ALONE = ROOT / "tests" / "certificates" / "oscillator_bounded_rate.json"
"""A loop with no bound for a parameter that varies arbitrarily fast: the claim of the rate stands alone."""


class Form:
    """One claim: `2 x'X x' +- rate x' dX/dtheta x + z'z/gamma - gamma w'w + lambda (z_D'z_D - w_D'w_D)`."""

    def __init__(self, loop: Loop, claim: dict, rate: float) -> None:
        n, r, w = loop.sizes
        e, error = loop.balls[0] if "lambda" in claim else (zeros(n, 0), zeros(0, n + r + w))
        d, f, z = e.shape[1], len(error), len(loop.z)
        rows = [
            np.hstack([m[:, : n + r], zeros(len(m), d), m[:, n + r :]])
            for m in (loop.x, loop.t, error, loop.z)
        ]
        rows[0][:, n + r : n + r + d] = e
        whole = np.vstack(rows)
        if claim["inverse"]:
            whole, (d, w, f, z) = whole.T, (f, z, d, w)
        ends = np.cumsum([n, r, f, z])
        self.moved, self.inner, self.error, self.seen = np.split(whole, ends[:-1])
        unit = np.where(np.eye(n + r + d + w) == 1, Decimal(1), Decimal(0))
        self.state, self.channel, self.delta, self.input = np.split(unit, np.cumsum([n, r, d]))
        self.x = [exact(m) for m in claim["X"]]
        self.gamma, self.factor = Decimal(claim["gamma"]), Decimal(claim.get("lambda", 0))
        self.rate = Decimal(rate)

    def without_multiplier(self, x: np.ndarray, drift: np.ndarray) -> np.ndarray:
        """Return the terms independent of theta, given X and its slope times the rate."""
        half = self.state.T @ (x @ self.moved)
        sizes = self.seen.T @ self.seen / self.gamma - self.input.T @ self.input * self.gamma
        model_error = (self.error.T @ self.error - self.delta.T @ self.delta) * self.factor
        return half + half.T + self.state.T @ (drift @ self.state) + sizes + model_error

    def powers(self, multiplier: np.ndarray, sign: int) -> list[np.ndarray]:
        """Return the matrices of 1, theta, theta^2, ... with the multiplier's term."""
        none = zeros(len(self.x[0]), len(self.x[0]))
        slopes = [*(x * (k * sign * self.rate) for k, x in enumerate(self.x) if k), none]
        fixed = self.without_multiplier(none, none)
        out = [self.without_multiplier(x, slope) - fixed for x, slope in zip(self.x, slopes, strict=True)]
        out += [zeros(*fixed.shape)] * (2 - len(out))
        on, off = multiplier.T @ self.channel, multiplier.T @ self.inner
        out[0] = out[0] + fixed + on + on.T
        out[1] = out[1] - off - off.T
        return out

    def at(self, theta: Decimal) -> Iterator[np.ndarray]:
        """Yield X(theta), and for both signs the form along the loop (wt = theta zt), which must be negative."""
        into = solve(self.channel @ self.channel.T - self.inner @ self.channel.T * theta, self.inner * theta)
        along = np.delete(np.eye(len(into.T), dtype=int) * Decimal(1), self.channel.argmax(1), axis=1)
        along = along + self.channel.T @ (into @ along)
        x = sum(x * power(theta, k) for k, x in enumerate(self.x))
        slope = sum((x * (k * power(theta, k - 1)) for k, x in enumerate(self.x) if k), zeros(*x.shape))
        yield x
        for sign in (1, -1):
            yield -along.T @ self.without_multiplier(x, slope * (sign * self.rate)) @ along


def power(base: Decimal, k: int) -> Decimal:
    """Return base^k; 0^0 is undefined for decimals."""
    return base**k if k else Decimal(1)


def solve(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve a x = b by Gauss-Jordan with row pivots."""
    m = np.hstack([a, b])
    for k in range(len(m)):
        pivot = k + int(np.argmax(np.abs(m[k:, k])))
        m[[k, pivot]] = m[[pivot, k]]
        m[k] = m[k] / m[k, k]
        for i in set(range(len(m))) - {k}:
            m[i] = m[i] - m[k] * m[i, k]
    return m[:, len(a) :]


def bernstein(powers: list[np.ndarray], low: Decimal, high: Decimal) -> Iterator[np.ndarray]:
    """Yield the Bernstein coefficients on an interval, from the powers of s in theta = low + (high - low) s."""
    degree = len(powers) - 1
    shifted = [
        sum(powers[j] * (comb(j, k) * power(low, j - k)) for j in range(k, degree + 1)) * power(high - low, k)
        for k in range(degree + 1)
    ]
    for i in range(degree + 1):
        yield sum(shifted[k] * (Decimal(comb(i, k)) / comb(degree, k)) for k in range(i + 1))


def forms(c: dict) -> Iterator[tuple[Form, dict]]:
    """Yield the claim of the plant, and that of the ball if there is one, each with its matrices."""
    loop = closed_loop(c, c.get("errors", []))
    for found in claims(c, "rate"):
        yield Form(loop, found, found["rate"]), found


def why_not(c: dict) -> str | None:
    """Return the first condition of docs/certificate.md on the bounded rate that does not hold, or None."""
    for form, found in forms(c):
        ends = [Decimal(at) for at in found["breakpoints"]]
        if form.rate < 0 or form.gamma <= 0 or ("lambda" in found and form.factor <= 0):
            return "a sign"
        if not all((x == x.T).all() for x in form.x) or not is_positive(form.x[0]):
            return "X"
        intervals = list(pairwise(ends))
        ascending = all(low < high for low, high in intervals)
        if (ends[0], ends[-1]) != (-1, 1) or not ascending or len(found["N"]) != len(intervals):
            return "breakpoints"
        for (low, high), rows in zip(intervals, found["N"], strict=True):
            for sign in (1, -1):
                coefficients = bernstein(form.powers(exact(rows), sign), low, high)
                if not all(is_positive(-coefficient) for coefficient in coefficients):
                    return "the form"
    return None


@pytest.fixture(scope="module")
def certificate() -> dict:
    """Return the committed certificate of REMUS 100 with tracking errors only."""
    return json.loads(GOLDEN.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def alone() -> dict:
    """Return the committed certificate with only the rate's claim."""
    return json.loads(ALONE.read_text(encoding="utf-8"))


def test_independent_check_agrees(certificate: dict, alone: dict) -> None:
    """All conditions of docs/certificate.md hold: for the fit, for the ball, and for the rate alone."""
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(certificate) is None
        assert why_not(alone) is None
    assert [list(one) for one in alone["claims"]] == [["rate"]]


def with_rate(factor: float) -> Callable[[dict, dict], None]:
    """Return a function that changes the rate of both claims."""

    def change(bounded: dict, robust: dict) -> None:
        bounded["rate"] = robust["rate"] = factor * bounded["rate"]

    return change


def merge(bounded: dict, _: dict) -> None:
    """Merge two intervals into one."""
    at = len(bounded["N"]) // 2
    del bounded["breakpoints"][at], bounded["N"][at]


def end_early(bounded: dict, _: dict | None = None) -> None:
    """Leave out the last interval."""
    del bounded["breakpoints"][-1], bounded["N"][-1]


def asymmetric(bounded: dict, _: dict | None = None) -> None:
    """Make X(theta) asymmetric by one digit."""
    bounded["X"][1][0][1] *= 1 + 1e-12


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (with_rate(1.5), "the form"),
        (with_rate(-1.0), "a sign"),
        (lambda b, _: b.update(gamma=0.9 * b["gamma"]), "the form"),
        (lambda b, r: r.update(gamma=b["gamma"]), "the form"),
        (lambda _, r: r.update({"lambda": 1e-3 * r["lambda"]}), "the form"),
        (lambda b, _: b.update(X=b["X"][:1]), "the form"),
        (lambda b, _: b["X"][0][0].__setitem__(0, -b["X"][0][0][0]), "X"),
        (asymmetric, "X"),
        (lambda b, _: b["N"][3][0].__setitem__(0, 2 * b["N"][3][0][0]), "the form"),
        (lambda b, _: b["N"].reverse(), "the form"),
        (merge, "the form"),
        (end_early, "breakpoints"),
        (lambda b, _: b["breakpoints"].__setitem__(0, -0.99), "breakpoints"),
        (lambda b, _: b["breakpoints"].reverse(), "breakpoints"),
        (lambda b, _: b.update(inverse=True), "the form"),
        # A weaker promise remains true.
        (with_rate(0.5), None),
        (lambda b, _: b.update(gamma=1.01 * b["gamma"]), None),
    ],
)
def test_both_checks_agree_on_a_changed_file(
    certificate: dict,
    run_squid: Run,
    tmp_path: Path,
    spoil: Callable[[dict, dict], None],
    reason: str | None,
) -> None:
    """Command and independent check refuse the same files."""
    changed = copy.deepcopy(certificate)
    spoil(*claims(changed, "rate"))
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(changed) == reason
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(changed), encoding="utf-8")
    done = run_squid("verify", path)
    assert done.returncode == (reason is not None), done.stderr
    assert ("PROVED" in done.stdout) == (reason is None)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda c: claim(c, "rate").update(rate=2 * claim(c, "rate")["rate"]), "the form"),
        (lambda c: claim(c, "rate").update(gamma=0.99 * claim(c, "rate")["gamma"]), "the form"),
        (lambda c: claim(c, "rate")["X"].pop(), "the form"),
        (lambda c: claim(c, "rate").update(breakpoints=[-1, 1], N=claim(c, "rate")["N"][:1]), "the form"),
        (lambda c: end_early(claim(c, "rate")), "breakpoints"),
        (lambda c: asymmetric(claim(c, "rate")), "X"),
        (lambda c: c["plant"]["Bt"][1].__setitem__(0, -0.6), "the form"),
        (lambda c: c["plant"]["A"][1].__setitem__(1, 0.0), "the form"),
        (lambda c: claim(c, "rate").update(gamma=1.01 * claim(c, "rate")["gamma"]), None),
    ],
)
def test_both_checks_agree_on_a_changed_file_of_the_rate_alone(
    alone: dict, run_squid: Run, tmp_path: Path, spoil: Callable[[dict], None], reason: str | None
) -> None:
    """Command and independent check agree without a claim for arbitrary rates as a fallback."""
    changed = copy.deepcopy(alone)
    spoil(changed)
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(changed) == reason
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(changed), encoding="utf-8")
    done = run_squid("verify", path)
    assert done.returncode == (reason is not None), done.stderr
    assert ("PROVED" in done.stdout) == (reason is None)


@pytest.mark.parametrize(
    ("more", "key"),
    [
        ([], "certificate"),
        ([{"gain": {"gamma": 100.0}}], "certificate"),
        ([{"gain": {"gamma": 100.0, "S": [[1.0]], "T": [[0.0]]}}], "certificate"),
        ([{"gain": {"gamma": 100.0, "X": [[2.0, 0.1], [0.1, 2.0]], "S": [[1.0]], "T": [[0.0]]}}], "unproved"),
    ],
)
def test_what_the_rate_alone_does_not_carry(
    alone: dict, run_squid: Run, tmp_path: Path, more: list[dict], key: str, snapshot: SnapshotAssertion
) -> None:
    """No claim, a partial claim, and a false claim for any rate next to the true one are refused."""
    changed = alone | {"claims": [*alone["claims"], *more] if more else []}
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(changed), encoding="utf-8")
    done = run_squid("verify", path, "--json")
    refusal(done, key)
    assert masked(messages(done, TMP=tmp_path)) == snapshot


def test_the_inequality_holds_along_the_loop(certificate: dict, alone: dict) -> None:
    """Without multipliers and intervals: X(theta) > 0 and the loop's own inequality hold at 33 values of theta."""
    with localcontext() as context:
        context.prec = DIGITS
        for form, _ in [*forms(certificate), *forms(alone)]:
            for i in range(-16, 17):
                assert all(is_positive(m) for m in form.at(Decimal(i) / 16))
            # The test can fail: at a hundredth of gamma the form is not negative.
            form.gamma /= 100
            assert not all(is_positive(m) for m in form.at(Decimal(0)))


def test_frozen_loops_keep_the_gain(certificate: dict) -> None:
    """At frozen speeds the gain, evaluated in floating point over frequency, is below the claimed one."""
    with localcontext() as context:
        context.prec = DIGITS
        loop = closed_loop(certificate, [])
    n, r, _ = loop.sizes
    state, inner, output = (m.astype(float) for m in (loop.x, loop.t, loop.z))
    largest = 0.0
    for theta in np.linspace(-1.0, 1.0, 17):
        into = np.linalg.solve(np.eye(r) - theta * inner[:, n : n + r], theta * inner)
        moved, seen = (m + m[:, n : n + r] @ into for m in (state, output))
        assert np.linalg.eigvals(moved[:, :n]).real.max() < 0
        for omega in np.logspace(-4, 3, 60):
            response = seen[:, :n] @ np.linalg.solve(1j * omega * np.eye(n) - moved[:, :n], moved[:, n + r :])
            largest = max(largest, np.linalg.norm(response + seen[:, n + r :], 2))
    bounded, gain = claim(certificate, "rate"), claim(certificate, "gain")
    assert 0.5 * bounded["gamma"] < largest < bounded["gamma"] < gain["gamma"]
