"""The certificate for constant coefficients, checked independently, in decimals of 120 digits."""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from fly.stages import ROOT

GOLDEN = ROOT / "tests" / "certificates" / "constant_squid.json"
DIGITS = 120


def exact(rows: list[list[float]], columns: int | None = None) -> np.ndarray:
    """Return a matrix of decimals; every float is one."""
    width = len(rows[0]) if rows and columns is None else columns or 0
    out = np.full((len(rows), width), Decimal(0), dtype=object)
    for i, row in enumerate(rows):
        out[i, :] = [Decimal(value) for value in row]
    return out


def zeros(rows: int, columns: int) -> np.ndarray:
    """Return a matrix of zeros."""
    return np.full((rows, columns), Decimal(0), dtype=object)


def is_positive(m: np.ndarray) -> bool:
    """Decide by Cholesky's elimination whether a symmetric matrix is positive definite."""
    a = m.copy()
    for k in range(len(a)):
        if a[k, k] <= 0:
            return False
        factors = a[k + 1 :, k] / a[k, k]
        a[k + 1 :, k + 1 :] -= np.outer(factors, a[k, k + 1 :])
    return True


def closed_loop(c: dict) -> dict[str, np.ndarray]:
    """Return the closed loop, rows x', zt, z, z_D and columns x, wt, w, and E of w_D."""
    p = {key: exact(rows) for key, rows in c["plant"].items()}
    k = {key: exact(rows) for key, rows in c["controller"].items()}
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

    errors = []
    for ball in c["errors"]:
        e, f, fu = exact(ball["E"]), exact(ball["F"]), exact(ball["Fu"])
        z = np.hstack([f, zeros(len(f), nk + r + rk + w)]) + fu @ u
        errors.append((np.vstack([e, zeros(nk, e.shape[1])]), z, Decimal(ball["lambda"])))
    return {
        "x": np.vstack([of_plant("A", "Bt", "B1", "B2"), of_controller("A", "Bt", "By")]),
        "t": np.vstack([of_plant("Ct", "Dtt", "Dt1", "Dt2"), of_controller("Ct", "Dtt", "Dty")]),
        "z": of_plant("C1", "D1t", "D11", "D12"),
        "sizes": (n + nk, r + rk, w),
        "errors": errors,
    }


def why_not(c: dict) -> str | None:
    """Return the first condition of docs/constant.md that does not hold, or None."""
    loop = closed_loop(c)
    n, r, w = loop["sizes"]
    blocks, more = c["blocks"], c["controller_blocks"]
    channels = [i for i, count in enumerate(blocks) for _ in range(count)]
    channels += [i for i, count in enumerate(more) for _ in range(count)]
    own = [(f, j) for f in c["filters"] for j, i in enumerate(channels) if i == f["parameter"]]
    k, wd = len(own), sum(e.shape[1] for e, _, _ in loop["errors"])
    at_wt = n + 2 * k
    at_d, at_w, width = at_wt + r, at_wt + r + wd, at_wt + r + wd + w

    def spread(m: np.ndarray) -> np.ndarray:
        parts = [m[:, :n], zeros(len(m), 2 * k), m[:, n : n + r], zeros(len(m), wd), m[:, n + r :]]
        return np.hstack(parts)

    def units(rows: int, start: int) -> np.ndarray:
        out = zeros(rows, width)
        for i in range(rows):
            out[i, start + i] = Decimal(1)
        return out

    zt = np.vstack([spread(loop["t"]), units(k, n)])
    wt = np.vstack([units(r, at_wt), units(k, n + k)])
    moved = spread(loop["x"])
    at = at_d
    for e, _, _ in loop["errors"]:
        moved[:, at : at + e.shape[1]] += e
        at += e.shape[1]
    rates = [moved]
    for source, start in ((zt, n), (wt, n + k)):
        for i, (f, j) in enumerate(own):
            row = source[j : j + 1].copy()
            row[0, start + i] -= Decimal(f["pole"])
            rates.append(row)
    x, s, t, lyapunov = (exact(c[key]) for key in ("X", "S", "T", "L"))
    all_channels = channels + [channels[j] for _, j in own]
    for name, m, sign in (("X", x, 1), ("S", s, 1), ("T", t, -1), ("L", lyapunov, 1)):
        if not (m == sign * m.T).all():
            return f"{name} is not its own transpose, but for the sign"
    for m in (s, t):
        for i, a in enumerate(all_channels):
            for j, b in enumerate(all_channels):
                if a != b and m[i, j] != 0:
                    return "S or T does not commute"
    a = loop["x"][:, :n]
    decay = lyapunov @ a
    if not is_positive(lyapunov) or not is_positive(-(decay + decay.T)):
        return "not stable at 0"
    if any(f["pole"] <= 0 for f in c["filters"]) or not is_positive(s):
        return "S or a pole"
    half = zeros(width, width)
    half[: n + 2 * k] = x @ np.vstack(rates)
    half = half + wt.T @ (t @ zt)
    main = half + half.T + zt.T @ (s @ zt) - wt.T @ (s @ wt)
    at = at_d
    for e, z, factor in loop["errors"]:
        into = spread(z)
        main = main + into.T @ into * factor
        main[range(at, at + e.shape[1]), range(at, at + e.shape[1])] -= factor
        at += e.shape[1]
        if factor <= 0:
            return "lambda"
    gamma = Decimal(c["gamma"])
    main[range(at_w, width), range(at_w, width)] -= gamma
    z = spread(loop["z"])
    main = main + z.T @ z / gamma
    return None if gamma > 0 and is_positive(-main) else "the main inequality"


@pytest.fixture(scope="module")
def certificate() -> dict:
    """Return the committed certificate of Squid's default design."""
    return json.loads(GOLDEN.read_text(encoding="utf-8"))


def test_independent_check_agrees(certificate: dict) -> None:
    """The conditions of docs/constant.md hold, and no longer once gamma is below what it can be."""
    with localcontext() as context:
        context.prec = DIGITS
        assert certificate["format"] == "lpv-constant-certificate/1"
        assert why_not(certificate) is None
        assert why_not(certificate | {"gamma": 0.8 * certificate["gamma"]}) == "the main inequality"


def test_frozen_loops_keep_the_gain(certificate: dict) -> None:
    """At corners of the box, with constant parameters, the loop is stable and its gain on a grid is below gamma."""
    with localcontext() as context:
        context.prec = DIGITS
        loop = closed_loop(certificate)
    n, r, _ = loop["sizes"]
    state, inner, output = (loop[key].astype(float) for key in ("x", "t", "z"))
    channels = np.repeat(np.arange(len(certificate["blocks"])), certificate["blocks"])
    more = certificate["controller_blocks"]
    channels = np.concatenate([channels, np.repeat(np.arange(len(more)), more)])
    random = np.random.default_rng(1)
    largest = 0.0
    for _ in range(40):
        theta = np.sign(random.standard_normal(len(certificate["blocks"])))[channels]
        closing = np.linalg.solve(np.eye(r) - theta[:, None] * inner[:, n : n + r], np.diag(theta))
        into = closing @ np.hstack([inner[:, :n], inner[:, n + r :]])
        moved = np.hstack([state[:, :n], state[:, n + r :]]) + state[:, n : n + r] @ into
        seen = np.hstack([output[:, :n], output[:, n + r :]]) + output[:, n : n + r] @ into
        assert np.linalg.eigvals(moved[:, :n]).real.max() < 0
        for omega in np.logspace(-4, 3, 60):
            response = seen[:, :n] @ np.linalg.solve(1j * omega * np.eye(n) - moved[:, :n], moved[:, n:])
            largest = max(largest, np.linalg.norm(response + seen[:, n:], 2))
    assert 0.5 * certificate["gamma"] < largest < certificate["gamma"]


def test_command_proves_and_refuses(certificate: dict, run_squid: Run, tmp_path: Path) -> None:
    """`squid verify` proves the certificate, refuses changed ones, and says what `--vehicle` cannot do."""
    done = run_squid("verify", GOLDEN)
    assert done.returncode == 0, done.stderr
    assert "every constant value of 13 more" in done.stdout
    for key in ("gamma", "plant"):
        changed = json.loads(json.dumps(certificate))
        if key == "gamma":
            changed["gamma"] *= 0.8
        else:
            changed["plant"]["A"][0][0] += 10.0
        path = tmp_path / f"{key}.json"
        path.write_text(json.dumps(changed), encoding="utf-8")
        done = run_squid("verify", path)
        assert done.returncode == 1 and "not proved" in done.stderr and "PROVED" not in done.stdout
    done = run_squid("verify", GOLDEN, "--vehicle", ROOT / "vehicles" / "squid")
    assert done.returncode != 0 and "--vehicle" in done.stderr
