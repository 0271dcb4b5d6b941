"""The command `squid`: reproducible packages, and misuse answered with one clear message."""

from __future__ import annotations

import filecmp
import json
import os
import re
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import pytest
from conftest import (
    PITCHING,
    SQUID,
    Run,
    designed,
    masked,
    messages,
    mistakes,
    named,
    once,
    package,
    refusal,
    without_uncertainty,
)
from fly import build
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change


def line_of(path: Path, text: str) -> int:
    """Return the number of the first line that contains a text."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return 1 + next(index for index, line in enumerate(lines) if text in line)


def spoil(path: Path, old: str, new: str) -> int:
    """Replace a text once, in which `*` is any number, and return its line number."""
    text = path.read_text(encoding="utf-8")
    found = re.search(re.escape(old).replace(r"\*", r"[\d.]+"), text)
    assert found
    path.write_text(text[: found.start()] + new + text[found.end() :], encoding="utf-8")
    return line_of(path, new.strip())


def refused(run_squid: Run, vehicle: Path, out: Path, *options: str) -> subprocess.CompletedProcess:
    """Run `squid design --json`, which must fail and write nothing."""
    done = run_squid("design", vehicle, "--no-advise", "--out", out, "--json", *options)
    assert done.returncode not in (0, 101), done.stderr
    assert not out.exists() or not list(out.iterdir()), "nothing is half-written"
    return done


def test_packages_from_another_place_are_the_same_to_the_byte(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Neither the name of the directory nor the time changes the bytes; tested with the paper's design, which is small.

    The last line names the command of the full report, which is not computed or written.
    """
    shutil.copy(copied_vehicle / "paper.toml", copied_vehicle / "design.toml")
    moved = Path(shutil.copytree(copied_vehicle, tmp_path / "elsewhere" / "moved"))
    made_from = [build.squid(), *build.binaries(), *sorted(copied_vehicle.glob("*.toml"))]
    first = Packages.found_in(
        once(made_from, ["packed"], lambda folder: package(run_squid, copied_vehicle, folder))
    )
    copied = package(run_squid, moved, tmp_path / "copied")
    printed = (copied.folder / "package.txt").read_text(encoding="utf-8")
    assert named(printed.splitlines()[-1], TMP=tmp_path) == snapshot
    assert "Robust stability" not in printed
    assert not list(copied.folder.glob("report*")) and not (copied.folder / "figures").exists()
    for one, other in zip(first.fmus, copied.fmus, strict=True):
        assert filecmp.cmp(one, other, shallow=False), one.name


def test_unknown_directory(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    done = refused(run_squid, tmp_path / "nowhere", tmp_path / "out")
    refusal(done, "no_vehicle")
    assert messages(done, TMP=tmp_path) == snapshot


def test_unknown_design(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    done = refused(run_squid, SQUID, tmp_path / "out", "--design", "no_such_design")
    refusal(done, "no_design")
    assert messages(done) == snapshot


@pytest.mark.parametrize(
    ("file", "old", "new", "key"),
    [
        ("vehicle.toml", "\nZ_uw = ", "\nZ_wu = ", "lift.Z_wu"),
        ("vehicle.toml", "\nlag = ", "\nlagg = ", "thruster.lagg"),
        ("design.toml", "\nback_off = ", "\nbackoff = ", "synthesis.backoff"),
        ("design.toml", "\nspeed_min = ", "\nspeed_minimum = ", "model.speed_minimum"),
    ],
)
def test_misspelt_key(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, file: str, old: str, new: str, key: str
) -> None:
    line = spoil(copied_vehicle / file, old, new)
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert refusal(done, "file")["file"] == str(copied_vehicle / file)
    assert (line, key) in mistakes(done)


@pytest.mark.parametrize(
    ("file", "old", "new", "key"),
    [
        (
            "vehicle.toml",
            'unit = "kg", source = "derived from geometry: displaced',
            'unit = "lb", source = "',
            "mass.mass",
        ),
        ("vehicle.toml", "X_u_dot = { value = -", "X_u_dot = { value = ", "added_mass.X_u_dot"),
        ("vehicle.toml", "mass = { value = 66.7", 'mass = { value = "heavy", x = 66.7', "mass.mass.value"),
        ("design.toml", "back_off = *", "back_off = -0.1", "synthesis.back_off"),
        ("design.toml", "speeds = 26", "speeds = 2", "model.speeds"),
        ("design.toml", "speed_max = 3.0", "speed_max = 0.4", "model.speed_max"),
        ("design.toml", "peak = *  ", "peak = 0.0  ", "track.peak"),
        ("design.toml", "bandwidth = *   ", "bandwidth = inf   ", "track.bandwidth"),
        ("design.toml", "steady_error = * ", "steady_error = 1.0  ", "track.steady_error"),
        ("design.toml", "scale = 10.0", "scale = 0.0", "track.scale"),
        ("design.toml", "weight = *", "weight = 0.0", "control.weight"),
        ("design.toml", 'output = "pitch"', 'output = "roll"', "track.output"),
        ("design.toml", 'signal = "pitch_rate"', 'signal = "roll_rate"', "measure.signal"),
        ("design.toml", "sample_time = 0.02", "sample_time = nan", "autopilot.sample_time"),
        ("design.toml", "[model]", "[model", "not_toml"),
        # Weights have no numerator and denominator, so that none can be improper.
        ("design.toml", "peak = *  ", "numerator = [1.0, 0.0]  ", "track.numerator"),
        # A name that would be a path.
        ("vehicle.toml", 'name = "squid"', 'name = "../escape"', "vehicle.name"),
    ],
)
def test_value_that_is_not_allowed(
    run_squid: Run,
    copied_vehicle: Path,
    tmp_path: Path,
    file: str,
    old: str,
    new: str,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    line = spoil(copied_vehicle / file, old, new)
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert refusal(done, "file")["file"] == str(copied_vehicle / file)
    assert (line, key) in mistakes(done)
    assert messages(done, VEHICLE=copied_vehicle) == snapshot


def test_mass_matrix_that_is_not_positive_definite(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    spoil(copied_vehicle / "vehicle.toml", "Z_q_dot = { value = -0.96", "Z_q_dot = { value = -300.96")
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    (mistake,) = refusal(done, "file")["mistakes"]
    assert mistake["problem"] == "mass_matrix_not_positive_definite" and mistake["least_eigenvalue"] < 0.0
    assert masked(messages(done, VEHICLE=copied_vehicle)) == snapshot


def test_range_of_speeds_that_the_vehicle_cannot_fly(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    spoil(copied_vehicle / "design.toml", "speed_max = 3.0", "speed_max = 30.0")
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    refusal(done, "trim")
    assert masked(messages(done)) == snapshot


def test_model_of_the_speed_without_its_frequency(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A missing key is reported at the table that lacks it."""
    path = copied_vehicle / "design.toml"
    spoil(path, "\nfrequency = 1.2\n", "\n")
    line = line_of(path, 'output = "speed"') - 1
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert mistakes(done) == [(line, "track.frequency")]
    assert messages(done, VEHICLE=copied_vehicle) == snapshot


def test_all_mistakes_of_a_file_in_one_run(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """All mistakes are reported, one line each with file and line, in the order of the file, in one plain sentence."""
    path = copied_vehicle / "design.toml"
    expected = [
        (spoil(path, old, new), key)
        for old, new, key in (
            ("speeds = 26", "speeds = 26.5", "model.speeds"),
            ("depth = 50.0", 'depth = "deep"', "model.depth"),
            ('output = "speed"', 'output = "roll"', "track.output"),
            ("back_off = *", "backoff = 0.1", "synthesis.backoff"),
            ("speed_to = 2.9", "speed_to = 3.5", "manoeuvre.speed_to"),
        )
    ]
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert mistakes(done) == expected
    assert messages(done, VEHICLE=copied_vehicle) == snapshot


@pytest.mark.parametrize(
    ("lines", "at", "key"),
    [
        (["autority = 0.9"], 1, "autority"),
        (["authority = 0"], 1, "authority"),
        (["authority = 2"], 1, "authority"),
        (['unit = "deg"', "pitch = 20.0"], 2, "pitch"),
        (['unit = "deg"', 'pitch = "up"'], 2, "pitch"),
        (['unit = "deg"', "pitch = [5, -10]"], 2, "pitch"),
        (['unit = "deg"', "pitch = [-10, 80]"], 2, "pitch"),
        (['unit = "deg"', "path_angle = 80"], 2, "path_angle"),
        (["pitch = [-10, 5]"], 0, "unit"),
    ],
)
def test_an_envelope_that_cannot_be(
    run_squid: Run,
    copied_vehicle: Path,
    tmp_path: Path,
    lines: list[str],
    at: int,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    said = refuses_table(
        run_squid, copied_vehicle, tmp_path / "out", ["[envelope]", *lines], at, f"envelope.{key}"
    )
    assert said == snapshot


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("stale = 1", "stale"),
        ("stale_after = -1", "stale_after"),
        ('safe = "surface"', "safe"),
        ('speed = { resolution = -1, unit = "m/s" }', "speed.resolution"),
        ("heave = { period = 1 }", "heave"),
    ],
)
def test_a_failsafe_that_cannot_be(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, line: str, key: str, snapshot: SnapshotAssertion
) -> None:
    said = refuses_table(
        run_squid, copied_vehicle, tmp_path / "out", ["[failsafe]", line], 1, f"failsafe.{key}"
    )
    assert said == snapshot


def refuses_table(run_squid: Run, vehicle: Path, out: Path, lines: list[str], at: int, key: str) -> str:
    """Check for one mistake, at the line of the key, or of the table that lacks it; return the message."""
    path = vehicle / "design.toml"
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" + "".join(f"{line}\n" for line in lines))
    done = refused(run_squid, vehicle, out)
    assert mistakes(done) == [(line_of(path, lines[0]) + at, key)]
    return messages(done, VEHICLE=vehicle)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("weight = { value = 654.8", "weight = { value = 66.7"),
        ("mass = { value = 66.7", "mass = { value = 147.1"),
    ],
    ids=["weight in kg", "mass in pounds"],
)
def test_weight_that_is_not_that_of_the_mass(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, old: str, new: str, snapshot: SnapshotAssertion
) -> None:
    path = copied_vehicle / "vehicle.toml"
    spoil(path, old, new)
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    assert mistakes(done) == [(line_of(path, "weight = {"), "mass_and_weight")]
    assert masked(messages(done, VEHICLE=copied_vehicle)) == snapshot


def test_files_that_are_no_text(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    said = []

    def refuses(key: str) -> None:
        done = refused(run_squid, copied_vehicle, tmp_path / "out")
        refusal(done, key)
        said.append(messages(done, VEHICLE=copied_vehicle))

    path = copied_vehicle / "design.toml"
    text = path.read_text(encoding="utf-8")
    path.write_bytes(text.encode("utf-16"))
    refuses("encoding")
    path.write_bytes(text.replace("Follows", "Schl\u00fcssel").encode("latin-1"))
    refuses("encoding")
    line = 1 + text[: text.index("Follows")].count("\n")
    assert said[-1].startswith(f"squid: VEHICLE/design.toml:{line}: ")
    path.unlink()
    path.mkdir()
    refuses("folder")
    assert "".join(said) == snapshot


def test_flight_that_leaves_the_water(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The flight ends at the surface, with time and speed; nothing is recorded or plotted beyond."""
    shutil.copy(copied_vehicle / "paper.toml", copied_vehicle / "design.toml")
    spoil(copied_vehicle / "design.toml", "depth = 50.0", "depth = 1.0")
    done = run_squid("simulate", copied_vehicle, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    surfaced = [one for one in json.loads(done.stdout)["warnings"] if one["kind"] == "surfaced"]
    assert masked("\n".join(one["why"] for one in surfaced)) == snapshot
    end = surfaced[0]["value"]
    names, *rows = (tmp_path / "out" / "flight.csv").read_text(encoding="utf-8").splitlines()
    column = names.split(",").index("depth [m]")
    assert min(float(row.split(",")[column]) for row in rows) >= -1e-3
    assert float(rows[-1].split(",")[0]) == pytest.approx(end - 0.02, abs=0.006)
    assert "inf" not in done.stdout and "NaN" not in done.stdout


def test_modes_beyond_the_sampling_rate(run_squid: Run) -> None:
    """A fifth of 2 pi/0.02 s is 62.8 rad/s; the default design stays below."""
    made = [designed(run_squid, SQUID, *bandwidth) for bandwidth in ((), ("--bandwidth", "3"))]
    printed = [(folder / "design.txt").read_text(encoding="utf-8") for folder in made]
    assert all("WARNING" not in words for words in printed)
    gone = re.search(r"(\d+) rad/s.* too fast", printed[1])
    assert gone and float(gone[1]) > 62.8
    # The controller without them is the one that is proved.
    found = json.loads((made[1] / "design.json").read_text(encoding="utf-8"))
    assert found["certified"] and found["fastest_controller_mode"] <= 62.8


def test_negative_numbers_on_the_command_line(run_squid: Run, snapshot: SnapshotAssertion) -> None:
    """Negative numbers are read as numbers, and no other notation is suggested."""
    done = run_squid("design", SQUID, "--bandwidth", "-1", "--json")
    refusal(done, "argument", 64)
    assert messages(done) == snapshot
    shown = json.loads(run_squid("show", SQUID, "--speed", "-1", "--json").stdout)
    assert shown["at_speed"]["trim"]["speed"] == -1.0


def test_zero_has_no_sign(run_squid: Run, copied_vehicle: Path) -> None:
    """A nearly neutral vehicle flies level with an incidence of -2e-5 deg."""
    path = copied_vehicle / "vehicle.toml"
    spoil(path, "buoyancy = { value = 658.1606198442163", "buoyancy = { value = 654.82403")
    spoil(path, "buoyancy_gradient = { value = 0.00124998333411", "buoyancy_gradient = { value = 0.0")
    spoil(path, "M_uu = { value = 0.15", "M_uu = { value = 0.0")
    done = run_squid("show", copied_vehicle, "--speed", "1")
    assert done.returncode == 0 and re.search(r"incidence = pitch +0\.0000 deg", done.stdout), done.stdout


@pytest.mark.parametrize("bandwidth", ["0", "inf", "-1", "nan"])
def test_bandwidth_on_the_command_line(run_squid: Run, tmp_path: Path, bandwidth: str) -> None:
    refusal(refused(run_squid, SQUID, tmp_path / "out", f"--bandwidth={bandwidth}"), "argument", 64)
    assert not (tmp_path / "out").exists()


def test_vehicle_called_plant(run_squid: Run, quick_vehicle: Path, tmp_path: Path) -> None:
    """The name ends like those of FMUs: the three are found by the name in design.json."""
    vehicle = shutil.copytree(quick_vehicle, tmp_path / "vehicle")
    spoil(vehicle / "vehicle.toml", 'name = "squid"', 'name = "hydro_plant"')
    packages = package(run_squid, vehicle, tmp_path / "out")
    assert packages.vehicle == "hydro_plant"
    assert {path.name for path in (tmp_path / "out").glob("*.fmu")} == {path.name for path in packages.fmus}


@pytest.mark.parametrize("name", ["pitch", "time", "mass", "upper_port_output"])
def test_actuator_with_the_name_of_a_variable(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, name: str, snapshot: SnapshotAssertion
) -> None:
    spoil(copied_vehicle / "vehicle.toml", 'name = "upper_starboard"', f'name = "{name}"')
    done = refused(run_squid, copied_vehicle, tmp_path / "out")
    refusal(done, "actuator_name")
    assert messages(done, VEHICLE=copied_vehicle) == snapshot


def test_lags_that_no_sample_time_can_mend(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A design that ignores lags that destabilise the loop is refused; one that includes them is possible.

    The model of pitch is then as slow as the actuators.
    """
    vehicle = without_uncertainty(SQUID, tmp_path / "vehicle")
    for _ in range(3):
        spoil(vehicle / "vehicle.toml", "lag = { value = 0.2", "lag = { value = 10.0")
    spoil(vehicle / "design.toml", "\nlags = true", "\nlags = false")
    done = refused(run_squid, vehicle, tmp_path / "out")
    refusal(done, "refused")
    assert masked(messages(done)) == snapshot
    spoil(vehicle / "design.toml", "\nlags = false", "\nlags = true")
    spoil(vehicle / "design.toml", "\nfrequency = *\n", "\nfrequency = 0.1\n")
    spoil(vehicle / "design.toml", "\n# anti_windup = true", "\nanti_windup = false")
    assert (designed(run_squid, vehicle) / "controller.json").is_file()


def test_package_before_design(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    done = run_squid("package", SQUID, "--out", tmp_path / "empty", "--json")
    refusal(done, "not_designed")
    assert messages(done, TMP=tmp_path) == snapshot
    assert not list(tmp_path.rglob("*.fmu"))


def test_package_of_a_changed_vehicle(
    run_squid: Run, copied_vehicle: Path, stored_design: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A design that belongs to an earlier state of the files is not packaged."""
    done = run_squid("package", copied_vehicle, "--out", stored_design)
    assert done.returncode == 0, done.stderr
    for fmu in stored_design.glob("*.fmu"):
        fmu.unlink()
    spoil(copied_vehicle / "vehicle.toml", "z_G = { value = 0.03", "z_G = { value = 0.031")
    done = run_squid("package", copied_vehicle, "--out", stored_design, "--json")
    refusal(done, "stale")
    assert messages(done, TMP=tmp_path) == snapshot
    assert not list(stored_design.glob("*.fmu"))


def test_unwritable_output(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    done = run_squid("design", SQUID, "--out", blocked / "out", "--json")
    refusal(done, "unwritable")
    assert messages(done, TMP=tmp_path) == snapshot


@pytest.mark.parametrize("verb", [[], ["design"], ["package"], ["export"], ["simulate"], ["show"], ["plot"]])
def test_help_teaches(run_squid: Run, verb: list[str]) -> None:
    done = run_squid(*verb, "--help")
    assert done.returncode == 0
    assert len(done.stdout.splitlines()) > 8
    assert "Usage" in done.stdout


@pytest.mark.parametrize("columns", [60, 80, 160])
@pytest.mark.parametrize(
    "verb", [[], ["design"], ["package"], ["show"], ["verify"], ["lpv", "synth"], ["lpv", "mu"]]
)
def test_help_is_as_wide_as_the_terminal(squid_command: Path, verb: list[str], columns: int) -> None:
    """Text is wrapped at the width of the terminal, except the examples, which have one line each."""
    environment = {**os.environ, "COLUMNS": str(columns)}
    done = subprocess.run(
        [squid_command, *verb, "--help"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= columns
    for line, following in pairwise(lines):
        if line[:1].strip() and following[:1].strip() and not line.endswith(":"):
            assert len(f"{line} {following.split()[0]}") > columns, "the next word has room"
    examples = [line for line in lines if line.startswith("  squid ")]
    shown = [line.split()[1] for line in examples]
    assert verb or shown == ["show", "design", "simulate", "package", "export"]


def test_design_prints_each_stage(run_squid: Run, quick_vehicle: Path, tmp_path: Path) -> None:
    done = run_squid("design", quick_vehicle, "--no-advise", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    for stage in ("vehicle", "trim", "linearise", "fit", "LFT", "augment", "synthesise", "check"):
        assert re.search(rf"^{stage}\s+\S", done.stdout, re.MULTILINE), stage
    assert "SURROGATE" in done.stdout


@pytest.mark.parametrize("design", ["design", "paper"])
def test_ladder_of_gammas(run_squid: Run, squid_by_errors: Path, tmp_path: Path, design: str) -> None:
    """Each additional freedom of the speed costs: gammas increase down both lists, up to their accuracy of 0.2 %.

    The loops are small, with controllers of tracking errors only: others take minutes.
    """
    vehicle = Path(shutil.copytree(squid_by_errors, tmp_path / "vehicle"))
    shutil.copy(SQUID / "paper.toml", vehicle)
    made = designed(run_squid, vehicle, "--design", design, "--ladder")
    printed = (made / "design.txt").read_text(encoding="utf-8")
    assert "CONTRADICTION" not in printed and "unknown" not in printed
    # The lists come last, each in a paragraph, before that with the time.
    best, loop = (gammas(part.splitlines()) for part in printed.split("\n\n")[-3:-1])
    alone, scheduled, bounded_rate = best[:6], best[6:8], best[8:]
    assert (len(alone), len(scheduled), len(bounded_rate), len(loop)) == (6, 2, 4, 7)
    for lower, upper in pairwise([max(alone), *bounded_rate, *scheduled]):
        assert lower <= 1.002 * upper
    for lower, upper in pairwise(loop):
        assert lower <= 1.002 * upper
    proved = re.search(r"PROVED .* gain below ([\d.]+)", printed)
    assert proved and float(proved[1]) == pytest.approx(loop[-1], abs=1e-4)


def gammas(lines: list[str]) -> list[float]:
    """Return the gammas of a part of the ladder: numbers of four decimals, one per line."""
    return [float(found[1]) for line in lines if (found := re.search(r" (\d+\.\d{4})(?!\d)", line))]


def test_sample_time_that_is_too_long(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """A controller whose sampled loop is unstable is refused, with the speed and the change that helps.

    REMUS 100 is unstable without control, with a time constant below 3 s; one tick per second is too slow for it.
    """
    vehicle = tmp_path / "vehicle"
    shutil.copytree(PITCHING, vehicle)
    spoil(vehicle / "design.toml", "sample_time = 0.02", "sample_time = 1.0")
    done = refused(run_squid, vehicle, tmp_path / "out")
    refusal(done, "refused")
    assert masked(messages(done)) == snapshot


def test_reader_that_goes_away(squid_command: Path, quick_vehicle: Path, tmp_path: Path) -> None:
    """`squid design | head` still writes the complete design, without an alarming message."""
    out = tmp_path / "out"
    words = [str(squid_command), "design", str(quick_vehicle), "--out", str(out)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        error = process.stderr.read().decode()
        assert process.wait(timeout=120) == 0
    assert "panicked" not in error
    assert (out / "controller.json").is_file()
