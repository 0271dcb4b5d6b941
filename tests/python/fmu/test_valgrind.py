"""Simulation of each FMU under Valgrind without errors or leaks, and FMUs unpacked in unusual folders."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from platform import machine

import pytest
from fly import platforms
from fly.master import Slave
from fly.package import Packages
from fly.stages import ROOT
from native import Plan, Unpacked, program

pytestmark = pytest.mark.change

KINDS = ["plant", "controller", "loop"]
ERROR = 99
UNUSUAL = ["with space", "prozent%20kodiert", "Fähre-Ünïcode-航行", "a+b&c;d#e", "dot.dot..", "quote'd"]


def valgrind(*words: str | Path) -> list[str | Path]:
    """Return a command under Valgrind; errors and leaks end it with `ERROR`."""
    found = program("valgrind", "valgrind")
    return [
        found,
        "--leak-check=full",
        "--show-leak-kinds=all",
        "--errors-for-leak-kinds=all",
        f"--suppressions={ROOT / 'tests' / 'host' / 'loader.supp'}",
        f"--error-exitcode={ERROR}",
        *words,
    ]


@pytest.mark.night
@pytest.mark.parametrize("kind", KINDS)
def test_a_flight_leaks_nothing_and_errs_nowhere(
    squid: Packages, kind: str, host: Path, tmp_path: Path
) -> None:
    unpacked = Unpacked.of(getattr(squid, kind), tmp_path / kind)
    log = tmp_path / "valgrind.log"
    own = platforms.HERE[(sys.platform, machine())]
    flown = unpacked.flight(valgrind(f"--log-file={log}", host), own, Plan({}, 0.02, 500, 50))
    assert len(flown["time"]) == 11
    said = log.read_text(encoding="utf-8", errors="replace")
    assert "ERROR SUMMARY: 0 errors from 0 contexts" in said, said


@pytest.mark.night
def test_valgrind_would_see_a_leak(tmp_path: Path) -> None:
    source = tmp_path / "leak.c"
    source.write_text(
        "#include <stdlib.h>\nint main(void) { char *volatile p = malloc(9); p = NULL; return p != NULL; }\n",
        encoding="utf-8",
    )
    leaking = tmp_path / "leak"
    subprocess.run([program("gcc", "cc", "gcc", "clang"), "-O0", "-o", leaking, source], check=True)
    done = subprocess.run(valgrind(leaking), capture_output=True, text=True, check=False)
    assert done.returncode == ERROR, done.stderr


@pytest.fixture
def unpacked_in(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """Return a function that makes FMPy unpack into a folder of a name."""

    def unpack(name: str) -> Path:
        folder = tmp_path / name
        folder.mkdir()
        monkeypatch.setattr("tempfile.tempdir", str(folder))
        return folder

    return unpack


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", UNUSUAL)
def test_flies_from_unusual_folders(squid: Packages, kind: str, name: str, unpacked_in) -> None:
    folder = unpacked_in(name)
    with Slave(getattr(squid, kind), "unusual") as slave:
        assert folder in slave.folder.parents
        slave.begin()
        slave.ready()
        slave.step_to(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_flies_from_a_folder_that_cannot_be_written(
    squid: Packages, kind: str, tmp_path: Path, host: Path
) -> None:
    """Nothing is written next to binary or resources: the folder does not change, and may be read-only."""
    unpacked = Unpacked.of(getattr(squid, kind), tmp_path / kind)
    for folder, _, files in os.walk(unpacked.folder, topdown=False):
        for file in files:
            (Path(folder) / file).chmod(0o555)
        Path(folder).chmod(0o555)
    before = {path: path.stat().st_mtime_ns for path in unpacked.folder.rglob("*")}
    try:
        own = platforms.HERE[(sys.platform, machine())]
        unpacked.flight([host], own, Plan({}, 0.02, 50, 10))
        assert {path: path.stat().st_mtime_ns for path in unpacked.folder.rglob("*")} == before
    finally:
        for folder, _, _ in os.walk(unpacked.folder):
            Path(folder).chmod(0o755)
