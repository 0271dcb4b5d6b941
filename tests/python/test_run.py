"""The two commands of run.py as far as they can be tested without running them whole."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from fly import build, figures, flight, record, room, stamp
from fly.package import FIGURES, Packages
from fly.stages import ROOT, StageError, run


@pytest.mark.parametrize("words", [["--help"], ["fly", "--help"], ["test", "--help"]])
def test_help_teaches(words: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "run.py", *words], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert "usage" in done.stdout
    assert len(done.stdout.splitlines()) > 5


@pytest.mark.parametrize("columns", [60, 80, 160])
def test_help_is_as_wide_as_the_terminal(columns: int) -> None:
    environment = {**os.environ, "COLUMNS": str(columns)}
    words = [sys.executable, "run.py", "--help"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=environment, check=False)
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= columns
    assert columns < 160 or max(map(len, lines)) > 120
    assert sum(line.startswith("  python3 run.py ") for line in lines) == 5


def test_what_cargo_is_told_does_not_name_this_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A flag that does would have every crate compiled anew where the folder was moved."""
    monkeypatch.setenv("CARGO_HOME", str(tmp_path))
    assert str(ROOT) not in build.without_paths() and str(tmp_path) in build.without_paths()


def test_a_failing_command_stops_the_job_and_shows_its_log(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fly.stages.LOGS", tmp_path)
    with pytest.raises(StageError, match="exit code 3"):
        run([sys.executable, "-c", "print('the reason'); raise SystemExit(3)"], log="failing")
    assert "the reason" in capsys.readouterr().err


def test_a_missing_program_is_named() -> None:
    with pytest.raises(StageError, match="no-such-program"):
        run(["no-such-program"])


def test_a_full_disk_is_told_before_the_work(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """What lies there already is not asked for again, and of the disk of temporary files less is."""
    free = {ROOT: 3.26, Path(tempfile.gettempdir()): 1.2}
    monkeypatch.setattr(room, "free_in", free.__getitem__)
    monkeypatch.setattr(room, "taken_by", lambda folder: 0.0)
    room.ask_for(3.0, 1.0, "the tests")
    told = r"^the tests take {} GB of disk, and {} has {} GB left\.$"
    with pytest.raises(StageError, match=told.format(r"7\.0", ROOT, r"3\.3")):
        room.ask_for(7.0, 1.0, "the tests")
    with pytest.raises(StageError, match=told.format(r"1\.5", tempfile.gettempdir(), r"1\.2")):
        room.ask_for(3.0, 1.5, "the tests")
    monkeypatch.setattr(room, "taken_by", lambda folder: 2.0)
    room.ask_for(7.0, 1.0, "the tests")
    free[ROOT] = 0.4
    with pytest.raises(StageError, match=told.format(r"0\.5", ROOT, r"0\.4")):
        room.ask_for(3.0, 1.0, "the tests")


def test_a_file_with_two_names_is_counted_once(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "one").write_bytes(bytes(3000))
    (tmp_path / "folder" / "other").hardlink_to(tmp_path / "one")
    (tmp_path / "folder" / "third").write_bytes(bytes(500))
    assert room.taken_by(tmp_path) == pytest.approx(3.5e-6)
    assert room.taken_by(tmp_path / "none") == 0.0


def test_a_stamp_sees_every_change(tmp_path: Path) -> None:
    one, mark = tmp_path / "one", tmp_path / "stamp"
    one.write_bytes(b"1")
    stamp.write(mark, stamp.digest([one], "word"))
    assert stamp.is_fresh(mark, stamp.digest([one], "word"))
    assert not stamp.is_fresh(mark, stamp.digest([one], "words"))
    one.write_bytes(b"2")
    assert not stamp.is_fresh(mark, stamp.digest([one], "word"))
    assert not stamp.is_fresh(tmp_path / "none", stamp.digest([one], "word"))


def test_fmus_are_those_that_the_design_names(tmp_path: Path) -> None:
    """A vehicle may be called something_plant, and other FMUs may lie about."""
    (tmp_path / FIGURES).write_text('{"fmu_identifier": "hydro_plant"}', encoding="utf-8")
    for name in ("hydro_plant.fmu", "hydro_plant_plant.fmu", "hydro_plant_controller.fmu", "other_plant.fmu"):
        (tmp_path / name).touch()
    packages = Packages.found_in(tmp_path)
    assert packages.vehicle == "hydro_plant"
    names = [path.name for path in packages.fmus]
    assert names == ["hydro_plant_plant.fmu", "hydro_plant_controller.fmu", "hydro_plant.fmu"]


@pytest.mark.parametrize("text", [None, "{", "[]", '{"vehicle": "squid"}'])
def test_a_folder_without_design_is_told(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / FIGURES).write_text(text, encoding="utf-8")
    with pytest.raises(StageError, match="squid design"):
        Packages.found_in(tmp_path)


def test_figures_of_a_known_response() -> None:
    """A second-order system with damping 0.5 overshoots by exp(-pi/sqrt(3)) = 16.3 %, and leaves 2 % last at 8.08 s.

    The test in `crates/flight/src/metrics.rs` is of the same response: the two programs call the same thing settled.
    """
    time = np.arange(0.0, 40.0, 0.01)
    late = np.clip(time - 5.0, 0.0, None)
    damped = np.sqrt(0.75)
    wave = np.exp(-0.5 * late) * (np.cos(damped * late) + 0.5 / damped * np.sin(damped * late))
    reference = np.where(time >= 5.0, 0.2, 0.0)
    (step,) = figures.steps(time, 0.2 * (1.0 - wave), reference)
    assert step.time == pytest.approx(5.0)
    assert step.height == pytest.approx(0.2)
    assert step.overshoot == pytest.approx(np.exp(-np.pi / np.sqrt(3.0)), abs=1e-4)
    assert step.settling_time == pytest.approx(8.08, abs=0.01)
    assert step.steady_error < 1e-5


def test_figures_of_a_response_that_does_not_settle() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    (step,) = figures.steps(time, np.zeros_like(time), np.where(time >= 5.0, 0.2, 0.0))
    assert step.settling_time == float("inf")
    assert step.steady_error == pytest.approx(1.0)


def test_a_step_that_does_not_settle_is_told_in_words() -> None:
    told = flight.describe(figures.StepFigures(10.0, np.deg2rad(10.0), 0.05, float("inf"), 0.1))
    assert told == "+10.0 deg: overshoot 5.0 %, never within 2 %"


def test_a_flight_ends_at_the_surface() -> None:
    """A millimetre above it is rounding; time and speed are told."""
    signals = {"time": np.arange(4.0), "depth": np.array([0.0, -5e-4, -0.02, 1.0]), "speed": np.full(4, 2.5)}
    wet, row = figures.until_surface(signals)
    assert row == 2 and wet["time"].tolist() == [0.0, 1.0]
    assert flight.surface_lines(signals, row)[0][1].startswith("reached at 2.00 s with 2.50 m/s")
    assert flight.surface_lines(wet, figures.until_surface(wet)[1]) == []


def test_worst_error_leaves_out_what_follows_an_event() -> None:
    time = np.arange(0.0, 10.0, 0.5)
    error = np.where((time >= 2.0) & (time < 4.0), 5.0, 0.1)
    assert figures.worst_error_after(time, error, [2.0], 2.0) == pytest.approx(0.1)
    assert figures.worst_error_after(time, error, [], 2.0) == pytest.approx(5.0)


def test_worst_error_after_a_step_is_not_from_before_it() -> None:
    """The summary says 'later than 10 s after a step': what a flight begins with is no answer to that."""
    time = np.arange(0.0, 30.0, 0.5)
    error = np.where(time < 5.0, 3.0, 0.01)
    assert figures.worst_error_after(time, error, [10.0], 10.0) == pytest.approx(0.01)
    assert figures.worst_error_after(time, error, [10.0, 15.0], 10.0) == pytest.approx(0.01)
    assert figures.worst_error_after(time, error, [25.0], 10.0) is None


def test_record_reads_what_fmpy_writes(tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    path.write_text('"time","a","flag"\n0.0,1e-17,False\n0.5,-2.25,True\n', encoding="utf-8")
    signals = record.read(path)
    assert list(signals) == ["time", "a", "flag"]
    assert signals["a"].tolist() == [1e-17, -2.25]
    assert signals["flag"].tolist() == [0.0, 1.0]


def test_differences_are_relative_to_large_signals() -> None:
    one = {"time": np.zeros(2), "a": np.array([0.0, 0.5]), "b": np.array([0.0, 200.0]), "c": np.zeros(2)}
    other = {"time": np.ones(2), "a": np.array([0.0, 0.4]), "b": np.array([0.0, 199.0])}
    assert record.differences(one, other) == pytest.approx({"a": 0.1, "b": 0.005})
