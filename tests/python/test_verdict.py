"""What [require] asks and a design misses is told, counted in the exit code, and looked for by `squid tune`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from conftest import Run
from fly.stages import ROOT

REMUS = ROOT / "vehicles" / "remus100"
MISSED = 5
"""The exit code of `--help`."""


@pytest.fixture
def hard(tmp_path: Path) -> Path:
    """Return REMUS 100 with more phase margin asked for than its design has."""
    vehicle = tmp_path / "hard"
    shutil.copytree(REMUS, vehicle)
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    assert "\nphase_margin = 40.0" in text
    (vehicle / "design.toml").write_text(
        text.replace("\nphase_margin = 40.0", "\nphase_margin = 70.0"), encoding="utf-8"
    )
    return vehicle


def test_a_requirement_that_is_missed_is_told_and_counted(run_squid: Run, hard: Path, tmp_path: Path) -> None:
    """The files are written all the same; the only thing that is missed is named, with what was found."""
    done = run_squid("design", hard, "--strict", "--out", tmp_path / "out")
    assert done.returncode == MISSED, done.stderr
    assert "1 of 9 requirements MISSED" in done.stdout
    assert "`--advise`" in done.stdout
    assert done.stderr.startswith("squid: MISSED: phase margin is 4")
    assert "'require.phase_margin' asks for > 70 deg" in done.stderr
    rows = json.loads((tmp_path / "out" / "design.json").read_text("utf-8"))["verdict"]["rows"]
    missed = [row for row in rows if row["outcome"] == "missed"]
    assert [(row["key"], row["limit"]) for row in missed] == [("phase_margin", 70.0)]
    assert missed[0]["achieved"]["value"] < 70.0
    assert (tmp_path / "out" / "controller.json").is_file()


def test_a_vehicle_alone_is_tuned(run_squid: Run, tmp_path: Path) -> None:
    """A few seconds of search: the file that it writes is commented, gives the verdict that was told."""
    vehicle = tmp_path / "mine"
    vehicle.mkdir()
    shutil.copy(ROOT / "vehicles" / "squid" / "vehicle.toml", vehicle)
    done = run_squid("tune", vehicle, "--minutes", "0.2", timeout=600.0)
    assert done.returncode in (0, MISSED), done.stderr
    assert "begun from the vehicle: " in done.stdout
    assert "PROVED: gain below " in done.stdout
    assert (done.returncode == 0) == ("requirements are met" in done.stdout), done.stdout
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    assert "# Pitch follows" in text
    again = run_squid("design", vehicle, "--out", tmp_path / "out")
    assert again.returncode == 0, again.stderr
    table = [line for line in done.stdout.splitlines() if "phase margin" in line]
    assert table[0] in again.stdout

    refused = run_squid("tune", vehicle, "--minutes", "0")
    assert refused.returncode == 64
    assert "--minutes is 0; it must be from 0.05 to 600" in refused.stderr
    assert (vehicle / "design.toml").read_text(encoding="utf-8") == text
