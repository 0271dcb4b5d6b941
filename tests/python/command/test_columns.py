"""Output for people fits the width of the terminal."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from conftest import REMUS100, SQUID, Run, designed
from fly.stages import ROOT

pytestmark = pytest.mark.change

COLUMNS = 100
CASES = ROOT / "tests" / "cases"


STAGE = 13
"""Columns of the name of a stage."""


def too_long(text: str, columns: int) -> list[str]:
    """Return the lines that are too long, except those of a path that is itself too long."""

    def is_a_path(line: str) -> bool:
        words = line.split()
        name, path = " ".join(words[:-1]), words[-1]
        return "/" in path and STAGE + len(path) > columns and len(name) < STAGE

    return [line for line in text.splitlines() if len(line) > columns and not is_a_path(line)]


VERBS = [
    ["show", SQUID, "--speed", "1"],
    ["show", SQUID, "--speed", "1", "--fit", "--uncertainty"],
    ["show", ROOT / "vehicles" / "bluerov2_heavy", "--speed", "0.3"],
    ["show", REMUS100, "--speed", "0"],
    ["design", "QUICK", "--no-advise", "--out", "NEW"],
    ["simulate", "QUICK", "--out", "OUT"],
    ["report", "QUICK", "--out", "OUT"],
    ["export", "QUICK", "--out", "OUT"],
    ["package", "QUICK", "--out", "OUT", "--descriptions", "OUT"],
    ["verify", "OUT/certificate.json", "--vehicle", "QUICK"],
    ["campaign", "QUICK", "--out", "OUT", "--flights", "4", "--no-bound"],
    ["tune", "OUT", "--designs", "1"],
    ["new", "NEW/mine"],
    ["lpv", "synth", CASES / "lpv01_lpvtools_lft_tutorial.json"],
    ["doctor"],
    [
        "design",
        "nowhere",
        "--no-advise",
        "--out",
        "a/directory/with/a/name/that/is/rather/long/for/a/terminal",
    ],
]


@pytest.mark.parametrize("columns", [None, 72])
@pytest.mark.parametrize("words", VERBS, ids=lambda words: " ".join(map(str, words[:1])))
def test_lines_fit(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, words: list[str | Path], columns: int | None
) -> None:
    """Lines fit 100 columns, or the number in the environment."""
    places = {"QUICK": quick_vehicle, "NEW": tmp_path / "new"}
    if any("OUT" in str(word) for word in words):
        whole = quick_vehicle if words[0] == "tune" else designed(run_squid, quick_vehicle)
        places["OUT"] = copied(whole, tmp_path / "out")
    for name, path in places.items():
        words = [str(word).replace(name, str(path)) for word in words]
    done = run_squid(*words, columns="" if columns is None else str(columns))
    assert "internal error" not in done.stderr
    assert len((done.stdout + done.stderr).strip()) > 20
    assert too_long(done.stdout + done.stderr, columns or COLUMNS) == []


def copied(folder: Path, to: Path) -> Path:
    """Return a copy of a design that a verb may write to."""
    return Path(shutil.copytree(folder, to))
