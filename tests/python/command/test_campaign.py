"""Campaigns of many flights by the command, and their results as others read them."""

from __future__ import annotations

import json
import math
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import polars
import pytest
from conftest import SQUID, Run
from fly.stages import ROOT

SEA = ROOT / "vehicles" / "sea.toml"


@pytest.fixture
def designed(tmp_path: Path) -> Path:
    """Return a directory with the committed design of Squid."""
    return Path(shutil.copytree(SQUID / "frozen", tmp_path / "design"))


def test_results_open_without_our_code(run_squid: Run, designed: Path) -> None:
    """All flights are there, with the shares and the largest figures that the command says, also at sea."""
    words = ["campaign", SQUID, "--out", designed, "--flights", "70", "--sea", SEA, "--corners", "--json"]
    done = run_squid(*words)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    table = polars.read_parquet(designed / "campaign" / "*.parquet")
    assert sorted(table["flight"]) == list(range(70))
    counted = dict(table["outcome"].value_counts().iter_rows())
    assert counted == {row["outcome"]: row["flights"] for row in said["outcomes"] if row["flights"]}
    for row in said["figures"]:
        column = table[row["figure"]].drop_nans()
        of_flight = table.filter(polars.col("flight") == row["flight"])[row["figure"]].item()
        assert of_flight == column.max()
        assert row["largest"] == (of_flight if math.isfinite(of_flight) else None), "JSON has no infinity"
    file = next((designed / "campaign").glob("*.parquet"))
    units = json.loads(polars.read_parquet_metadata(file)["squid.units"])
    assert units["overshoot"] == "1" and units["speed_from"] == "m/s" and len(units) == len(table.columns) - 2
    page = ElementTree.parse(designed / "campaign" / "campaign.html").getroot()
    assert len(list(page.iter("{http://www.w3.org/1999/xhtml}figure"))) == 2
    # Rolls of the sea differ from flight to flight.
    assert table["speed_error_rms"].n_unique() == 70


def test_a_flight_again(run_squid: Run, designed: Path) -> None:
    results = designed / "campaign"
    assert run_squid("campaign", SQUID, "--out", designed, "--flights", "3", "--sea", SEA).returncode == 0
    done = run_squid("replay", results, "--flight", "2", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["same"] is True and said["outcome"] in ("flown", "surfaced")
    assert (results / "flight-2.csv").is_file() and "<svg" in (results / "flight-2.svg").read_text("utf-8")
    done = run_squid("replay", results, "--flight", "3")
    assert done.returncode == 1 and "its flights are 0 to 2" in done.stderr
    done = run_squid("replay", designed, "--flight", "0")
    assert done.returncode == 1 and "campaign.json" in done.stderr


def test_killed_and_begun_again(squid_command: Path, run_squid: Run, designed: Path, tmp_path: Path) -> None:
    """What is killed goes on where it was: the results are those of a campaign that was left in peace."""
    words = ["campaign", SQUID, "--out", designed, "--flights", "400", "--to"]
    at_peace, killed = tmp_path / "peace", tmp_path / "killed"
    assert run_squid(*words, at_peace).returncode == 0
    with subprocess.Popen([squid_command, *words, killed], stdout=subprocess.DEVNULL) as process:
        while process.poll() is None and not any(killed.glob("*.parquet")):
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    left = len(list(killed.glob("*.parquet")))
    assert 0 < left < 7, "it was killed on the way"
    assert run_squid(*words, killed).returncode == 0
    files = {path.name: path.read_bytes() for path in at_peace.glob("*.parquet")}
    assert files == {path.name: path.read_bytes() for path in killed.glob("*.parquet")}


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--flights", "0"], 64, "--flights is 0; it must be at least 1"),
        (["--seed", "2"], 1, "is of another campaign: the seed differs"),
        (["--corners"], 1, "is of another campaign: where in the uncertainty it flies differs"),
        (["--sea", SEA], 1, "is of another campaign: the sea differs"),
        (["--sea", "nothing.toml"], 1, "nothing.toml"),
    ],
)
def test_what_is_wrong_is_refused(
    run_squid: Run, designed: Path, options: list, code: int, words: str
) -> None:
    assert run_squid("campaign", SQUID, "--out", designed, "--flights", "1").returncode == 0
    before = {path.name: path.read_bytes() for path in (designed / "campaign").iterdir()}
    done = run_squid("campaign", SQUID, "--out", designed, *options)
    assert done.returncode == code and words in done.stderr, done.stderr
    assert before == {path.name: path.read_bytes() for path in (designed / "campaign").iterdir()}
