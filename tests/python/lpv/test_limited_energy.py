"""`squid lpv synth` with limits: the claims of bounded energy, checked independently in decimals, and flown."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from decimal import Decimal, localcontext
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from claims import claim
from conftest import Run
from decimals import DIGITS, Loop, closed_loop, exact, is_positive, zeros
from limited_plants import SPRING, TANKS, TWO_SPRINGS, UNSTABLE, f8

pytestmark = pytest.mark.change

Claim = dict

PROBLEMS = {"spring": SPRING, "two springs": TWO_SPRINGS, "unstable": UNSTABLE, "tanks": TANKS}


class Found(NamedTuple):
    """A problem, the report of the command on it, and its certificate."""

    problem: Path
    report: dict
    certificate: dict


@pytest.fixture(scope="module", params=PROBLEMS)
def found(request: pytest.FixtureRequest, run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Found:
    """Return what the command finds for each problem."""
    folder = tmp_path_factory.mktemp(request.param)
    problem = folder / f"{request.param}.json"
    problem.write_text(json.dumps({"data": PROBLEMS[request.param]}), encoding="utf-8")
    done = run_squid("lpv", "synth", problem, "--json", "--out", folder)
    assert done.returncode == 0, done.stdout
    return Found(
        problem, json.loads(done.stdout), json.loads((folder / "certificate.json").read_text("utf-8"))
    )


class Flow:
    """Rows x', zt, z and u of the loop, columns x, wt, phi, w."""

    def __init__(self, c: dict) -> None:
        p, k, claims = c["plant"], c["controller"], claim(c, "energy")
        loop: Loop = closed_loop(c, [])
        self.n, self.r, self.w = loop.sizes
        self.m = m = len(claims["limits"])
        ny, n0, nk = len(p["C2"]), len(p["A"]), len(k["A"])
        y = np.hstack([exact(p["C2"]), zeros(ny, nk), exact(p["D2t"], len(p["Ct"])), zeros(ny, len(k["Ct"]))])
        u = np.hstack([zeros(m, n0), exact(k["Cu"]), zeros(m, len(p["Ct"])), exact(k["Dut"], len(k["Ct"]))])
        u = np.hstack([u, zeros(m, self.w)]) + exact(k["Duy"]) @ np.hstack([y, exact(p["D21"])])
        b2, dt2 = exact(p["B2"]), exact(p["Dt2"], m)
        cut = [
            np.vstack([-b2, exact(claims["E"], m)]),
            np.vstack([-dt2, zeros(len(k["Ct"]), m)]),
            -exact(p["D12"]),
            zeros(m, m),
        ]
        at = self.n + self.r
        self.rows = [
            np.hstack([row[:, :at], phi, row[:, at:]])
            for row, phi in zip([loop.x, loop.t, loop.z, u], cut, strict=True)
        ]


def why_not(c: dict, bound: Claim) -> str | None:
    """Return the first condition of docs/certificate.md on a claim of bounded energy that does not hold, or None."""
    flow, limits = Flow(c), [Decimal(limit) for limit in claim(c, "energy")["limits"]]
    x, h = exact(bound["X"]), exact(bound["H"])
    s, t = (exact(bound[key], flow.r) for key in ("S", "T"))
    gamma, beta = Decimal(bound["gamma"]), Decimal(bound["beta"])
    if min(gamma, beta, *limits, *bound["U"]) <= 0:
        return "a sign"
    if not (
        (x == x.T).all() and (s == s.T).all() and (t == -t.T).all() and is_positive(x) and is_positive(s)
    ):
        return "X, S or T"
    moved, seen, z, u = flow.rows
    sizes = [flow.n, flow.r, flow.m, flow.w]
    unit = np.where(np.eye(sum(sizes)) == 1, Decimal(1), Decimal(0))
    state, channel, phi, w = np.split(unit, np.cumsum(sizes)[:-1])
    multiplier = np.where(np.eye(flow.m) == 1, np.array([Decimal(v) for v in bound["U"]]), Decimal(0))
    half = state.T @ x @ moved + channel.T @ t @ seen + 2 * phi.T @ multiplier @ (u - phi - h @ state)
    form = half + half.T + seen.T @ s @ seen - channel.T @ s @ channel + z.T @ z / gamma - gamma * w.T @ w
    if not is_positive(-form):
        return "the form"
    for limit, row in zip(limits, h, strict=True):
        bordered = np.block([[x, row[:, None]], [row[None, :], np.array([[limit**2 / (gamma * beta)]])]])
        if not is_positive(bordered):
            return "a limit"
    return None


def test_independent_check_agrees(run_squid: Run, found: Found) -> None:
    """All conditions hold; the report has the claims, in order, and `check` and `verify` prove them."""
    claims = claim(found.certificate, "energy")["bounds"]
    with localcontext() as context:
        context.prec = DIGITS
        assert [why_not(found.certificate, bound) for bound in claims] == [None] * len(claims)
    told = [(bound["gamma"], bound["beta"] if np.any(bound["H"]) else None) for bound in claims]
    assert [(one["gamma"], one["energy"]) for one in found.report["with_limits"]] == told
    bounded = [beta for _, beta in told if beta is not None]
    assert len(bounded) > 1 and bounded == sorted(bounded) and told == sorted(told, key=lambda one: one[0])
    assert told[0][0] > found.report["certified_gamma"]
    # A plant that is stable for every trajectory of its parameters allows a claim about every w, no other does.
    assert (told[-1][1] is None) == (found.problem.stem == "tanks")
    path = found.problem.with_name("certificate.json")
    for words in (("lpv", "check", found.problem, path), ("verify", path, "--verbose")):
        done = run_squid(*words)
        assert done.returncode == 0 and "With commands saturated at the limits in the file" in done.stdout
    controller = json.loads(found.problem.with_name("controller.json").read_text("utf-8"))
    assert controller["anti_windup"] == claim(found.certificate, "energy")["E"]
    assert controller["limits"] == claim(found.certificate, "energy")["limits"]


def times(key: str, factor: float) -> Callable[[dict, Claim], None]:
    """Return a change of all numbers of a key of a claim."""

    def change(_: dict, bound: Claim) -> None:
        bound[key] = (np.array(bound[key], float) * factor).tolist()

    return change


@pytest.mark.parametrize(
    "change",
    [
        times("U", 1e-3),
        times("U", 1e3),
        times("U", -1.0),
        times("H", 0.0),
        times("H", 10.0),
        times("beta", 1.2),
        times("beta", -1.0),
        times("gamma", 0.7),
        times("X", -1.0),
        times("X", 0.9),
        lambda _, bound: bound["X"][0].__setitem__(1, bound["X"][0][1] * 1.0001 + 1e-9),
        lambda _, bound: bound["X"][0].__setitem__(0, bound["X"][0][0] * 0.5),
        lambda c, _: claim(c, "energy")["limits"].__setitem__(0, 0.8 * claim(c, "energy")["limits"][0]),
        lambda c, _: claim(c, "energy").update(E=(-10.0 * np.array(claim(c, "energy")["E"])).tolist()),
    ],
)
def test_what_is_tampered_with_is_refused(
    found: Found, run_squid: Run, tmp_path: Path, change: Callable[[dict, Claim], None]
) -> None:
    """The command and the independent check agree on each change of the claim of the largest bounded energy."""
    changed = copy.deepcopy(found.certificate)
    bounded = [bound for bound in claim(changed, "energy")["bounds"] if np.any(bound["H"])]
    claim(changed, "energy")["bounds"] = bounded[-1:]
    change(changed, bounded[-1])
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(changed, bounded[-1]) is not None
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(changed), encoding="utf-8")
    done = run_squid("verify", path)
    assert done.returncode == 1 and "bound 0 of bounded energy is not proved" in done.stderr, done.stderr


def test_the_loop_flies_as_claimed(found: Found) -> None:
    """Pulses of the claimed energy, parameters that jump: V below gamma times the energy, z as small as claimed."""
    c, flow = found.certificate, Flow(found.certificate)
    n, r, m = flow.n, flow.r, flow.m
    limits = np.array(claim(c, "energy")["limits"])
    moved, seen, z, u = (row.astype(float) for row in flow.rows)
    tables = []
    for theta in (-1.0, 1.0):
        into = theta * np.linalg.solve(
            np.eye(r) - theta * seen[:, n : n + r], np.delete(seen, range(n, n + r), 1)
        )
        tables.append(
            [np.delete(row, range(n, n + r), 1) + row[:, n : n + r] @ into for row in (moved, z, u)]
        )
    assert all(np.abs(out[:, n : n + m]).max() == 0.0 for _, _, out in tables), (
        "no command depends on phi at once"
    )
    slowest = -np.linalg.eigvals(np.hstack([tables[0][0][:, :n]])).real.max()
    beyond = 0.0
    for bound in claim(c, "energy")["bounds"]:
        x, gamma = np.array(bound["X"]), bound["gamma"]
        beta = bound["beta"] if np.any(bound["H"]) else 1e4 * claim(c, "energy")["bounds"][0]["beta"]
        for direction in range(flow.w):
            for seconds in (0.05, 1.0, 10.0):
                tick = min(0.01, seconds / 20.0)
                pulse = np.zeros(flow.w)
                pulse[direction] = np.sqrt(0.999 * beta / seconds)
                state, energy, spent = np.zeros(n), 0.0, 0.0
                for k in range(int((seconds + min(5.0 / slowest, 10.0)) / tick)):
                    w = pulse if k * tick < seconds - 0.5 * tick else np.zeros(flow.w)
                    rates, outputs, out = tables[int(k * tick / 0.7) % 2]

                    def at(point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
                        known = np.concatenate([point, np.zeros(m), w])  # noqa: B023
                        asked = out @ known  # noqa: B023
                        known[n : n + m] = asked - np.clip(asked, -limits, limits)
                        return known, rates @ known  # noqa: B023

                    first, slope = at(state)
                    middle, slope = at(state + 0.5 * tick * slope)
                    beyond = max(beyond, np.abs(first[n : n + m]).max())
                    state = state + tick * slope
                    energy += tick * float(np.sum((outputs @ middle) ** 2))
                    spent += tick * float(w @ w)
                    assert state @ x @ state < gamma * spent
                assert spent < beta and energy < gamma**2 * spent
    assert beyond > 0.1, "no command was at its limit"


def test_the_f8_recovers(run_squid: Run, tmp_path: Path) -> None:
    """The step of AWtools' demonstration, 10 in both outputs: anti-windup regains a third of what limits cost."""
    problem, data = tmp_path / "f8.json", f8()
    problem.write_text(json.dumps({"data": data}), encoding="utf-8")
    done = run_squid("lpv", "synth", problem, "--json", "--out", tmp_path)
    assert done.returncode == 0 and len(json.loads(done.stdout)["with_limits"]) == 3, done.stdout
    certificate = json.loads((tmp_path / "certificate.json").read_text("utf-8"))
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(certificate, claim(certificate, "energy")["bounds"][0]) is None
    a, b1, b2, c2, d21 = (np.array(data[key], float) for key in ("A", "B1", "B2", "C2", "D21"))
    k = {key: np.array(value, float) for key, value in certificate["controller"].items()}
    step = np.array([10.0, 10.0])

    def error(limit: float, gain: np.ndarray) -> float:
        """Return the integral of the squared error over 9 s."""
        x, xk, tick, total = np.zeros(len(a)), np.zeros(len(k["A"])), 5e-4, 0.0

        def at(x: np.ndarray, xk: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            y = c2 @ x + d21 @ step
            u = k["Cu"] @ xk + k["Duy"] @ y
            sat = np.clip(u, -limit, limit)
            return a @ x + b1 @ step + b2 @ sat, k["A"] @ xk + k["By"] @ y + gain @ (u - sat), y

        for _ in range(int(9.0 / tick)):
            first, second, _ = at(x, xk)
            first, second, y = at(x + 0.5 * tick * first, xk + 0.5 * tick * second)
            x, xk, total = x + tick * first, xk + tick * second, total + tick * float(y @ y)
        return total

    gain = np.array(claim(certificate, "energy")["E"])
    free, none, recovered = error(np.inf, gain), error(15.0, 0.0 * gain), error(15.0, gain)
    assert free < recovered and none - recovered > (none - free) / 3.0, (free, recovered, none)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_energies_grow_with_the_square_of_limits(run_squid: Run, tmp_path: Path, factor: float) -> None:
    """Limits, w and all else in other units are the same loop, also where it has parameters."""
    energies = []
    for limit in (1.0, factor):
        problem = tmp_path / "p.json"
        problem.write_text(json.dumps({"data": SPRING | {"limits": [limit]}}), encoding="utf-8")
        report = json.loads(run_squid("lpv", "synth", problem, "--json").stdout)
        energies.append([one["energy"] / limit**2 for one in report["with_limits"]])
    assert energies[1] == pytest.approx(energies[0], rel=0.02) and len(energies[0]) == 3


def test_check_compares_limits(found: Found, run_squid: Run, tmp_path: Path) -> None:
    """A claim is about its limits and wider ones; one without any is of the plant, and says nothing of limits."""
    certificate = found.problem.with_name("certificate.json")
    data = json.loads(found.problem.read_text("utf-8"))["data"]

    def check(limits: list[float], path: Path) -> tuple[int, str]:
        problem = tmp_path / "p.json"
        problem.write_text(json.dumps({"data": data | {"limits": limits}}), encoding="utf-8")
        done = run_squid("lpv", "check", problem, path)
        return done.returncode, done.stderr

    assert check([2.0 * limit for limit in data["limits"]], certificate)[0] == 0
    code, words = check([0.9 * limit for limit in data["limits"]], certificate)
    assert code == 1 and "limits" in words, words
    claims = [one for one in found.certificate["claims"] if "energy" not in one]
    without = found.certificate | {"claims": claims}
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(without), encoding="utf-8")
    assert check(data["limits"], path)[0] == 0
    assert "limits" not in run_squid("verify", path).stdout


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"limits": [-1.0]},
            "'limits' has the number -1 in place 1; it must be a list of 1 numbers from 1e-9",
        ),
        ({"limits": [0.0]}, "'limits' has the number 0 in place 1"),
        ({"limits": [1.0, 1.0]}, "'limits' has 2 entries; it must be a list of 1 numbers"),
        ({"limits": 1.0}, "'data.limits': invalid type: floating point `1.0`, expected a list"),
        ({"limits": ["wide"]}, "'data.limits[0]': invalid type: string \"wide\", expected a number"),
        ({"dt": 0.1}, "'dt' is given beside 'limits', which are of continuous time; leave one of them out"),
    ],
)
def test_bad_limits_are_told(run_squid: Run, tmp_path: Path, change: dict, words: str) -> None:
    """One sentence with file and key."""
    problem = tmp_path / "p.json"
    problem.write_text(json.dumps({"data": SPRING | change}), encoding="utf-8")
    done = run_squid("lpv", "synth", problem)
    assert done.returncode == 1 and "p.json:" in done.stderr and words in done.stderr, done.stderr


def test_limits_do_not_go_with_a_direct_path(run_squid: Run, tmp_path: Path) -> None:
    """The sentence says what to do."""
    problem = tmp_path / "p.json"
    data = copy.deepcopy(SPRING)
    data["P"]["D22"] = [[0.5]]
    problem.write_text(json.dumps({"data": data}), encoding="utf-8")
    done = run_squid("lpv", "synth", problem)
    assert done.returncode == 1 and "'limits' is given beside a direct path 'D22'" in done.stderr, done.stderr
