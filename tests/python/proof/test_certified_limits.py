"""The claim with limits, from the certificate's file alone: checked independently in decimals, flown at its bound."""

from __future__ import annotations

import copy
import json
import shutil
from collections.abc import Callable
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import PITCHING, ROOT, SQUID, Run, masked, messages, refusal, with_rate
from decimals import DIGITS, closed_loop, exact, is_positive, zeros
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

EVERY_STATE = ROOT / "tests" / "certificates" / "squid_every_state.json"


def moving(c: dict) -> list[int]:
    """Return the states that controls, Delta or channels drive, and that channels, Delta or measurements observe."""
    p, ball = {k: np.array(m, float) for k, m in c["plant"].items()}, c["errors"][0]
    n, r = len(p["A"]), len(p["Ct"])

    def paths(links: np.ndarray) -> np.ndarray:
        linked = np.eye(len(links)) + (links != 0)
        return np.linalg.matrix_power(linked, len(links)) > 0

    into = np.hstack(
        [np.hstack([p["B2"], np.array(ball["E"])]).any(axis=1), p["Dt2"].reshape(r, -1).any(axis=1)]
    )
    moved = paths(np.block([[p["A"], p["Bt"].reshape(n, r)], [p["Ct"], p["Dtt"].reshape(r, r)]]))[:n, into]
    out = np.vstack([p["C2"], p["Ct"], np.array(ball["F"])]).any(axis=0)
    seen = paths(p["A"])[out]
    return [i for i in range(n) if moved[i].any() and seen[:, i].any()]


class Flow:
    """Rows x', zt, z_D and u of the loop, columns x, wt, phi, r; x and u relative to those under constant r; and E.

    The limited rates are among u, and their excess over the limits among phi.
    """

    def __init__(self, c: dict) -> None:
        claimed, p, k = claim(c, "limits"), c["plant"], c["controller"]
        loop = closed_loop(c, c["errors"])
        n0, nk, (all_, r, _) = len(p["A"]), len(k["A"]), loop.sizes
        kept = [*moving(c), *range(n0, n0 + nk)]
        limited = [kept.index(state) for state in claimed.get("rates", [])]
        every, self.n, self.r = len(claimed["limits"]), len(kept), r
        m = every - len(limited)
        step = all_ + r + claimed["input"]
        columns = [*kept, *range(all_, all_ + r), step]
        y0 = np.hstack(
            [exact(p["C2"]), zeros(len(p["C2"]), nk), exact(p["D2t"]), zeros(len(p["C2"]), len(k["Ct"]))]
        )
        u0 = np.hstack([zeros(m, n0), exact(k["Cu"]), zeros(m, len(p["Ct"])), exact(k["Dut"])])
        direct, d21 = exact(k["Duy"]), exact(p["D21"])[:, [claimed["input"]]]
        u = np.hstack([(u0 + direct @ y0)[:, columns[:-1]], direct @ d21])
        below = np.vstack([-exact(p["B2"]), exact(claimed["E"], m)])[kept]
        cut = [
            below,
            np.vstack([-exact(p["Dt2"]), zeros(len(k["Ct"]), m)]),
            -exact(c["errors"][0]["Fu"]),
            np.vstack([zeros(m, m), below[limited]]),
        ]
        rates = loop.x[kept][:, columns][limited]
        rows = [
            loop.x[kept][:, columns],
            loop.t[:, columns],
            loop.balls[0].z[:, columns],
            np.vstack([u, rates]),
        ]
        by_rate = np.where(np.arange(self.n)[:, None] == np.array(limited, int), Decimal(-1), Decimal(0))
        cut = [np.hstack([one, by_rate if one is below else zeros(len(one), len(limited))]) for one in cut]
        held = exact([claimed["x_held"]]).T
        for row in rows:
            row[:, -1:] = row[:, -1:] + row[:, : self.n] @ held
        rows[3][:, -1] -= exact([claimed["u_held"]])[0]
        self.rows = [
            np.hstack([row[:, :-1], phi, row[:, -1:] * Decimal(claimed["size"])])
            for row, phi in zip(rows, cut, strict=True)
        ]
        e = loop.balls[0].e[kept][:, : claimed.get("delta_rows")]
        self.e, self.m, self.held = e, every, held * Decimal(claimed["size"])


def form(c: dict, flow: Flow) -> np.ndarray:
    """Return the form of docs/certificate.md in x, wt, phi, w_D and r as a symmetric matrix."""
    claimed, (n, r, m, d) = claim(c, "limits"), (flow.n, flow.r, flow.m, flow.e.shape[1])
    x, s, t, h = (exact(claimed[key]) for key in ("X", "S", "T", "H"))
    moved, seen, error, u = (np.hstack([row[:, :-1], zeros(len(row), d), row[:, -1:]]) for row in flow.rows)
    moved[:, n + r + m : n + r + m + d] = flow.e
    unit = np.where(np.eye(n + r + m + d + 1) == 1, Decimal(1), Decimal(0))
    state, channel, phi, delta, step = np.split(unit, np.cumsum([n, r, m, d]))
    limits = np.diag([Decimal(number) for number in claimed["U"]])
    half = state.T @ x @ (moved + state * (Decimal(claimed["decay"]) / 2))
    half = half + channel.T @ t @ seen + 2 * phi.T @ limits @ (u - phi - h @ state)
    sizes = seen.T @ s @ seen - channel.T @ s @ channel
    ball = (error.T @ error - delta.T @ delta) * Decimal(claimed["lambda"])
    return (
        half + half.T + sizes + ball - step.T @ step * (Decimal(claimed["decay"]) * Decimal(claimed["beta"]))
    )


def why_not(c: dict) -> str | None:
    """Return the first condition of docs/certificate.md on limits that does not hold, or None."""
    claimed, flow = claim(c, "limits"), Flow(c)
    x, s, t, h = (exact(claimed[key]) for key in ("X", "S", "T", "H"))
    beta, size = Decimal(claimed["beta"]), Decimal(claimed["size"])
    numbers = [
        *(claimed[key] for key in ("size", "decay", "beta", "lambda")),
        *claimed["limits"],
        *claimed["U"],
    ]
    if min(numbers) <= 0:
        return "a sign"
    if not (
        (x == x.T).all() and (s == s.T).all() and (t == -t.T).all() and is_positive(x) and is_positive(s)
    ):
        return "X, S or T"
    if not is_positive(-form(c, flow)):
        return "the form"
    if (flow.held.T @ x @ flow.held)[0, 0] >= beta:
        return "the step"
    for limit, held, row in zip(
        map(Decimal, claimed["limits"]), map(Decimal, claimed["u_held"]), h, strict=True
    ):
        bordered = np.block([[x, row[:, None]], [row[None, :], np.array([[limit**2 / (4 * beta)]])]])
        if 2 * size * abs(held) > limit or not is_positive(bordered):
            return "a limit"
    return None


@pytest.fixture(scope="module", params=["everywhere", "region", "rate"])
def certificate(request: pytest.FixtureRequest, remus100: Packages, rate_limited: Packages) -> dict:
    """Return a certificate of Squid for all states, and those of REMUS 100, for a region."""
    of = {"region": remus100.folder, "rate": rate_limited.folder}
    path = EVERY_STATE if request.param == "everywhere" else of[request.param] / "certificate.json"
    found = json.loads(path.read_text(encoding="utf-8"))
    region = request.param != "everywhere"
    assert np.any(claim(found, "limits")["H"]) == np.any(claim(found, "limits")["x_held"]) == region
    assert len(claim(found, "limits").get("rates", [])) == (request.param == "rate")
    return found


def test_independent_check_agrees(certificate: dict) -> None:
    """All conditions of docs/certificate.md hold."""
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(certificate) is None


def times(key: str, factor: float) -> Callable[[dict], None]:
    """Return a function that multiplies all numbers of a key."""

    def change(claimed: dict) -> None:
        old = np.array(claimed[key], float) * factor
        claimed[key] = old.tolist()

    return change


@pytest.mark.parametrize(
    ("change", "within", "everywhere"),
    [
        (times("U", 1e-3), False, False),
        (times("U", -1.0), False, False),
        (times("H", 0.0), False, True),
        (times("H", 10.0), False, True),
        (times("beta", 1.5), False, True),
        (times("beta", 0.05), False, True),
        (times("beta", 1e-6), False, False),
        (times("X", -1.0), False, False),
        (lambda c: c["X"][0].__setitem__(1, c["X"][0][1] * 1.0001), False, False),
        (lambda c: c["X"][0].__setitem__(0, c["X"][0][0] * 0.5), False, False),
        (times("size", 1.1), False, True),
        (times("size", 10.0), False, False),
        (times("limits", 1.1), True, True),
        (times("limits", 0.5), False, True),
        (times("decay", 10.0), False, False),
        (times("E", -1.0), False, False),
        (times("lambda", 100.0), False, False),
        (times("S", 30.0), False, False),
    ],
)
def test_what_is_tampered_with_is_refused(
    certificate: dict,
    run_squid: Run,
    tmp_path: Path,
    change: Callable[[dict], None],
    within: bool,
    everywhere: bool,
) -> None:
    """Command and independent check agree on each change; limits do not matter if the claim covers every state."""
    holds = within if np.any(claim(certificate, "limits")["H"]) else everywhere
    changed = copy.deepcopy(certificate)
    change(claim(changed, "limits"))
    with localcontext() as context:
        context.prec = DIGITS
        found = why_not(changed)
    assert (found is None) == holds, found
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(changed), encoding="utf-8")
    done = run_squid("verify", path, "--json")
    assert (done.returncode == 0) == holds, (found, done.stderr)
    assert holds or refusal(done, "unproved")


def test_the_linear_model_flies_as_claimed(certificate: dict) -> None:
    """A step of the proved size, held and reversed; speed and model error maximise V' at each instant."""
    claimed, flow = claim(certificate, "limits"), Flow(certificate)
    n, r, m = flow.n, flow.r, flow.m
    moved, seen, error, u = (row.astype(float) for row in flow.rows)
    e, x, held = flow.e.astype(float), np.array(claimed["X"]), flow.held.astype(float)[:, 0]
    limits, h = np.array(claimed["limits"]), np.array(claimed["H"])
    commands = np.array(claimed["u_held"]) * claimed["size"]
    decay, beta = claimed["decay"], claimed["beta"]
    tables = []
    for theta in (-1.0, -0.5, 0.0, 0.5, 1.0):
        into = theta * np.linalg.solve(
            np.eye(r) - theta * seen[:, n : n + r], np.delete(seen, range(n, n + r), 1)
        )
        tables.append(
            [np.delete(rows, range(n, n + r), 1) + rows[:, n : n + r] @ into for rows in (moved, error, u)]
        )
    commands_alone = m - len(claimed.get("rates", []))
    assert all(np.abs(rows[:commands_alone, n : n + m]).max() == 0 for _, _, rows in tables), (
        "no command depends on phi at once"
    )
    assert all(np.abs(rows[:, n + commands_alone : n + m]).max(initial=0) == 0 for _, _, rows in tables)

    def worst(state: np.ndarray, step: float) -> tuple[float, np.ndarray, float]:
        """Return V' and x' for the worst speed and Delta, and the excess of a command over its limit there."""
        gradient, found = 2.0 * x @ state, (-np.inf, state, 0.0)
        for rates, errors, out in tables:
            known = np.concatenate([state, np.zeros(m), [step]])
            for _ in range(2):  # the rates depend on the excess of the commands
                asked = out @ known + commands * step
                known[n : n + m] = asked - np.clip(asked, -limits, limits)
            push = e.T @ gradient
            size = np.linalg.norm(errors @ known) / max(np.linalg.norm(push), 1e-300)
            moves = rates @ known + e @ push * size
            if gradient @ moves > found[0]:
                found = (gradient @ moves, moves, np.abs(known[n : n + m]).max())
        return found

    tick, beyond = 0.01, 0.0
    for step, start in ((1.0, -held), (-1.0, held)):
        state, level = start, 0.0
        for now, seconds in ((step, 10.0), (0.0, 30.0)):
            for _ in range(int(seconds / tick)):
                level = state @ x @ state
                slope, moves, over = worst(state, now)
                assert level < (beta if now else 4.0 * beta)
                assert slope < -decay * (level - beta * now * now)
                beyond = max(beyond, over)
                state = state + tick * moves
            if now:
                state = state + held * now
        assert level < 0.5 * beta, "it comes back"
    if not h.any():
        assert beyond > 0.1, "no command was at its limit"


def test_an_autopilot_with_another_gain_is_refused(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The claim is for the anti-windup in the file; the FMU must have it, and actuators with at least these limits."""

    def other_gain(controller: dict, _: dict) -> None:
        controller["anti_windup"][0][0] = 0.0

    def wider_limits(_: dict, certificate: dict) -> None:
        claim(certificate, "limits")["limits"] = [
            1.1 * limit for limit in claim(certificate, "limits")["limits"]
        ]

    for change in (other_gain, wider_limits):
        out = tmp_path / change.__name__
        out.mkdir()
        for path in squid.controller.parent.glob("*.json"):
            shutil.copy(path, out)
        files = [out / "controller.json", out / "certificate.json"]
        values = [json.loads(path.read_text(encoding="utf-8")) for path in files]
        change(*values)
        for path, value in zip(files, values, strict=True):
            path.write_text(json.dumps(value), encoding="utf-8")
        done = run_squid("package", SQUID, "--out", out, "--json")
        refusal(done, "uncertified")
        assert messages(done, TMP=tmp_path) == snapshot(name=change.__name__)


def test_limits_wider_than_those_of_the_vehicle_are_refused(
    remus100: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Size and limits scale with degree one, beta with two: a claim proved for wider limits is not this vehicle's."""
    certificate = json.loads((remus100.folder / "certificate.json").read_text(encoding="utf-8"))
    claimed = claim(certificate, "limits")
    claimed["size"] *= 8.0
    claimed["limits"] = [8.0 * limit for limit in claimed["limits"]]
    claimed["beta"] *= 64.0
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", path).returncode == 0
    done = run_squid("verify", path, "--vehicle", PITCHING, "--json")
    refusal(done, "wrong_plant")
    assert messages(done, TMP=tmp_path) == snapshot


def test_a_faster_rate_than_that_of_the_vehicle_is_refused(
    rate_limited: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A claim is for the vehicle with these rate limits, not with wider ones."""
    vehicle, out = with_rate(tmp_path / "remus100"), tmp_path / "out"
    out.mkdir()
    for path in rate_limited.folder.glob("*.json"):
        shutil.copy(path, out)
    certificate = json.loads((out / "certificate.json").read_text(encoding="utf-8"))
    claim(certificate, "limits")["limits"][-1] *= 1.1
    (out / "certificate.json").write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("verify", out / "certificate.json")
    proved = [line for line in done.stdout.splitlines() if line.startswith("PROVED: ")]
    assert done.returncode == 0 and masked("\n".join(proved)) == snapshot(name="proved")
    for key, words in (
        ("uncertified", ("package", vehicle, "--out", out)),
        ("wrong_plant", ("verify", out / "certificate.json", "--vehicle", vehicle)),
    ):
        done = run_squid(*words, "--json")
        refusal(done, key)
        assert messages(done, TMP=tmp_path) == snapshot(name=key)
