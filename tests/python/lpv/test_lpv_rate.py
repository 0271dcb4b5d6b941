"""`squid lpv synth` with `rate`: a parameter that changes at a bounded rate."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from claims import claim
from conftest import Run, kinds, masked, messages, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused, synth

pytestmark = pytest.mark.change

CASES = ROOT / "tests" / "cases"
GOLDEN = ROOT / "tests" / "certificates" / "remus100_bounded_rate.json"


def commutator(rate: float) -> dict:
    """Return `theta G - G theta`, G = 1/(s + 1), from w1 to z1, and a control that only adds cost: z2 = u, y = w2."""
    zero = [[0.0, 0.0], [0.0, 0.0]]
    p = {"A": [[-1, 0], [0, -1]], "B1": [[1, 0], [0, 0]], "C1": [[0, -1], [0, 0]], "D1t": [[0, 1], [0, 0]]}
    p |= {"Bt": [[0, 0], [1, 0]], "Ct": [[0, 0], [1, 0]], "Dt1": [[1, 0], [0, 0]], "Dtt": zero, "D11": zero}
    p |= {
        "B2": [[0], [0]],
        "Dt2": [[0], [0]],
        "D12": [[0], [1]],
        "C2": [[0, 0]],
        "D2t": [[0, 0]],
        "D21": [[0, 1]],
    }
    return {"data": {"P": p, "blocks": [2], "rate": rate}}


@pytest.fixture
def remus() -> dict:
    """Return the problem of REMUS 100 with tracking errors only, at 0.5 m/s^2."""
    file = json.loads(GOLDEN.read_text(encoding="utf-8"))
    return {"data": {"P": file["plant"], "blocks": file["blocks"], "rate": 1.25}}


QUADRATIC = 0.02
"""How far a quadratic X may be above the published one of order 3, at the rates below."""
TIGHTENED = 0.02
"""How far the proved bound may be above the least of its Lyapunov matrix: the search's accuracy, the proof's room."""


@pytest.mark.parametrize("place", [1, 2, 3], ids=["0.1", "0.2", "1"])
def test_the_published_gain_of_the_commutator(run_squid: Run, tmp_path: Path, place: int) -> None:
    """The control cannot help: the least gamma is the published gain, and the proved bound is just above it."""
    expected = json.loads((CASES / "lpv08_delta_commutator.json").read_text(encoding="utf-8"))["expected"]
    rate, gamma = expected["rate"][place], expected["gamma_rate_poly3"][place]
    code, report, _ = synth(run_squid, tmp_path / "p.json", commutator(rate), "--out", str(tmp_path))
    assert (code, report["status"], report["rate"]) == (0, "feasible", rate)
    least, proved = report["gamma"], report["certified_gamma_at_rate"]
    assert gamma * (1 - expected["rate_rtol"]) <= least <= gamma * (1 + QUADRATIC)
    assert gamma * (1 - expected["rate_rtol"]) <= proved <= gamma * (1 + QUADRATIC + TIGHTENED)
    assert proved < 0.75 * report["certified_gamma"]
    certificate = json.loads((tmp_path / "certificate.json").read_text(encoding="utf-8"))
    assert claim(certificate, "rate")["rate"] == rate and claim(certificate, "rate")["gamma"] == proved
    done = run_squid("verify", tmp_path / "certificate.json", "--verbose")
    assert done.returncode == 0 and f" {rate:g} " in done.stdout and f" {proved}" in done.stdout
    done = run_squid("verify", tmp_path / "certificate.json", "--json")
    assert json.loads(done.stdout)["gamma_at_rate"] == proved


def test_a_bound_at_the_rate_alone_is_feasible(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """An oscillator without a bound for arbitrary rates, and a control that only adds cost."""
    case = json.loads((CASES / "lpv11_shamma_athans.json").read_text(encoding="utf-8"))
    rate, gamma = case["expected"]["rate"][2], case["expected"]["gamma"][2]
    p = case["data"]["P"] | {
        "B1": [[0, 0], [1, 0]],
        "B2": [[0], [0]],
        "C1": [[1, 0], [0, 0]],
        "C2": [[0, 0]],
        "Dt1": [[0, 0]],
        "Dt2": [[0]],
        "D1t": [[0], [0]],
        "D2t": [[0]],
        "D11": [[0, 0], [0, 0]],
        "D12": [[0], [1]],
        "D21": [[0, 1]],
    }
    problem = {"data": {"P": p, "blocks": [1], "rate": rate}}
    code, report, _ = synth(run_squid, tmp_path / "p.json", problem, "--out", str(tmp_path))
    assert (code, report["status"], report["certified_gamma"]) == (0, "feasible", None)
    assert gamma < report["certified_gamma_at_rate"] < (1 + QUADRATIC + TIGHTENED) * gamma
    assert kinds(report) == ["for_this_rate_only"]
    certificate = json.loads((tmp_path / "certificate.json").read_text(encoding="utf-8"))
    assert [list(one) for one in certificate["claims"]] == [["rate"]]
    done = run_squid("verify", tmp_path / "certificate.json", "--verbose")
    assert done.returncode == 0 and masked(named(done.stdout, TMP=tmp_path)) == snapshot(name="theorem")


def test_a_bounded_rate_pays(
    run_squid: Run, tmp_path: Path, remus: dict, snapshot: SnapshotAssertion
) -> None:
    """The gain is smaller than for arbitrary trajectories; text and check state the rate."""
    done = run_squid("lpv", "synth", GOLDEN, "--json")
    fast = json.loads(done.stdout)
    path = tmp_path / "p.json"
    path.write_text(json.dumps(remus), encoding="utf-8")
    done = run_squid("lpv", "synth", path, "--out", tmp_path)
    assert done.returncode == 0 and "|theta'| <= 1.25" in done.stdout
    assert masked(done.stdout) == snapshot(name="report")
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    for words, key in (("at rate  ", "certified_gamma_at_rate"), ("gamma    ", "certified_gamma")):
        said = float(done.stdout.partition(f"certified {words}")[2].split()[0])
        assert report[key] <= said < (1.0 + 1e-5) * report[key], "rounded up"
    assert report["gamma"] < 0.8 * fast["gamma"] and "rate" not in fast
    assert report["certified_gamma_at_rate"] < 0.9 * fast["certified_gamma"]
    assert (
        report["gamma_design"] == pytest.approx(1.1 * report["gamma"], rel=1e-6) and report["findings"] == []
    )
    certificate = tmp_path / "certificate.json"
    assert run_squid("lpv", "check", path, certificate).returncode == 0
    remus["data"]["rate"] = 1.26
    path.write_text(json.dumps(remus), encoding="utf-8")
    done = run_squid("lpv", "check", path, certificate)
    assert done.returncode == 1 and messages(done) == snapshot(name="faster")


@pytest.mark.parametrize(
    ("spoil", "line", "key"),
    [
        ({"rate": -1.0}, None, "rate"),
        ({"rate": "fast"}, 1, "data.rate"),
        ({"rate": None}, 1, "data.rate"),
        ({"rate": 1e7}, None, "rate"),
        ({"blocks": [1, 1]}, None, "rate"),
    ],
)
def test_wrong_rates(
    run_squid: Run,
    tmp_path: Path,
    spoil: dict,
    line: int | None,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """A value that is not a rate of one parameter is refused in one sentence."""
    problem = commutator(0.2)
    problem["data"] |= spoil
    code, report, error = synth(run_squid, tmp_path / "p.json", problem)
    assert refused(code, report, error) == (line, key)
    assert named(error, TMP=tmp_path) == snapshot


def test_what_goes_with_no_rate(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Feedthrough and options unsupported by the synthesis for a bounded rate are refused, not ignored."""
    problem, errors = commutator(0.2), []
    for options in (["--reduce"], ["--gamma-limit", "2"], ["--fastest-mode", "9"], []):
        if not options:
            problem["data"]["P"]["D22"] = [[0.5]]
        code, report, error = synth(run_squid, tmp_path / "p.json", problem, *options)
        assert refused(code, report, error) == (None, "rate")
        errors.append(named(error, TMP=tmp_path))
    assert errors == snapshot


def test_no_controller_at_any_rate(run_squid: Run, tmp_path: Path) -> None:
    """A mode that is uncontrollable at a constant parameter proves that there is no controller."""
    problem = commutator(0.2)
    problem["data"]["P"]["A"][0][0] = 1.0
    code, report, _ = synth(run_squid, tmp_path / "p.json", problem)
    assert (code, report["status"]) == (2, "infeasible") and "1.0000" in report["reason"]
