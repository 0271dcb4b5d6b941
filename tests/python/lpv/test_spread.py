"""Random problems with slow and fast modes in bad coordinates, and problems from public reports."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run, kinds, masked
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

CASES = ROOT / "tests" / "cases"
SPREAD = json.loads((CASES / "spread.json").read_text(encoding="utf-8"))["problems"]
REPORTED = json.loads((CASES / "mixed_sensitivity.json").read_text(encoding="utf-8"))["problems"]

Synth = Callable[[dict], dict]


@pytest.fixture(scope="module")
def synth(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Synth:
    """Return a function that solves each problem once and returns its report."""
    folder: Path = tmp_path_factory.mktemp("problems")
    known: dict[str, dict] = {}

    def report(problem: dict) -> dict:
        name = problem["name"]
        if name not in known:
            path = folder / f"{name}.json"
            path.write_text(json.dumps({"data": problem["data"]}), encoding="utf-8")
            known[name] = json.loads(run_squid("lpv", "synth", path, "--json").stdout)
        return known[name]

    return report


@pytest.mark.parametrize("problem", SPREAD, ids=lambda problem: problem["name"])
def test_what_is_said_is_true(synth: Synth, problem: dict) -> None:
    """All have a controller; no bound is below the least gamma, and a gamma reported as least is near it."""
    low, high = problem["least"]
    report = synth(problem)
    if report["status"] == "numerical_failure":
        assert report["gamma"] is None
        return
    assert report["status"] == "feasible"
    assert report["certified_gamma"] >= 0.9999 * low
    assert report["gamma"] >= 0.999 * low
    assert not report["least"] or report["gamma"] <= 1.01 * high
    assert ("better_may_exist" in kinds(report)) == (not report["least"])
    assert ("bound_far_above" in kinds(report)) == (report["certified_gamma"] > 1.1001 * report["gamma"])


def test_nearly_all_are_solved(synth: Synth) -> None:
    """At least 81 of 90 have a gamma within 1 % of the least and a proved bound within 10 %."""

    def solved(problem: dict) -> bool:
        report, high = synth(problem), problem["least"][1]
        feasible = report["status"] == "feasible"
        return feasible and report["gamma"] <= 1.01 * high and report["certified_gamma"] <= 1.1 * high

    assert sum(solved(problem) for problem in SPREAD) >= 81


@pytest.mark.parametrize("problem", REPORTED, ids=lambda problem: problem["name"])
def test_reported_problems(synth: Synth, problem: dict) -> None:
    """Problems that other tools could not solve: least gamma to a thousandth, proved bound within the back-off."""
    report = synth(problem)
    assert report["gamma"] == pytest.approx(problem["least"], rel=1e-3)
    assert report["least"]
    assert report["certified_gamma"] <= 1.1001 * problem["least"]


def test_a_limit_below_the_least_is_infeasible_and_one_above_is_not(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """No wrong answer on either side, 0.2 % from the least gamma; the text says what does not exist."""
    headlines = set()
    for problem in REPORTED:
        path = tmp_path / f"{problem['name']}.json"
        path.write_text(json.dumps({"data": problem["data"]}), encoding="utf-8")
        above = run_squid("lpv", "synth", path, "--gamma-limit", 1.002 * problem["least"])
        assert above.returncode == 0, above.stdout
        below = run_squid("lpv", "synth", path, "--gamma-limit", 0.998 * problem["least"])
        assert below.returncode == 2, below.stdout
        headlines.add(below.stdout.splitlines()[0])
    assert headlines == snapshot


def test_a_stable_plant_without_a_common_lyapunov_function(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """U = 0 stabilises a switch between [-1 -1; 1 -1] and [-1 -7; 1/7 -1]; the report states what is infeasible."""
    plant = {
        "A": [[-1, -4], [4 / 7, -1]], "Bt": [[0, -3], [-3 / 7, 0]], "B1": [[1], [0]], "B2": [[0], [0]],
        "Ct": [[1, 0], [0, 1]], "Dtt": [[0, 0], [0, 0]], "Dt1": [[0], [0]], "Dt2": [[0], [0]],
        "C1": [[1, 0], [0, 0]], "D1t": [[0, 0], [0, 0]], "D11": [[0], [0]], "D12": [[0], [1]],
        "C2": [[1, 0]], "D2t": [[0, 0]], "D21": [[0.1]],
    }  # fmt: skip
    path = tmp_path / "switching.json"
    path.write_text(json.dumps({"data": {"P": plant, "blocks": [2]}}), encoding="utf-8")
    done = run_squid("lpv", "synth", path)
    assert done.returncode == 2 and masked(done.stdout) == snapshot
