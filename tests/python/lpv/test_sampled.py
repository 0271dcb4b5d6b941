"""`squid lpv sampled`, and the sampled loop of a design."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run
from fly.stages import ROOT

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
    ("change", "code", "words"),
    [
        ({"delay": 3}, 2, "the loop is not stable from tick to tick"),
        ({"delay": 11}, 1, "'delay' is the number 11; it must be a whole number of ticks from 0 to 10"),
        ({"sample_time": 0}, 1, "'sample_time' is the number 0; it must be a number above 0, in seconds"),
        ({"held": 1}, 1, "'data.held': invalid type: integer `1`, expected a boolean"),
        ({"K": {"A": [], "D": [[0.0, 1.0]]}}, 1, "B of the controller is 0 x 2, it must be 0 x 1"),
    ],
)
def test_what_cannot_be_bounded_is_told(
    run_squid: Run, tmp_path: Path, change: dict, code: int, words: str
) -> None:
    case = json.loads(CASES[0].read_text("utf-8"))
    case["data"].update(change)
    path = tmp_path / "p.json"
    path.write_text(json.dumps(case), encoding="utf-8")
    done = run_squid("lpv", "sampled", path, "--json")
    found = json.loads(done.stdout)
    assert (done.returncode, found["upper"]) == (code, None)
    assert words in found["reason"]


def test_a_delay_costs_gain_and_holding_saves_some(run_squid: Run, tmp_path: Path) -> None:
    case = json.loads(CASES[1].read_text("utf-8"))
    upper = {}
    for change in ({}, {"delay": 1}, {"held": True}):
        path = tmp_path / "p.json"
        path.write_text(json.dumps({"data": case["data"] | change}), encoding="utf-8")
        upper[tuple(change)] = json.loads(run_squid("lpv", "sampled", path, "--json").stdout)["upper"]
    assert upper["held",] <= upper[()] < upper["delay",]
