"""`squid lpv gain`: the gain of a closed loop, with its certificate."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import Run, masked, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused

pytestmark = pytest.mark.change

CASES = {
    name: json.loads((ROOT / "tests" / "cases" / f"{name}.json").read_text(encoding="utf-8"))
    for name in ("lpv11_shamma_athans", "lpv12_gas_turbine")
}
"""Loops with published gains at bounded rates; the first has none for a parameter that moves however fast."""

RATES = [
    (name, rate, gamma)
    for name, case in CASES.items()
    for rate, gamma in zip(case["expected"]["rate"], case["expected"]["gamma"], strict=True)
]

PLANT = {"A": [[-2.0, -3.0], [1.0, 1.0]], "B1": [[1.0], [0.0]], "C1": [[1.0, 0.0]], "D11": [[0.0]]}


def demo(size: float) -> dict:
    """Return the plant of IQClab's Demo_001: one parameter, repeated twice, |delta| <= size."""
    channels = {
        "Bt": [[size, 0.0], [0.0, 0.0]],
        "Ct": [[1.0, 0.0], [0.0, 0.0]],
        "Dtt": [[size, -2.0 * size], [size, -size]],
        "Dt1": [[0.0], [1.0]],
        "D1t": [[0.0, size]],
    }
    return {"data": {"P": PLANT | channels, "blocks": [2]}}


def written(folder: Path, problem: dict) -> Path:
    """Write a problem file."""
    path = folder / "problem.json"
    path.write_text(json.dumps(problem), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("size", "jumping", "constant"),
    [(0.1, 1.806857, 1.6171701), (0.3, 2.683535, 2.00650064), (0.5, 4.48476, 2.4546307)],
)
def test_published_gains(
    run_squid: Run, tmp_path: Path, size: float, jumping: float, constant: float
) -> None:
    """The least bound is matched to 1e-4 from above; the worst constant parameter is found with tight bounds."""
    path = written(tmp_path, demo(size))
    done = run_squid("lpv", "gain", path, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "proved"
    assert jumping * (1.0 - 1e-6) <= found["gamma"] <= jumping * (1.0 + 1e-4)
    assert jumping < found["proved"] < 1.002 * jumping
    assert found["constant_lower"] == pytest.approx(constant, rel=1e-6)
    assert constant <= found["constant_upper"] < 1.001 * constant
    assert [abs(theta) for theta in found["constant_theta"]] == [1.0]
    checked = run_squid("verify", tmp_path / "certificate.json", "--json")
    assert checked.returncode == 0, checked.stderr
    certificate = json.loads((tmp_path / "certificate.json").read_text("utf-8"))
    assert len(claim(certificate, "gain")["X"]) == len(PLANT["A"]), "of the loop alone"


def test_a_bounded_rate_lies_between(run_squid: Run, tmp_path: Path) -> None:
    """Slower parameters have a smaller bound, above that of constant ones."""
    problem = demo(0.5)
    bounds = []
    for rate in (0.05, 1.0):
        problem["data"]["rate"] = rate
        found = json.loads(run_squid("lpv", "gain", written(tmp_path, problem), "--json").stdout)
        assert found["proved_at_rate"] <= found["proved"], found
        bounds.append(found["proved_at_rate"])
    assert 2.4546307 < bounds[0] < bounds[1] < 4.49


def problem_of(name: str, rate: float) -> dict:
    """Return the problem of a case at a rate."""
    return {"data": copy.deepcopy(CASES[name]["data"]) | {"rate": rate}}


def at_rate(run_squid: Run, folder: Path, problem: dict) -> float:
    """Return the proved bound at the rate of a problem."""
    done = run_squid("lpv", "gain", written(folder, problem), "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)["proved_at_rate"]


@pytest.mark.parametrize(("name", "rate", "gamma"), RATES)
def test_published_gains_at_a_rate(
    run_squid: Run, tmp_path: Path, name: str, rate: float, gamma: float
) -> None:
    """The proved bound is at most 2 % above the published one, also if none exists for any rate."""
    path = written(tmp_path, problem_of(name, rate))
    done = run_squid("lpv", "gain", path, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(done.stdout)
    assert (found["status"], found["rate"]) == ("proved", rate)
    assert found["constant_lower"] < found["proved_at_rate"]
    assert found["proved_at_rate"] <= (1.0 + CASES[name]["expected"]["rtol"]) * gamma
    exists = name == "lpv12_gas_turbine"
    assert (found["proved"] is not None) == (found["gamma"] is not None) == exists
    assert not exists or found["proved_at_rate"] <= found["proved"]
    said = run_squid("lpv", "gain", path).stdout + "".join(found["reasons"])
    assert not [word for word in ("control", "back-off", "grid") if word in said]
    checked = run_squid("lpv", "check", path, tmp_path / "certificate.json", "--json")
    assert checked.returncode == 0, checked.stderr
    assert json.loads(checked.stdout)["gamma_at_rate"] == found["proved_at_rate"]
    # A claim for a rate does not hold for faster parameters or for arbitrary rates.
    for faster in ({"rate": 1.01 * rate}, {}):
        problem = {"data": CASES[name]["data"] | faster}
        checked = run_squid("lpv", "check", written(tmp_path, problem), tmp_path / "certificate.json")
        assert (checked.returncode == 0) == (exists and not faster), checked.stdout


@pytest.mark.parametrize(
    ("name", "rates"),
    [
        ("lpv11_shamma_athans", [0.0, 0.001, 0.003, 0.01, 0.03, 0.05, 0.07, 0.1, 0.2, 0.4, 0.5]),
        ("lpv12_gas_turbine", [0.0, 2.0, 20.0, 100.0, 200.0, 1e3, 1e4]),
    ],
)
def test_a_faster_parameter_has_no_smaller_bound(
    run_squid: Run, tmp_path: Path, name: str, rates: list[float]
) -> None:
    """The bound at a rate is not above the bound at a larger rate, up to the accuracy of the search."""
    bounds = [at_rate(run_squid, tmp_path, problem_of(name, rate)) for rate in rates]
    assert all(slow <= (1.0 + 1e-3) * fast for slow, fast in pairwise(bounds)), bounds


def rescaled(problem: dict, change: Callable[[dict[str, np.ndarray]], float]) -> dict:
    """Return a problem with its matrices changed in place, and its rate multiplied by the result of the change."""
    data = problem["data"]
    matrices = {key: np.array(rows, dtype=float) for key, rows in data["P"].items()}
    rate = data["rate"] * change(matrices)
    return {"data": data | {"P": {key: m.tolist() for key, m in matrices.items()}, "rate": rate}}


def in_unit_of_time(p: dict[str, np.ndarray]) -> float:
    """Let time run a thousand times as fast."""
    for key in ("A", "Bt", "B1"):
        p[key] *= 1e3
    return 1e3


def in_coordinates(p: dict[str, np.ndarray]) -> float:
    """Transform the states to coordinates with condition number 1e3."""
    n = len(p["A"])
    turns = [np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0] for seed in (1, 2)]
    t = turns[0] @ np.diag(np.logspace(-1.5, 1.5, n)) @ turns[1]
    inverse = np.linalg.inv(t)
    p["A"] = inverse @ p["A"] @ t
    p |= {key: inverse @ p[key] for key in ("Bt", "B1")} | {key: p[key] @ t for key in ("Ct", "C1")}
    return 1.0


def in_units_of_w_and_z(p: dict[str, np.ndarray]) -> float:
    """Scale w and z by the same factor of a thousand, which keeps the gain."""
    for key, factor in {"B1": 1e3, "Dt1": 1e3, "C1": 1e-3, "D1t": 1e-3}.items():
        p[key] *= factor
    return 1.0


@pytest.mark.parametrize("change", [in_unit_of_time, in_coordinates, in_units_of_w_and_z])
@pytest.mark.parametrize(("name", "rate", "gamma"), RATES)
def test_units_and_coordinates_do_not_matter(
    run_squid: Run,
    tmp_path: Path,
    name: str,
    rate: float,
    gamma: float,
    change: Callable[[dict[str, np.ndarray]], float],
) -> None:
    """The proved bound is the same to 1e-3 in other units and coordinates."""
    problem = problem_of(name, rate)
    given = at_rate(run_squid, tmp_path, problem)
    assert given < 1.02 * gamma
    assert at_rate(run_squid, tmp_path, rescaled(problem, change)) == pytest.approx(given, rel=1e-3)


def test_no_bound_at_a_rate_that_is_too_fast(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """If no Lyapunov matrix is found for any rate or for the given one, nothing is claimed."""
    path = written(tmp_path, problem_of("lpv11_shamma_athans", 50.0))
    done = run_squid("lpv", "gain", path, "--out", tmp_path, "--json")
    found = json.loads(done.stdout)
    assert (done.returncode, found["status"]) == (3, "not_found")
    assert found["proved"] is None and "proved_at_rate" not in found
    assert [reason.partition(":")[0] for reason in found["reasons"]] == snapshot
    assert not (tmp_path / "certificate.json").exists()


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"B2": [[1.0], [0.0]], "D12": [[1.0]], "Dt2": [[0.0], [0.0]]}, "B2"),
        ({"C2": [[1.0, 0.0]], "D21": [[1.0]], "D2t": [[0.0, 0.0]]}, "C2"),
        ({"B1": None}, "B1"),
    ],
)
def test_what_has_no_gain_is_refused(
    run_squid: Run, tmp_path: Path, change: dict, key: str, snapshot: SnapshotAssertion
) -> None:
    problem = demo(0.1)
    problem["data"]["P"] |= change
    problem["data"]["P"] = {key: value for key, value in problem["data"]["P"].items() if value is not None}
    code, report, error = gain(run_squid, tmp_path, problem)
    assert refused(code, report, error) == (None, key)
    assert named(error, TMP=tmp_path) == snapshot
    assert not (tmp_path / "certificate.json").exists()


def test_an_unstable_loop_has_no_bound(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    problem = demo(0.1)
    problem["data"]["P"] |= {"A": [[0.5, 0.0], [0.0, -1.0]]}
    code, report, _ = gain(run_squid, tmp_path, problem)
    assert (code, report["status"], report["proved"]) == (3, "not_found", None)
    assert [masked(reason) for reason in report["reasons"]] == snapshot
    assert not (tmp_path / "certificate.json").exists()


def gain(run_squid: Run, folder: Path, problem: dict) -> tuple[int, dict, str]:
    """Run `squid lpv gain --json` on a problem; return exit code, report and standard error."""
    done = run_squid("lpv", "gain", written(folder, problem), "--out", folder, "--json")
    return done.returncode, json.loads(done.stdout), done.stderr


@pytest.mark.parametrize(
    ("inside", "beside", "above", "line", "key"),
    [
        ({"speed": 1}, {}, {}, 1, "data.P.speed"),
        ({}, {"sped": 1}, {}, 1, "data.sped"),
        ({}, {"rates": 1}, {}, 1, "data.rates"),
        ({}, {}, {"speed": 1}, 1, "speed"),
        ({}, {}, {"rate": 1}, None, "rate"),
    ],
)
def test_no_key_is_ignored(
    run_squid: Run,
    tmp_path: Path,
    inside: dict,
    beside: dict,
    above: dict,
    line: int | None,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """An unknown key is refused at every level; descriptive keys are ignored."""
    problem = demo(0.1) | {"kind": "lpvgain", "source": "IQClab", "notes": "none"} | above
    problem["data"] |= beside
    problem["data"]["P"] = problem["data"]["P"] | inside
    code, report, error = gain(run_squid, tmp_path, problem)
    assert refused(code, report, error) == (line, key)
    assert named(error, TMP=tmp_path) == snapshot


def test_a_plant_without_parameters_has_no_blocks(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """`blocks` next to plain matrices would have no effect, and is refused."""
    code, report, error = gain(run_squid, tmp_path, {"data": PLANT | {"blocks": [1]}})
    assert refused(code, report, error) == (None, "blocks")
    assert named(error, TMP=tmp_path) == snapshot


def test_words_of_a_finished_loop(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Skew scalings give a bound where symmetric ones do not; a closed loop has no controls and no back-off."""
    turning = {
        "A": [[-0.1, 1], [-1, -0.1]], "Bt": [[0, 0.9], [-0.9, 0]], "Ct": [[1, 0], [0, 1]], "C1": [[1, 0]],
        "B1": [[1], [0]], "Dtt": [[0, 0], [0, 0]], "Dt1": [[0], [0]], "D1t": [[0, 0]], "D11": [[0]],
    }  # fmt: skip
    done = run_squid("lpv", "gain", written(tmp_path, {"data": {"P": turning, "blocks": [2]}}), "--json")
    report = json.loads(done.stdout)
    assert report["status"] == "proved" and report["gamma_symmetric"] is None
    assert report["reasons"] == snapshot
