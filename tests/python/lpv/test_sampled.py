"""`squid lpv sampled`, and the sampled loop of a design."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused

pytestmark = pytest.mark.change

CASES = sorted((ROOT / "tests" / "cases").glob("sd*.json"))


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_published_bounds(run_squid: Run, path: Path) -> None:
    """The published bounds have four decimals."""
    done = run_squid("lpv", "sampled", path, "--json")
    assert done.returncode == 0, done.stderr
    found, published = json.loads(done.stdout), json.loads(path.read_text("utf-8"))["expected"]
    assert published["lower"] - 5e-5 <= found["lower"] <= found["upper"] <= published["upper"] + 5e-5
    assert found["upper"] <= found["lower"] * (1.0 + 1e-5)


@pytest.mark.parametrize(
    ("change", "line", "key"),
    [
        ({"delay": 11}, None, "delay"),
        ({"sample_time": 0}, None, "sample_time"),
        ({"held": 1}, 1, "data.held"),
        ({"K": {"A": [], "D": [[0.0, 1.0]]}}, None, ""),
    ],
)
def test_what_cannot_be_bounded_is_refused(
    run_squid: Run, tmp_path: Path, change: dict, line: int | None, key: str, snapshot: SnapshotAssertion
) -> None:
    code, report, error = sampled(run_squid, tmp_path / "p.json", change)
    assert refused(code, report, error) == (line, key)
    assert report["upper"] is None and named(error, TMP=tmp_path) == snapshot


def test_an_unstable_loop_has_no_bound(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    code, report, _ = sampled(run_squid, tmp_path / "p.json", {"delay": 3})
    assert (code, report["status"], report["upper"]) == (2, "unstable", None)
    assert report["reason"] == snapshot


def sampled(run_squid: Run, path: Path, change: dict) -> tuple[int, dict, str]:
    """Run `squid lpv sampled --json` on a changed case; return exit code, report and standard error."""
    case = json.loads(CASES[0].read_text("utf-8"))
    case["data"].update(change)
    path.write_text(json.dumps(case), encoding="utf-8")
    done = run_squid("lpv", "sampled", path, "--json")
    return done.returncode, json.loads(done.stdout), done.stderr


def test_a_delay_costs_gain_and_holding_saves_some(run_squid: Run, tmp_path: Path) -> None:
    case = json.loads(CASES[1].read_text("utf-8"))
    upper = {}
    for change in ({}, {"delay": 1}, {"held": True}):
        path = tmp_path / "p.json"
        path.write_text(json.dumps({"data": case["data"] | change}), encoding="utf-8")
        upper[tuple(change)] = json.loads(run_squid("lpv", "sampled", path, "--json").stdout)["upper"]
    assert upper["held",] <= upper[()] < upper["delay",]
