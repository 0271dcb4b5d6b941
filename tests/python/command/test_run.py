"""The commands of run.py, as far as they can be tested without running them completely."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from conftest import Run, messages, named, refusal
from flights import figures_of
from fly import fix, flight, libraries, package, platforms, record, room, stamp
from fly.package import FIGURES, Packages
from fly.stages import BUILD, ROOT, StageError, run
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change


@pytest.mark.parametrize(
    "words", [["--help"], *([verb, "--help"] for verb in ("fly", "wheels", "test", "fix"))]
)
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
    assert sum(line.startswith("  python3 run.py ") for line in lines) == 7


WORDS = " ".join(f"word{index}" for index in range(30))


@pytest.mark.parametrize("mark", ["", "- ", "  - ", "12. ", "> "])
def test_long_prose_is_wrapped(mark: str) -> None:
    """Prose is wrapped at 120 columns with the same words; a second run changes nothing."""
    text = f"# Title\n\n{mark}{WORDS} {WORDS}\n\nshort\nlines\n"
    wrapped = fix.wrap(text)
    lines = wrapped.splitlines()
    assert max(map(len, lines)) <= 120 < max(map(len, text.splitlines()))
    assert wrapped.replace(">", "").split() == text.replace(">", "").split()
    assert lines[2].startswith(mark) and lines[-2:] == ["short", "lines"]
    inside = lines[3:-3]
    assert inside and all(line.startswith(mark if mark == "> " else " " * len(mark)) for line in inside)
    assert fix.wrap(wrapped) == wrapped


@pytest.mark.parametrize(
    "kept",
    [
        f"| {WORDS} |",
        f"# {WORDS}",
        f"```text\n{WORDS}\n```",
        f"~~~\n- {WORDS}\n~~~",
        f"    {WORDS}",
        f"![picture]({WORDS})",
        f"[link]: {WORDS}",
    ],
)
def test_what_is_no_prose_is_not_wrapped(kept: str) -> None:
    assert len(WORDS) > 120
    assert fix.wrap(f"{kept}\n\nprose\n") == f"{kept}\n\nprose\n"


@pytest.mark.parametrize("word", ["-", "+", "3.", "#", "|", ">"])
def test_wrapping_makes_no_list_or_heading(word: str) -> None:
    """No wrapped line starts with text that Markdown reads as markup."""
    for length in range(100, 125):
        lines = fix.wrap(f"{'x' * 60} {'y' * (length - 61)} {word} {WORDS}\n").splitlines()
        assert max(map(len, lines)) <= 120
        assert not any(line.startswith(f"{word} ") for line in lines)


def test_the_pages_are_as_fix_leaves_them() -> None:
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        text = (ROOT / name).read_text(encoding="utf-8")
        assert fix.wrap(text) == text, f"{name}: run `python3 run.py fix`"


def test_what_cargo_is_told_does_not_name_this_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A flag with the path would recompile every crate after the folder was moved."""
    monkeypatch.setenv("CARGO_HOME", str(tmp_path))
    assert str(ROOT) not in libraries.without_paths() and str(tmp_path) in libraries.without_paths()


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


def test_a_full_disk_is_told_before_the_work(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Existing files need no space again, and the disk of temporary files needs less."""
    free = {ROOT: 3.26, Path(tempfile.gettempdir()): 1.2}
    monkeypatch.setattr(room, "free_in", free.__getitem__)
    monkeypatch.setattr(room, "taken_by", lambda folder: 0.0)
    room.ask_for(3.0, 1.0, "the tests")
    refused = []

    def refuse(build: float, temporary: float) -> None:
        with pytest.raises(StageError) as error:
            room.ask_for(build, temporary, "the tests")
        refused.append(named(str(error.value), TMP=Path(tempfile.gettempdir())))

    refuse(7.0, 1.0)
    refuse(3.0, 1.5)
    monkeypatch.setattr(room, "taken_by", lambda folder: 2.0)
    room.ask_for(7.0, 1.0, "the tests")
    free[ROOT] = 0.4
    refuse(3.0, 1.0)
    assert "\n".join(refused) == snapshot


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


def test_an_environment_is_made_once() -> None:
    """The user's Python and that of the tests, which is in another environment made of it, share one environment."""
    platforms.tools()
    (made,) = BUILD.glob("platforms-*/stamp")
    before = made.stat().st_mtime_ns
    version = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    words = [Path(sys.base_prefix) / "bin" / version, "-c", "from fly import platforms; platforms.tools()"]
    subprocess.run(words, env={**os.environ, "PYTHONPATH": str(ROOT / "tools")}, check=True)
    assert made.stat().st_mtime_ns == before


def test_fmus_are_those_that_the_design_names(tmp_path: Path) -> None:
    """A vehicle may be called something_plant, and other FMUs may be present."""
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


def test_the_main_job_ends_by_naming_plot_and_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    gammas = {"gamma_bound": 0.5, "gamma_optimum": 0.4, "back_off": 0.1, "gamma_bound_with_model_error": None}
    (tmp_path / FIGURES).write_text(json.dumps({"certified": True, **gammas}), encoding="utf-8")
    figures = {"speed_error": 0.1, "surface": None, "actuator_use": 0.5, "plot": tmp_path / "flight.svg"}
    flight.report(Packages(tmp_path, "squid"), figures, 1e-12, "cargo squid report somewhere")
    ending = "\n".join(capsys.readouterr().out.splitlines()[-2:])
    assert ending.replace(os.path.relpath(tmp_path), "TMP") == snapshot


@pytest.mark.parametrize("design", ["design", "paper"])
def test_the_command_of_the_whole_report_is_exact(
    run_squid: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, design: str
) -> None:
    """The command accepts the words after `cargo squid`: it only reports that the vehicle does not exist."""
    monkeypatch.chdir(ROOT)
    cargo, name, *words = shlex.split(
        package.report_of(package.Design(tmp_path / "no where", design), BUILD / "none")
    )
    assert (cargo, name) == ("cargo", "squid") and ("--design" in words) == (design != "design")
    done = run_squid(*words)
    assert done.returncode == 1 and "no where" in done.stderr and "Usage" not in done.stderr


def test_an_earlier_run_without_an_fmu_is_made_again(tmp_path: Path) -> None:
    (tmp_path / FIGURES).write_text('{"fmu_identifier": "squid"}', encoding="utf-8")
    packages = Packages.found_in(tmp_path)
    packages.plant.touch()
    assert package.made_before(tmp_path) is None
    for path in packages.fmus:
        path.touch()
    assert package.made_before(tmp_path) == packages


def test_a_step_that_does_not_settle_is_described(snapshot: SnapshotAssertion) -> None:
    step = {"height": np.deg2rad(10.0), "overshoot": 0.05, "settling_time": None}
    assert flight.describe(step, 0.02, np.rad2deg(1.0), "deg") == snapshot
    assert flight.describe({**step, "height": -1.5, "settling_time": 8.08}, 0.02, 1.0, "m") == snapshot


def test_a_flight_ends_at_the_surface(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """A millimetre above the surface is rounding; time and speed are reported, and figures end there."""
    signals = {name: np.zeros(4) for name in ("pitch", "pitch_reference_used", "speed_reference_used")}
    signals |= {"time": np.arange(4.0), "depth": np.array([0.0, -5e-4, -0.02, 1.0])}
    signals["speed"] = np.array([0.25, 0.5, 2.5, 9.0])
    figures = figures_of(run_squid, signals, tmp_path)
    assert figures["speed_error"] == 0.5 and figures["actuator_use"] is None and figures["pitch_steps"] == []
    assert flight.surface_lines(figures["surface"]) == snapshot
    wet = {name: column[:2] for name, column in signals.items()}
    assert flight.surface_lines(figures_of(run_squid, wet, tmp_path)["surface"]) == []
    (tmp_path / "flown.csv").write_text("time,depth,pitch,speed\n0,1,0,1\n", encoding="utf-8")
    done = run_squid("plot", tmp_path / "flown.csv", "--json")
    refusal(done, "record")
    assert messages(done, TMP=tmp_path) == snapshot


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
