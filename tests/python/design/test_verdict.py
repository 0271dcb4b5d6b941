"""Requirements in [require] that a design misses are reported, set the exit code, and are searched by `squid tune`."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from conftest import Run, masked, messages, named, once
from fly import build
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

SQUID = ROOT / "vehicles" / "squid"
TETHYS = ROOT / "vehicles" / "tethys"
"""The vehicle whose designs take the least time."""
MISSED = 5
"""The exit code of `--help`."""
ASKED = """
[require]
phase_margin = 88.0
delay_margin = 0.15
noise = 10.0
beyond_recovery = 20.0
"""


@pytest.fixture(scope="module")
def hard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return Squid with the paper's design, which has three keys, a larger required margin, and no uncertainty."""
    vehicle = tmp_path_factory.mktemp("hard") / "hard"
    vehicle.mkdir()
    shutil.copy(SQUID / "vehicle.toml", vehicle)
    text = (SQUID / "paper.toml").read_text(encoding="utf-8")
    assert "[require]" not in text
    certain = text.split("\n[uncertainty]")[0]
    (vehicle / "design.toml").write_text(certain + ASKED, encoding="utf-8")
    return vehicle


def test_a_requirement_that_is_missed_is_told_and_counted(
    run_squid: Run, hard: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The files are written all the same; the only missed requirement is named, with the value found."""
    done = run_squid("design", hard, "--strict", "--no-advise", "--out", tmp_path / "out")
    assert done.returncode == MISSED, done.stderr
    assert "1 of 13 requirements MISSED" in done.stdout
    assert masked(messages(done)) == snapshot
    figures = json.loads((tmp_path / "out" / "design.json").read_text("utf-8"))
    rows = figures["verdict"]["rows"]
    # The design does not track the speed, so that there is no row on its loss in a steep climb.
    assert not {"beyond_speed", "held_speed"} & {row["key"] for row in rows}
    missed = [row for row in rows if row["outcome"] == "missed"]
    assert [(row["key"], row["limit"]) for row in missed] == [("phase_margin", 88.0)]
    assert missed[0]["achieved"]["value"] < 88.0
    assert "advice" not in missed[0]
    assert (tmp_path / "out" / "controller.json").is_file()


def test_advice_is_printed_and_kept(run_squid: Run, hard: Path, tmp_path: Path) -> None:
    """The advice is in the missed row of design.json and of the report, and in the answer of --json."""
    done = run_squid("design", hard, "--json", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "out" / "design.json").read_text("utf-8"))
    assert json.loads(done.stdout)["design"] == figures
    ((key, advice),) = ((row["key"], row["advice"]) for row in figures["verdict"]["rows"] if "advice" in row)
    change = advice["change"]
    assert key == "phase_margin"
    assert change["key"].split(" of ")[0] in ("track.bandwidth", "control.weight", "control.disturbance")
    percent = f"{100 * abs(change['factor'] - 1):.0f} %"
    words = ("raise" if change["factor"] > 1 else "lower") + f" {change['key']} by {percent}: "
    assert advice["text"].startswith(words)
    done = run_squid("report", hard, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert words in done.stdout
    assert words.replace(" %", "\u00a0%") in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_vehicle_alone_is_tuned(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Few designs: the written file is commented, and gives the verdict that was printed."""
    few = ("--designs", "2")

    def tune(vehicle: Path) -> None:
        vehicle.mkdir()
        shutil.copy(TETHYS / "vehicle.toml", vehicle)
        done = run_squid("tune", vehicle, *few, timeout=600.0)
        assert done.returncode in (0, MISSED), done.stderr
        assert (done.returncode == MISSED) == ("MISSED" in done.stdout), done.stdout
        (vehicle / "tune.txt").write_text(done.stdout, encoding="utf-8")
        again = run_squid("design", vehicle, "--no-advise", "--out", vehicle / "out")
        assert again.returncode == 0, again.stderr
        (vehicle / "again.txt").write_text(again.stdout, encoding="utf-8")

    made = once([build.squid(), TETHYS / "vehicle.toml"], ["tune", *few], tune)
    printed, again = ((made / name).read_text(encoding="utf-8") for name in ("tune.txt", "again.txt"))
    told = [
        line.strip()
        for line in printed.splitlines()
        if re.search("begun from|PROVED: |--designs|squid ", line)
    ]
    assert masked(named("\n".join(told), MADE=made.with_suffix(".unfinished"))) == snapshot
    assert re.search(r"^ +[\d.]+ +[\d.]+   written$", printed, re.MULTILINE)
    table = [line for line in printed.splitlines() if "phase margin" in line]
    assert table[0] in again

    vehicle = Path(shutil.copytree(made, tmp_path / "mine"))
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    assert "# Pitch follows" in text
    assert run_squid("tune", vehicle, "--designs", "0").returncode == 64
    assert (vehicle / "design.toml").read_text(encoding="utf-8") == text
