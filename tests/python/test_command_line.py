"""The command `squid`: reproducible packages, and misuse answered in one clear message."""

from __future__ import annotations

import filecmp
import re
import subprocess
from pathlib import Path

import pytest
from conftest import Run, package
from fly.package import Packages
from fly.stages import ROOT

SQUID = ROOT / "vehicles" / "squid"


def line_of(path: Path, text: str) -> int:
    """Return the number of the first line that holds a text."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return 1 + next(index for index, line in enumerate(lines) if text in line)


def spoil(path: Path, old: str, new: str) -> int:
    """Replace a text once, and return the number of its line."""
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return line_of(path, new.strip())


def refused(run_squid: Run, vehicle: Path, out: Path, design: str = "design") -> str:
    """Run `squid design`, which must fail, write nothing, and say why in a message that is returned."""
    done = run_squid("design", vehicle, "--design", design, "--out", out)
    assert done.returncode not in (0, 101), done.stderr
    assert "panicked" not in done.stderr
    assert not out.exists() or not list(out.iterdir()), "nothing is half-written"
    assert done.stderr.strip()
    return done.stderr


def test_packages_are_reproducible_to_the_byte(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    again = package(run_squid, SQUID, tmp_path / "again")
    for one, other in zip(squid.fmus, again.fmus, strict=True):
        assert filecmp.cmp(one, other, shallow=False), one.name


def test_packages_from_another_place_are_the_same(
    squid: Packages, run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    """Neither the name of the directory nor the time matters."""
    copied = package(run_squid, copied_vehicle, tmp_path / "copied")
    for one, other in zip(squid.fmus, copied.fmus, strict=True):
        assert filecmp.cmp(one, other, shallow=False), one.name


def test_unknown_directory(run_squid: Run, tmp_path: Path) -> None:
    message = refused(run_squid, tmp_path / "nowhere", tmp_path / "out")
    assert "nowhere" in message
    assert len(message.strip().splitlines()) <= 3


def test_unknown_design(run_squid: Run, tmp_path: Path) -> None:
    assert "no_such_design.toml" in refused(run_squid, SQUID, tmp_path / "out", "no_such_design")


@pytest.mark.parametrize(
    ("file", "old", "new", "key"),
    [
        ("vehicle.toml", "\nZ_uw = ", "\nZ_wu = ", "Z_wu"),
        ("vehicle.toml", "\nlag = ", "\nlagg = ", "lagg"),
        ("design.toml", "\nback_off = ", "\nbackoff = ", "backoff"),
        ("design.toml", "\nspeed_min = ", "\nspeed_minimum = ", "speed_minimum"),
    ],
)
def test_misspelt_key(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, file: str, old: str, new: str, key: str
) -> None:
    line = spoil(copied_vehicle / file, old, new)
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert file in message
    assert key in message
    assert re.search(rf"\b{line}\b", message), message


@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        (
            "vehicle.toml",
            'unit = "kg", source = "derived from geometry: displaced',
            'unit = "lb", source = "',
            "lb",
        ),
        ("vehicle.toml", "X_u_dot = { value = -", "X_u_dot = { value = ", "X_u_dot"),
        ("vehicle.toml", "mass = { value = 66.7", 'mass = { value = "heavy", x = 66.7', "mass"),
        ("design.toml", "back_off = 0.1", "back_off = -0.1", "back_off"),
        ("design.toml", "speeds = 26", "speeds = 2", "speeds"),
        ("design.toml", "speed_max = 3.0", "speed_max = 0.4", "speed_max"),
        ("design.toml", 'output = "pitch"', 'output = "roll"', "roll"),
        ("design.toml", "sample_time = 0.02", "sample_time = nan", "sample_time"),
        ("design.toml", "[model]", "[model", "design.toml"),
    ],
)
def test_value_that_is_not_allowed(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, file: str, old: str, new: str, expected: str
) -> None:
    line = spoil(copied_vehicle / file, old, new)
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert file in message
    assert expected in message
    assert re.search(rf"\b{line}\b", message), message


def test_mass_matrix_that_is_not_positive_definite(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    spoil(copied_vehicle / "vehicle.toml", "z_G = { value = 0.03", "z_G = { value = 3.0")
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert "positive definite" in message


def test_range_of_speeds_that_the_vehicle_cannot_fly(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    spoil(copied_vehicle / "design.toml", "speed_max = 3.0", "speed_max = 30.0")
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert "m/s" in message


def test_package_before_design(run_squid: Run, tmp_path: Path) -> None:
    done = run_squid("package", SQUID, "--out", tmp_path / "empty")
    assert done.returncode != 0
    assert "design" in done.stderr
    assert not list(tmp_path.rglob("*.fmu"))


def test_package_of_a_changed_vehicle(run_squid: Run, copied_vehicle: Path, tmp_path: Path) -> None:
    """A design that belongs to an earlier state of the files is not packaged."""
    out = tmp_path / "out"
    package(run_squid, copied_vehicle, out)
    for fmu in out.glob("*.fmu"):
        fmu.unlink()
    spoil(copied_vehicle / "vehicle.toml", "z_G = { value = 0.03", "z_G = { value = 0.031")
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode != 0
    assert "vehicle file" in done.stderr
    assert not list(out.glob("*.fmu"))


def test_unwritable_output(run_squid: Run, tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a directory", encoding="utf-8")
    done = run_squid("design", SQUID, "--out", blocked / "out")
    assert done.returncode != 0
    assert "file" in done.stderr
    assert "panicked" not in done.stderr


@pytest.mark.parametrize("verb", [[], ["design"], ["package"], ["simulate"], ["show"], ["plot"]])
def test_help_teaches(run_squid: Run, verb: list[str]) -> None:
    done = run_squid(*verb, "--help")
    assert done.returncode == 0
    assert len(done.stdout.splitlines()) > 8
    assert "Usage" in done.stdout


def test_design_prints_each_stage(run_squid: Run, tmp_path: Path) -> None:
    done = run_squid("design", SQUID, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    for stage in ("vehicle", "trim", "linearise", "fit", "LFT", "augment", "synthesise", "check"):
        assert re.search(rf"^{stage}\s+\S", done.stdout, re.MULTILINE), stage
    assert "SURROGATE" in done.stdout


def test_sample_time_that_is_too_long(run_squid: Run, copied_vehicle: Path, tmp_path: Path) -> None:
    """A controller whose sampled loop is unstable is refused, with the speed and what to change."""
    spoil(copied_vehicle / "design.toml", "sample_time = 0.02", "sample_time = 1.0")
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert "sampled at 1 s" in message and "autopilot.sample_time" in message


def test_vehicle_name_that_leaves_the_folder(run_squid: Run, copied_vehicle: Path, tmp_path: Path) -> None:
    """A name that would be a path is refused, with file, line and key."""
    path = copied_vehicle / "vehicle.toml"
    line = spoil(path, 'name = "squid"', 'name = "../escape"')
    message = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert str(path) in message and str(line) in message and "vehicle.name" in message


def test_reader_that_goes_away(squid_command: Path, tmp_path: Path) -> None:
    """`squid design | head` still writes the whole design, and nothing frightening."""
    out = tmp_path / "out"
    words = [str(squid_command), "design", str(ROOT / "vehicles" / "squid"), "--out", str(out)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        error = process.stderr.read().decode()
        assert process.wait(timeout=120) == 0
    assert "panicked" not in error
    assert (out / "controller.json").is_file()
