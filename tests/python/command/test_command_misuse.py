"""Mistakes of users that must not succeed: overwriting files, solving another problem, simulating nonsense."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from conftest import REMUS100, SQUID, Run, messages, named, refusal
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

HEAD = "time,pitch,speed,depth,pitch_reference_used,speed_reference_used\n"
RECORD = HEAD + "0,0,1,9,0,1\n1,0.1,1,9,0.1,1\n2,0.1,1,9,0.1,1\n"


def contents(folder: Path) -> dict[Path, bytes]:
    """Return the contents of all files of a folder."""
    return {
        path: path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != ".squid-lock"
    }


@pytest.mark.parametrize("name", ["vehicle", "", "..", "a/b", "design.toml"])
def test_a_design_has_a_plain_name(
    run_squid: Run, copied_vehicle: Path, name: str, snapshot: SnapshotAssertion
) -> None:
    """Other names would write the design over the vehicle file, or outside its directory."""
    before = contents(copied_vehicle)
    for words in (
        ("tune", copied_vehicle, "--designs", "1", "--to", name),
        ("show", copied_vehicle, "--design", name),
    ):
        done = run_squid(*words, "--json")
        refusal(done, "usage", 64)
        assert messages(done) == snapshot
    assert contents(copied_vehicle) == before


def test_no_verb_replaces_the_design_of_another_vehicle(
    run_squid: Run, remus100: Packages, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Verbs that design if there is no design, or an outdated one, do not touch the files of others."""
    out = tmp_path / "out"
    out.mkdir()
    for path in remus100.folder.glob("*.json"):
        shutil.copy(path, out)
    before = contents(out)
    for verb in ("simulate", "campaign", "report", "package", "export"):
        done = run_squid(verb, SQUID, "--out", out, "--json")
        refusal(done, "other_design")
    assert messages(done, TMP=tmp_path) == snapshot
    assert contents(out) == before


def test_a_vehicle_of_the_same_name_replaces_no_design(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Two vehicles named `mine` in different places have the same default directory for their designs."""
    out = tmp_path / "out"
    one, other = (Path(shutil.copytree(quick_vehicle, tmp_path / name / "mine")) for name in "ab")
    assert run_squid("design", one, "--no-advise", "--out", out).returncode == 0
    before = contents(out)
    with (other / "vehicle.toml").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    for verb in ("design", "simulate", "report"):
        done = run_squid(verb, other, "--out", out, "--json")
        refusal(done, "other_vehicle")
    assert messages(done, TMP=tmp_path) == snapshot
    assert contents(out) == before
    # A directory that was moved is still that of the same vehicle.
    moved = one.rename(tmp_path / "moved")
    assert run_squid("design", moved, "--no-advise", "--out", out).returncode == 0
    renamed = moved / "vehicle.toml"
    renamed.write_text(renamed.read_text(encoding="utf-8").replace('name = "squid"', 'name = "octopus"'))
    done = run_squid("design", other, "--no-advise", "--out", out, "--json")
    assert str(moved) in refusal(done, "other_vehicle")["reason"]


def test_what_is_of_an_earlier_design_is_removed(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """FMUs and SSP are removed with the controller that they contain; an unchanged design keeps them."""
    vehicle, out = Path(shutil.copytree(quick_vehicle, tmp_path / "vehicle")), tmp_path / "out"
    design = ("design", vehicle, "--no-advise", "--out", out)
    assert run_squid(*design).returncode == 0
    assert run_squid("export", vehicle, "--out", out).returncode == 0
    packed = [out / name for name in ("squid.fmu", "squid_plant.fmu", "squid_controller.fmu", "squid.ssp")]
    for path in (*packed, out / "other.fmu"):
        path.write_bytes(b"earlier")
    done = run_squid(*design)
    assert done.returncode == 0 and all(path.is_file() for path in packed)
    assert not [line for line in done.stdout.splitlines() if str(packed[0]) in line]
    path = vehicle / "design.toml"
    path.write_text(path.read_text(encoding="utf-8").replace("back_off = 0.", "back_off = 0.2", 1))
    done = run_squid(*design)
    assert done.returncode == 0, done.stderr
    assert not any(path.exists() for path in packed) and (out / "other.fmu").is_file()
    removed = [
        line for line in done.stdout.splitlines() if any(str(path) in line for path in (*packed, out / "c"))
    ]
    assert named("\n".join(removed), TMP=tmp_path) == snapshot


def test_an_old_design_is_made_again_and_said_to_be(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """An outdated design is replaced unless it has a proof that a design without options does not make."""
    vehicle, out = tmp_path / "vehicle", tmp_path / "out"
    shutil.copytree(quick_vehicle, vehicle)
    assert run_squid("design", vehicle, "--no-advise", "--out", out).returncode == 0
    before = (out / "design.json").stat().st_mtime_ns
    with (vehicle / "design.toml").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    more = out / "constant_certificate.json"
    more.write_text("{}", encoding="utf-8")
    done = run_squid("simulate", vehicle, "--out", out, "--json")
    refusal(done, "stale")
    more.unlink()
    again = run_squid("simulate", vehicle, "--out", out)
    assert again.returncode == 0, again.stderr
    note, *_ = again.stdout.splitlines()
    assert named(f"{done.stderr}{note}", TMP=tmp_path) == snapshot
    assert (out / "design.json").stat().st_mtime_ns > before


def test_a_plot_overwrites_plots_alone(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    record = tmp_path / "flight.csv"
    record.write_text(RECORD, encoding="utf-8")
    shutil.copy(record, tmp_path / "flight.svg")
    before = contents(tmp_path) | contents(copied_vehicle)
    for to in (record, tmp_path / "flight.svg", copied_vehicle / "vehicle.toml"):
        done = run_squid("plot", record, "--out", to, "--json")
        refusal(done, "argument", 64)
        assert messages(done, TMP=tmp_path) == snapshot
    assert contents(tmp_path) | contents(copied_vehicle) == before
    for _ in range(2):
        assert run_squid("plot", record, "--out", tmp_path / "new.svg").returncode == 0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2,0.1,1", "0.5,0.1,1"),
        ("2,0.1,1", "2,nan,1"),
        ("time,pitch,speed", "time,pitch,pitch [rad]"),
        ("1,0.1,1,9,0.1,1\n2,0.1,1,9,0.1,1\n", "0,0.1,1,9,0.1,1\n"),
    ],
    ids=["time goes back", "no number", "two columns of a name", "time stands still"],
)
def test_what_is_no_record_of_a_flight(
    run_squid: Run, tmp_path: Path, old: str, new: str, snapshot: SnapshotAssertion
) -> None:
    record = tmp_path / "flight.csv"
    assert RECORD.count(old) == 1
    record.write_text(RECORD.replace(old, new), encoding="utf-8")
    done = run_squid("plot", record, "--json")
    refusal(done, "record")
    assert messages(done, TMP=tmp_path) == snapshot
    assert not record.with_suffix(".svg").exists()


def test_a_search_has_at_least_one_design(
    run_squid: Run, copied_vehicle: Path, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("tune", copied_vehicle, "--designs", "0", "--json")
    refusal(done, "argument", 64)
    assert messages(done) == snapshot


def test_a_program_gets_its_object_of_a_wrong_command_line_too(run_squid: Run) -> None:
    for words in (("show", "--json"), ("design", REMUS100, "--bogus", "--json")):
        done = run_squid(*words)
        assert done.returncode == 64 and json.loads(done.stdout)["status"] == "error"
