"""Campaigns of many flights: by the command, on a Dask cluster, with FMUs; and their results in other tools."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import polars
import pytest
from conftest import SQUID, UNBROKEN, Run, masked, messages, named, refusal
from fly.package import Packages
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

SEA = ROOT / "vehicles" / "sea.toml"


AT_SEA = ("--flights", "12", "--sea", str(SEA), "--points", "corners", "--starts", "pitch=5deg,heave=0.1m/s")


@pytest.fixture(scope="module")
def designed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a directory with the committed design of Squid."""
    return Path(shutil.copytree(SQUID / "frozen", tmp_path_factory.mktemp("campaign") / "design"))


@pytest.fixture(scope="module")
def at_sea(run_squid: Run, designed: Path) -> tuple[Path, dict]:
    """Return a campaign at sea, and the answer of the command."""
    done = run_squid("campaign", SQUID, "--out", designed, *AT_SEA, "--json")
    assert done.returncode == 0, done.stderr
    return designed / "campaign", json.loads(done.stdout)


@pytest.fixture(scope="module")
def local(run_squid: Run, designed: Path) -> Path:
    """Return a campaign of 200 flights, simulated on this machine without interruption."""
    to = designed.parent / "local"
    words = ["--flights", "200", "--to", to, "--no-bound"]
    assert run_squid("campaign", SQUID, "--out", designed, *words).returncode == 0
    return to


def files_in(results: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in results.glob("*.parquet")}


def test_results_open_without_our_code(at_sea: tuple[Path, dict]) -> None:
    """Other tools read all flights, with the shares and largest figures that the command reports, also at sea."""
    results, said = at_sea
    table = polars.read_parquet(results / "*.parquet")
    assert sorted(table["flight"]) == list(range(12))
    counted = dict(table["outcome"].value_counts().iter_rows())
    assert counted == {row["outcome"]: row["flights"] for row in said["outcomes"] if row["flights"]}
    for row in said["figures"]:
        column = table[row["figure"]].drop_nans()
        of_flight = table.filter(polars.col("flight") == row["flight"])[row["figure"]].item()
        assert of_flight == column.max()
        assert row["largest"] == (of_flight if math.isfinite(of_flight) else None), "JSON has no infinity"
    file = next(results.glob("*.parquet"))
    units = json.loads(polars.read_parquet_metadata(file)["squid.units"])
    assert units["overshoot"] == "1" and units["speed_from"] == "m/s" and len(units) == len(table.columns) - 2
    page = ElementTree.parse(results / "campaign.html").getroot()
    assert len(list(page.iter("{http://www.w3.org/1999/xhtml}figure"))) == 2
    # Flights start off trim by up to these amounts.
    assert units["pitch_off_trim"] == "rad" and 0.03 < table["pitch_off_trim"].abs().max() <= math.radians(
        5.0
    )
    assert units["heave_off_trim"] == "m/s" and 0.03 < table["heave_off_trim"].abs().max() <= 0.1
    # Rolls of the sea differ between flights.
    assert table["speed_error_rms"].n_unique() == 12


def test_the_guaranteed_gain_stands_beside(at_sea: tuple[Path, dict]) -> None:
    """The page shows the guaranteed gain at six speeds; no vehicle exceeds it, and no number on the page either."""
    results, said = at_sea
    assert [row["speed"] for row in said["gains"]] == [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    page = ElementTree.parse(results / "campaign.html").getroot()
    (section,) = (part for part in page.iter() if part.get("id") == "guaranteed")
    cells = ["".join(cell.itertext()) for cell in section.iter("{http://www.w3.org/1999/xhtml}td")]
    for k, row in enumerate(said["gains"]):
        assert 0.7 * row["guaranteed"] < row["largest"] <= row["guaranteed"] and row["flight"] in range(12)
        assert row["vehicles"] + row["outside"] == 12
        _, median, largest, flight, guaranteed, _ = cells[6 * k : 6 * k + 6]
        assert float(median) <= float(largest) <= float(guaranteed.removeprefix("below "))
        assert int(flight) == row["flight"]


def test_what_happened_in_the_worst_flights(at_sea: tuple[Path, dict]) -> None:
    """Each of the ten worst flights has a trajectory file, from which its figures follow; no other flight has one."""
    results, said = at_sea
    names = {f"flight-{flight:08}.parquet" for flight in said["worst"]}
    assert len(names) == 10 and {path.name for path in (results / "trajectories").iterdir()} == names
    table = polars.read_parquet(results / "*.parquet")
    order = ["lost", "surfaced", "flown"]
    rows = table.filter(polars.col("pitch_error_rms").is_not_nan()).iter_rows(named=True)
    worst = sorted(rows, key=lambda row: (order.index(row["outcome"]), -row["pitch_error_rms"]))[:10]
    assert said["worst"] == [row["flight"] for row in worst]
    for flight in said["worst"]:
        path = results / "trajectories" / f"flight-{flight:08}.parquet"
        ticks = polars.read_parquet(path)
        rms = ((ticks["pitch_reference_used"] - ticks["pitch"]) ** 2).mean() ** 0.5
        known = table.filter(polars.col("flight") == flight)["pitch_error_rms"].item()
        assert rms == pytest.approx(known, rel=1e-12) and set(ticks["flight"]) == {flight}
    units = json.loads(polars.read_parquet_metadata(path)["squid.units"])
    assert units["pitch"] == "rad" and units["wave_elevation"] == "m" and "flight" not in units


def test_what_happened_in_all_flights(
    run_squid: Run, designed: Path, at_sea: tuple[Path, dict], tmp_path: Path
) -> None:
    """On request trajectories of all flights are written; existing files are kept."""
    shutil.copytree(at_sea[0], tmp_path, dirs_exist_ok=True)
    before = files_in(tmp_path / "trajectories")
    words = ["--out", designed, "--to", tmp_path, *AT_SEA, "--no-bound", "--trajectories"]
    assert run_squid("campaign", SQUID, *words).returncode == 0
    after = files_in(tmp_path / "trajectories")
    assert (
        set(after) == {f"flight-{flight:08}.parquet" for flight in range(12)}
        and before.items() <= after.items()
    )


def test_a_flight_again(
    run_squid: Run, designed: Path, at_sea: tuple[Path, dict], snapshot: SnapshotAssertion
) -> None:
    results, _ = at_sea
    done = run_squid("replay", results, "--flight", "2", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["same"] is True and said["outcome"] in ("flown", "surfaced")
    assert (results / "flight-2.csv").is_file() and "<svg" in (results / "flight-2.svg").read_text("utf-8")
    for folder, flight, key in ((results, "12", "no_flight"), (designed, "0", "no_campaign")):
        done = run_squid("replay", folder, "--flight", flight, "--json")
        refusal(done, key)
        assert messages(done, DESIGN=designed) == snapshot


def test_killed_and_begun_again(
    squid_command: Path, run_squid: Run, designed: Path, local: Path, tmp_path: Path
) -> None:
    """A killed campaign resumes, with the results of an uninterrupted one."""
    words = ["campaign", SQUID, "--out", designed, "--flights", "200", "--to", tmp_path, "--no-bound"]
    with subprocess.Popen([squid_command, *words], stdout=subprocess.DEVNULL) as process:
        while process.poll() is None and not any(tmp_path.glob("*.parquet")):
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    assert 0 < len(files_in(tmp_path)) < 4, "it was killed on the way"
    assert run_squid(*words).returncode == 0
    assert files_in(tmp_path) == files_in(local)


def on_cluster(*words: str | Path) -> subprocess.CompletedProcess:
    """Run `python -m squid_campaign`."""
    command = [sys.executable, "-m", "squid_campaign", *map(str, words)]
    variables = {**os.environ, "PYTHONPATH": str(ROOT / "tools"), "COLUMNS": UNBROKEN}
    return subprocess.run(
        command, cwd=ROOT, env=variables, capture_output=True, text=True, timeout=300.0, check=False
    )


@pytest.mark.night
def test_ctrl_c_on_a_cluster(designed: Path, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Ctrl-C ends with one sentence and no traceback, also of the workers, and finished flights are kept."""
    words = [
        SQUID,
        "--out",
        designed,
        "--to",
        tmp_path,
        "--flights",
        "100000",
        "--no-bound",
        "--workers",
        "1",
    ]
    command = [sys.executable, "-m", "squid_campaign", *map(str, words)]
    variables = {**os.environ, "PYTHONPATH": str(ROOT / "tools")}
    with subprocess.Popen(
        command, env=variables, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        while process.poll() is None and not files_in(tmp_path):
            time.sleep(0.01)
        # A terminal interrupts all processes.
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=60.0)[1]
    assert process.returncode == 130 and files_in(tmp_path)
    assert said == snapshot


@contextmanager
def cluster_in(folder: Path, workers: int) -> Iterator[str]:
    """Run a scheduler and workers without our packages; yield the address."""
    file = folder / "scheduler.json"
    shared = ["--scheduler-file", str(file), "--no-dashboard"]
    serve = ["scheduler", "--host", "127.0.0.1", "--port", "0"]
    work = ["worker", "--nthreads", "1", "--no-nanny", "--local-directory", str(folder)]
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    processes = []
    try:
        for words in [serve, *workers * [work]]:
            command = [sys.executable, "-m", "dask", *words, *shared]
            processes.append(subprocess.Popen(command, cwd=folder, env=own, stderr=subprocess.DEVNULL))
            while not file.is_file():
                time.sleep(0.05)
        yield json.loads(file.read_text(encoding="utf-8"))["address"]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


@pytest.mark.night
def test_a_worker_is_killed(squid_command: Path, designed: Path, local: Path, tmp_path: Path) -> None:
    """One of two processes is lost while it simulates: only its unfinished part is repeated, with the same bytes."""
    log, squid, results = tmp_path / "log", tmp_path / "squid", tmp_path / "results"
    squid.write_text(f'#!/bin/sh\necho $PPID "$@" >> {log}\nexec {squid_command} "$@"\n', encoding="utf-8")
    squid.chmod(0o755)

    def flown() -> list[tuple[int, str]]:
        """Return process and part of each part that a worker has started."""
        rows = (
            [line.split() for line in log.read_text(encoding="utf-8").splitlines()] if log.is_file() else []
        )
        return [(int(row[0]), row[row.index("--only") + 1]) for row in rows if "--only" in row]

    with cluster_in(tmp_path, 2) as address:
        words = [SQUID, "--out", designed, "--flights", "200", "--to", results]
        command = [
            sys.executable,
            "-m",
            "squid_campaign",
            *words,
            "--no-bound",
            "--scheduler",
            address,
            "--squid",
            squid,
        ]
        variables = {**os.environ, "PYTHONPATH": str(ROOT / "tools")}
        with subprocess.Popen(command, env=variables, stdout=subprocess.DEVNULL) as process:
            while process.poll() is None and not flown():
                time.sleep(0.01)
            lost, part = flown()[0]
            os.kill(lost, signal.SIGKILL)
            assert process.wait(timeout=300.0) == 0
    parts = [part for _, part in flown()]
    assert sorted(parts) == sorted(["0-63", "64-127", "128-191", "192-199", part])
    assert lost not in [worker for worker, again in flown()[1:] if again == part]
    assert files_in(results) == files_in(local)


@pytest.mark.night
def test_a_full_disk_on_a_cluster(
    designed: Path, local: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Finished flights are kept after a full disk, and the missing ones follow."""
    name = "flights-00000192-00000199.parquet"
    shutil.copytree(local, tmp_path, dirs_exist_ok=True)
    (tmp_path / name).unlink()
    # Files are written to where there is never space.
    (tmp_path / f".squid-{name}.part").symlink_to("/dev/full")
    words = [SQUID, "--out", designed, "--to", tmp_path, "--flights", "200", "--no-bound", "--workers", "2"]
    done = on_cluster(*words)
    assert done.returncode == 1 and len(files_in(tmp_path)) == 3
    assert messages(done, TMP=tmp_path) == snapshot
    done = on_cluster(*words)
    assert done.returncode == 0, done.stderr
    assert files_in(tmp_path) == files_in(local)


@pytest.mark.night
def test_all_options_reach_the_workers(
    designed: Path, at_sea: tuple[Path, dict], tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    # Trajectories of the worst flights need not be simulated again.
    shutil.copytree(at_sea[0] / "trajectories", tmp_path / "trajectories")
    done = on_cluster(SQUID, "--out", designed, "--to", tmp_path, *AT_SEA, "--no-bound", "--workers", "1")
    assert done.returncode == 0, done.stderr
    (told,) = (line for line in done.stdout.splitlines() if "flights of vehicles" in line)
    assert masked(named(told, TMP=tmp_path)) == snapshot
    assert files_in(tmp_path) == files_in(at_sea[0])


def test_another_version_on_a_worker(
    squid_command: Path, designed: Path, local: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    squid = tmp_path / "squid"
    other = 'case "$PWD $1" in */worker-*--version) echo squid 0.0.0; exit;; esac'
    squid.write_text(f'#!/bin/sh\n{other}\nexec {squid_command} "$@"\n', encoding="utf-8")
    squid.chmod(0o755)
    words = ["--out", designed, "--to", tmp_path / "none", "--workers", "1", "--squid", squid]
    done = on_cluster(SQUID, *words)
    assert done.returncode == 1 and not (tmp_path / "none").exists()
    version = subprocess.run([squid_command, "--version"], capture_output=True, text=True, check=True).stdout
    assert messages(done).replace(version.strip(), "squid VERSION") == snapshot


AGREEMENT = 1e-9
"""Of figures of FMUs with those of the native loop, in parts of 1 or of what is larger. The references are interpolated
by numpy, and the FMUs are compiled otherwise; 7e-15 was found over 256 flights in still water, 8e-13 over 64 at sea."""
USUAL_SEA = """seed = 1
depth = 3.0
[waves]
spectrum = "jonswap"
height = 1.0
period = 6.0
gamma = 3.3
heading = 150.0
[current]
horizontal = 0.2
vertical = -0.03
"""
"""All that FMUs have of a sea; so near the surface that a flight ends there."""


def test_fmus_on_workers_that_have_fmpy_alone(run_squid: Run, squid: Packages, tmp_path: Path) -> None:
    """Flights with FMUs equal the native ones, also at sea, where one breaks the surface."""
    results, native, sea = tmp_path / "fmus", tmp_path / "native", tmp_path / "sea.toml"
    sea.write_text(USUAL_SEA, encoding="utf-8")
    words = [SQUID, "--out", squid.folder, "--no-bound"]
    places = {"still": ["--flights", "4"], "sea": ["--flights", "2", "--sea", sea]}
    with cluster_in(tmp_path, 1) as address:
        for place, more in places.items():
            assert run_squid("campaign", *words, *more, "--to", native / place).returncode == 0
            # Trajectories of the worst flights need not be simulated again.
            shutil.copytree(native / place / "trajectories", results / place / "trajectories")
            done = on_cluster(*words, *more, "--to", results / place, "--fmu", "--scheduler", address)
            assert done.returncode == 0, done.stderr
    for place in places:
        found, expected = (polars.read_parquet(path / place / "*.parquet") for path in (results, native))
        assert found["outcome"].to_list() == expected["outcome"].to_list()
        for name in found.columns[2:]:
            assert found[name].to_list() == pytest.approx(
                expected[name].to_list(), rel=AGREEMENT, abs=AGREEMENT, nan_ok=True
            ), name
    assert found["outcome"].to_list() == ["flown", "surfaced"]
    results = results / "still"
    done = run_squid("replay", results, "--flight", "3", "--json")
    assert done.returncode == 0, done.stderr
    again = json.loads(done.stdout)
    assert again["fmus"] and again["difference"] < AGREEMENT
    done = run_squid("campaign", *words, "--to", results, "--json")
    refusal(done, "other")


def test_records_are_judged(run_squid: Run, designed: Path, tmp_path: Path) -> None:
    """A record without rows found no trim, one that ends early is lost, and one above the surface ends there."""
    actuators = "lower,upper_port,upper_starboard"
    head = f"time,pitch,speed,depth,distance,pitch_reference_used,speed_reference_used,{actuators}"
    rows = {0: [], 1: [5.0, 5.0, 5.0], 2: [5.0, 1.0, -1.0, -1.0]}
    for flight, depths in rows.items():
        lines = [f"{0.02 * k},0,1,{depth},0,0,1,1,1,1" for k, depth in enumerate(depths)]
        (tmp_path / f"flight-{flight}.csv").write_text("\n".join([head, *lines, ""]), encoding="utf-8")
    judge = ["campaign", SQUID, "--out", designed, "--records", tmp_path]
    words = [*judge, "--to", tmp_path, "--only"]
    assert run_squid(*words, "0-2").returncode == 0
    table = polars.read_parquet(tmp_path / "*.parquet")
    assert table["outcome"].to_list() == ["no_trim", "lost", "surfaced"]
    assert table["time"].fill_nan(-1.0).to_list() == [-1.0, -1.0, 0.02]
    done = run_squid(*words, "3-4")
    assert done.returncode == 1 and "flight-3.csv" in done.stderr and len(files_in(tmp_path)) == 1
    # If a trim exists, the waves prevented the start.
    sea = tmp_path / "sea.toml"
    sea.write_text(USUAL_SEA.replace("depth = 3.0", "depth = 0.0"), encoding="utf-8")
    assert run_squid(*judge, "--to", tmp_path / "sea", "--only", "0-0", "--sea", sea).returncode == 0
    assert polars.read_parquet(tmp_path / "sea" / "*.parquet")["outcome"].to_list() == ["surfaced"]


def refused_by(done: subprocess.CompletedProcess, results: Path) -> str:
    """Return the message of a refusal; which of several files of another campaign it names depends on the machine."""
    return re.sub(r"flights-\d+-\d+", "flights-#", messages(done, TMP=results.parent))


@pytest.mark.night
@pytest.mark.parametrize(
    "options",
    [
        ["--workers", "0"],
        ["--scheduler", "tcp://127.0.0.1:9"],
        ["--workers", "1", "--squid", "nothing"],
        ["--workers", "1", "--fmu"],
        ["--workers", "1", "--fmu", "--sea", "vehicles/sea.toml"],
        ["--workers", "1", "--seed", "2"],
    ],
    ids=" ".join,
)
def test_what_a_cluster_cannot_fly(
    designed: Path, local: Path, options: list[str], snapshot: SnapshotAssertion
) -> None:
    before = files_in(local)
    done = on_cluster(SQUID, "--out", designed, "--to", local, "--flights", "201", *options)
    assert done.returncode == 1 and files_in(local) == before
    assert refused_by(done, local) == snapshot


@pytest.mark.parametrize(
    ("options", "key", "code"),
    [
        (["--flights", "0"], "argument", 64),
        (["--seed", "2"], "other", 1),
        (["--points", "sobol"], "other", 1),
        (["--sea", "vehicles/sea.toml"], "other", 1),
        (["--sea", "nothing.toml"], "not_found", 1),
        (["--only", "9-3"], "usage", 64),
        (["--sea", "vehicles/sea.toml", "--records", "."], "not_of_fmus", 1),
        (["--starts", "pitch=5deg"], "other", 1),
        (["--starts", "pitch=5deg", "--records", "."], "not_of_fmus", 1),
        (["--starts", "speed=50m/s"], "argument", 64),
        (["--starts", "pitch=5"], "usage", 64),
        (["--records", "nowhere"], "other", 1),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_is_wrong_is_refused(
    run_squid: Run,
    designed: Path,
    local: Path,
    options: list[str],
    key: str,
    code: int,
    snapshot: SnapshotAssertion,
) -> None:
    before = {path.name: path.read_bytes() for path in local.glob("*.*")}
    done = run_squid("campaign", SQUID, "--out", designed, "--to", local, *options, "--json")
    refusal(done, key, code)
    assert refused_by(done, local) == snapshot
    assert before == {path.name: path.read_bytes() for path in local.glob("*.*")}
