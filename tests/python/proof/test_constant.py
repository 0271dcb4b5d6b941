"""The certificate for constant coefficients, checked independently in decimals of 120 digits."""

from __future__ import annotations

import copy
import json
import re
import shutil
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import SQUID, Run, designed, masked, refusal
from decimals import DIGITS, closed_loop, exact, is_positive, zeros
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

MAIN = "the main inequality"
GOLDEN = ROOT / "tests" / "certificates" / "constant_squid.json"


def why_not(c: dict) -> str | None:
    """Return the first condition of docs/constant.md that does not hold, or None."""
    loop, claimed = closed_loop(c, c["errors"]), claim(c, "constant")
    n, r, w = loop.sizes
    blocks, more = c["blocks"], c["controller_blocks"]
    channels = [i for i, count in enumerate(blocks) for _ in range(count)]
    channels += [i for i, count in enumerate(more) for _ in range(count)]
    own = [(f, j) for f in claimed["filters"] for j, i in enumerate(channels) if i == f["parameter"]]
    k, wd = len(own), sum(ball.e.shape[1] for ball in loop.balls)
    moving = [i for i, (f, _) in enumerate(own) if f.get("rate", 0) > 0]
    at_wt = n + 2 * k
    at_v = at_wt + r
    at_d = at_v + len(moving)
    at_w, width = at_d + wd, at_d + wd + w

    def spread(m: np.ndarray) -> np.ndarray:
        between = zeros(len(m), len(moving) + wd)
        parts = [m[:, :n], zeros(len(m), 2 * k), m[:, n : n + r], between, m[:, n + r :]]
        return np.hstack(parts)

    def units(rows: int, start: int) -> np.ndarray:
        out = zeros(rows, width)
        for i in range(rows):
            out[i, start + i] = Decimal(1)
        return out

    slowed = zeros(len(moving), width)
    for row, i in enumerate(moving):
        slowed[row, n + i] = Decimal(own[i][0]["rate"])
    zt = np.vstack([spread(loop.t), units(k, n), slowed])
    wt = np.vstack([units(r, at_wt), units(k, n + k), units(len(moving), at_v)])
    moved = spread(loop.x)
    at = at_d
    for e, _ in loop.balls:
        moved[:, at : at + e.shape[1]] += e
        at += e.shape[1]
    rates = [moved]
    for source, start in ((zt, n), (wt, n + k)):
        for i, (f, j) in enumerate(own):
            row = source[j : j + 1].copy()
            row[0, start + i] -= Decimal(f["pole"])
            if source is wt and i in moving:
                row[0, at_v + moving.index(i)] += Decimal(1)
            rates.append(row)
    x, s, t, lyapunov = (exact(claimed[key]) for key in ("X", "S", "T", "L"))
    all_channels = channels + [channels[j] for _, j in own]
    all_channels += [max(len(blocks), len(more)) + own[i][0]["parameter"] for i in moving]
    for name, m, sign in (("X", x, 1), ("S", s, 1), ("T", t, -1), ("L", lyapunov, 1)):
        if not (m == sign * m.T).all():
            return f"{name} is not its own transpose, but for the sign"
    for m in (s, t):
        for i, a in enumerate(all_channels):
            for j, b in enumerate(all_channels):
                if a != b and m[i, j] != 0:
                    return "S or T does not commute"
    a = loop.x[:, :n]
    decay = lyapunov @ a
    if not is_positive(lyapunov) or not is_positive(-(decay + decay.T)):
        return "not stable at 0"
    if any(f["pole"] <= 0 or f.get("rate", 0) < 0 for f in claimed["filters"]) or not is_positive(s):
        return "S or a pole"
    half = zeros(width, width)
    half[: n + 2 * k] = x @ np.vstack(rates)
    half = half + wt.T @ (t @ zt)
    main = half + half.T + zt.T @ (s @ zt) - wt.T @ (s @ wt)
    at = at_d
    for (e, z), factor in zip(loop.balls, map(Decimal, claimed["lambdas"]), strict=True):
        into = spread(z)
        main = main + into.T @ into * factor
        main[range(at, at + e.shape[1]), range(at, at + e.shape[1])] -= factor
        at += e.shape[1]
        if factor <= 0:
            return "lambda"
    gamma = Decimal(claimed["gamma"])
    main[range(at_w, width), range(at_w, width)] -= gamma
    z = spread(loop.z)
    main = main + z.T @ z / gamma
    return None if gamma > 0 and is_positive(-main) else MAIN


@pytest.fixture(scope="module")
def certificate() -> dict:
    """Return the committed certificate of Squid's default design."""
    return json.loads(GOLDEN.read_text(encoding="utf-8"))


def test_independent_check_agrees(certificate: dict) -> None:
    """The conditions of docs/constant.md hold, and fail if gamma is too small."""
    with localcontext() as context:
        context.prec = DIGITS
        assert certificate["format"] == "lpv-certificate/1"
        assert why_not(certificate) is None
        lower = copy.deepcopy(certificate)
        claim(lower, "constant")["gamma"] *= 0.8
        assert why_not(lower) == MAIN


def test_frozen_loops_keep_the_gain(certificate: dict) -> None:
    """At corners of the box, with constant parameters, the loop is stable and its gain on a grid is below gamma."""
    with localcontext() as context:
        context.prec = DIGITS
        loop = closed_loop(certificate, certificate["errors"])
    n, r, _ = loop.sizes
    state, inner, output = (m.astype(float) for m in (loop.x, loop.t, loop.z))
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
    gamma = claim(certificate, "constant")["gamma"]
    assert 0.5 * gamma < largest < gamma


def first_order(rate: float) -> dict:
    """Return an explicit certificate for x' = (delta/2 - 1) x + w, z = x, with a rate limit of delta."""
    one, zero = [[1.0]], [[0.0]]
    zeroed = dict.fromkeys(("Dtt", "Dt1", "Dt2", "D1t", "D11", "D12", "D2t", "D21"), zero)
    ports = {"A": zero, "Bt": [[0.5]], "B1": one, "B2": one, "Ct": one, "C1": one, "C2": one}
    gain = {
        "A": [],
        "By": [],
        "Bt": [],
        "Cu": [[]],
        "Duy": [[-1.0]],
        "Dut": [[]],
        "Ct": [],
        "Dty": [],
        "Dtt": [],
    }
    claimed = {
        "gamma": 2.5,
        "X": np.diag([1.0, 0.05, 0.05]).tolist(),
        "S": np.diag([0.5, 0.02, 0.05]).tolist(),
        "T": np.zeros((3, 3)).tolist(),
        "L": one,
        "filters": [{"parameter": 0, "pole": 1.0, "rate": rate}],
        "lambdas": [],
    }
    return {
        "format": "lpv-certificate/1",
        "blocks": [1],
        "controller_blocks": [],
        "plant": ports | zeroed,
        "controller": gain,
        "errors": [],
        "claims": [{"constant": claimed}],
    }


@pytest.mark.parametrize(("rate", "reason"), [(0.5, None), (2.0, MAIN)])
def test_a_bounded_rate(
    rate: float, reason: str | None, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Independent check and `squid verify` agree on a slow parameter, and on one that is too fast."""
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(first_order(rate)) == reason
    path = tmp_path / "slow.json"
    path.write_text(json.dumps(first_order(rate)), encoding="utf-8")
    done = run_squid("verify", path)
    assert done.returncode == (0 if reason is None else 1), done.stderr
    assert reason or (" 0.5 " in done.stdout and masked(done.stdout) == snapshot)


def test_command_proves_and_refuses(
    certificate: dict, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """`squid verify` proves the certificate and refuses changed ones."""
    done = run_squid("verify", GOLDEN)
    assert done.returncode == 0 and masked(done.stdout) == snapshot
    for key in ("gamma", "plant"):
        changed = json.loads(json.dumps(certificate))
        if key == "gamma":
            claim(changed, "constant")["gamma"] *= 0.8
        else:
            changed["plant"]["A"][0][0] += 10.0
        path = tmp_path / f"{key}.json"
        path.write_text(json.dumps(changed), encoding="utf-8")
        done = run_squid("verify", path, "--json")
        refusal(done, "unproved")


@pytest.mark.night
def test_certificate_is_of_its_vehicle(run_squid: Run, tmp_path: Path) -> None:
    """`squid verify --vehicle` accepts the result of `squid design --constant`, but no other plant or smaller ball."""
    made = designed(run_squid, SQUID, "--constant")
    printed = (made / "design.txt").read_text(encoding="utf-8")
    (share,) = re.findall(r"([\d.]+) % of their declared ranges", printed)
    path = Path(shutil.copy(made / "constant_certificate.json", tmp_path))
    done = run_squid("verify", path, "--vehicle", SQUID, "--json")
    assert done.returncode == 0, done.stderr
    assert 100.0 * json.loads(done.stdout)["share"] == pytest.approx(float(share), abs=0.06)
    fresh = path.read_text(encoding="utf-8")
    changed, shrunk = json.loads(fresh), json.loads(fresh)
    changed["plant"]["A"][0][0] *= 1.0 + 1e-6
    shrunk["errors"][0]["F"] = [[0.9 * entry for entry in row] for row in shrunk["errors"][0]["F"]]
    for altered, what in ((changed, " A "), (shrunk, "ball")):
        path.write_text(json.dumps(altered), encoding="utf-8")
        assert run_squid("verify", path).returncode == 0, "both are still proved of the plant in the file"
        done = run_squid("verify", path, "--vehicle", SQUID, "--json")
        assert what in refusal(done, "wrong_plant")["reason"]
