"""Properties of every verb of the command (--json, completion, manual page), and the small verbs."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import SQUID, Run, masked, messages, named, refusal
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

CASE = ROOT / "tests" / "cases" / "lpv01_lpvtools_lft_tutorial.json"


def verbs(run_squid: Run) -> list[str]:
    """Return the verbs listed by the help."""
    listed = run_squid("--help").stdout.split("Commands:\n")[1].split("\n\n")[0]
    return re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["show", SQUID, "--out", "DESIGN"], "controller"),
        (["show", SQUID, "--out", "DESIGN", "--uncertainty"], "uncertainty"),
        (["simulate", SQUID, "--out", "DESIGN"], "steps"),
        (["package", SQUID, "--out", "DESIGN", "--descriptions", "DESIGN"], "files"),
        (["export", SQUID, "--out", "DESIGN"], "files"),
        (["verify", "DESIGN/certificate.json"], "gamma"),
        (["new", "DESIGN/mine"], "files"),
        (["completions", "bash"], "script"),
        (["man", "DESIGN/man"], "directory"),
        (["lpv", "synth", CASE], "status"),
    ],
    ids=lambda words: " ".join(map(str, words[:2])) if isinstance(words, list) else "",
)
def test_answers_in_json(run_squid: Run, stored_design: Path, words: list[str | Path], key: str) -> None:
    done = run_squid(*(str(word).replace("DESIGN", str(stored_design)) for word in words), "--json")
    assert done.returncode == 0, done.stderr
    assert key in json.loads(done.stdout)


def test_the_numbers_are_those_of_the_tables(run_squid: Run) -> None:
    """The eigenvalues in the answer are those of the matrix A in it, and the trim is that of the table."""
    shown = json.loads(run_squid("show", SQUID, "--speed", "1", "--json").stdout)["at_speed"]
    trim = shown["trim"]
    trace = sum(row[place] for place, row in enumerate(shown["A"]))
    assert sum(re for re, _ in shown["eigenvalues"]) == pytest.approx(trace, rel=1e-9)
    table = run_squid("show", SQUID, "--speed", "1").stdout
    assert f"{trim['actuators']['lower']:.4f} N" in table and f"{trim['forward_speed']:.4f}" in table


@pytest.mark.parametrize("words", [["show", "nowhere"], ["verify", "nowhere.fmu"], ["plot", "nowhere.csv"]])
def test_a_refusal_is_an_object_too(run_squid: Run, words: list[str]) -> None:
    done = run_squid(*words, "--json")
    answer = json.loads(done.stdout)
    assert done.returncode == 1 and answer["status"] == "error" and "nowhere" in answer["reason"]
    assert answer["reason"] in done.stderr


SHIPPED = sorted(path.parent.name for path in ROOT.glob("vehicles/*/vehicle.toml"))


@pytest.mark.parametrize("like", SHIPPED)
def test_a_new_vehicle_is_like_its_model(run_squid: Run, tmp_path: Path, like: str) -> None:
    mine = tmp_path / "mine"
    assert run_squid("new", mine, "--like", like).returncode == 0
    speed = {"bluerov2_heavy": "0.4", "sparus2": "0.5"}.get(like, "2")
    model = ROOT / "vehicles" / like
    done = [run_squid("show", path, "--speed", speed, "--json") for path in (mine, model)]
    own, theirs = (without_proof(json.loads(one.stdout)) for one in done)
    assert own == theirs
    text = (mine / "vehicle.toml").read_text(encoding="utf-8")
    assert '\nname = "mine"\n' in text and '\nstatus = "surrogate"\n' in text
    design = (mine / "design.toml").read_text(encoding="utf-8")
    assert f"squid design {mine} --design NAME" in design and f"vehicles/{like}" not in text + design
    heading = mine / "heading.toml"
    assert heading.is_file() == (model / "heading.toml").is_file()
    if heading.is_file():
        assert run_squid("show", mine, "--speed", "1.5", "--design", "heading").returncode == 0


def without_proof(shown: dict) -> dict:
    """Return what `show` prints, without whether a stored design is proved: the new vehicle has no design yet."""
    for one in (shown, *shown.get("axes", ())):
        one.pop("proved", None)
    return shown


def test_a_vehicle_is_shown_without_its_design(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A missing design.toml, or one of another vehicle, does not prevent showing trim and A.

    The vehicle with prescribed speed has a design of Squid next to it, which tracks the speed.
    """
    mine = tmp_path / "mine"
    mine.mkdir()
    shutil.copy(ROOT / "tests" / "vehicles" / "nps_auv_ii" / "vehicle.toml", mine)
    alone = run_squid("show", mine, "--speed", "1.5")
    assert alone.returncode == 0, alone.stderr
    shutil.copy(SQUID / "design.toml", mine)
    beside = run_squid("show", mine, "--speed", "1.5")
    assert beside.returncode == 0, beside.stderr
    assert beside.stdout.endswith(alone.stdout) and len(alone.stdout) > 500
    assert named(beside.stdout.removesuffix(alone.stdout), TMP=tmp_path) == snapshot
    refusal(run_squid("show", mine, "--speed", "1.5", "--design", "nothing", "--json"), "no_design")
    assert run_squid("show", mine, "--fit").returncode == 1, "the fit is of the design"


def test_a_new_vehicle_overwrites_nothing(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("new", tmp_path, "--json")
    refusal(done, "exists")
    assert messages(done, TMP=tmp_path) == snapshot
    done = run_squid("new", tmp_path / "9 lives", "--json")
    refusal(done, "argument", 64)
    assert messages(done, TMP=tmp_path) == snapshot(name="name")
    assert not list(tmp_path.iterdir())


def test_the_doctor_names_what_is_missing(
    squid_command: Path, run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("doctor", "--json")
    found = json.loads(done.stdout)["programs"]
    assert done.returncode == 0
    assert all(program["found"] for program in found if program["name"] in ("cargo", "cc", "python3"))
    done = subprocess.run(
        [squid_command, "doctor", "--json"],
        env={"PATH": "/nowhere"},
        capture_output=True,
        text=True,
        check=False,
    )
    programs = json.loads(done.stdout)["programs"]
    # Wine is also found where its package puts it, outside the path.
    assert done.returncode == 1
    assert {program["name"] for program in programs if program["found"]} <= {"wine64"}
    assert all(program["remedy"] for program in programs)
    assert messages(done) == snapshot


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_no_line_of_a_completion_script_is_broken(run_squid: Run, shell: str) -> None:
    """Completion scripts are not wrapped, because a line break ends a command."""
    assert run_squid("completions", shell, columns="72").stdout == run_squid("completions", shell).stdout


def test_completions_and_pages_know_every_verb(run_squid: Run, tmp_path: Path) -> None:
    script = run_squid("completions", "bash").stdout
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    assert run_squid("man", tmp_path).returncode == 0
    found = verbs(run_squid)
    assert {"design", "lpv", "doctor"} <= set(found)
    for verb in set(found) - {"help"}:
        assert f"squid__subcmd__{verb}" in script or f"squid__{verb}" in script, verb
        assert (tmp_path / f"squid-{verb}.1").read_text(encoding="utf-8").startswith(".ie")


def test_show_has_sway_roll_and_yaw(run_squid: Run, snapshot: SnapshotAssertion) -> None:
    """A vehicle in six degrees of freedom has sway, roll and yaw; an unstable hull reverses the rudder's effect."""
    done = run_squid("show", ROOT / "vehicles" / "remus100", "--speed", "1.54", "--json")
    shown, turning = json.loads(done.stdout)["axes"]
    assert list(shown["at_speed"]["trim"]["actuators"]) == ["propeller", "stern_planes"]
    assert (shown["axis"], turning["axis"]) == ("depth", "heading") and "lateral" not in turning
    assert turning["at_speed"]["states"] == ["v", "r", "psi"]
    lateral = shown["lateral"]
    assert lateral["states"] == ["v", "p", "r", "phi"] and lateral["actuators"][2] == "rudder"
    assert lateral["supposed"]["N_uv"] == pytest.approx(10.57) and "N_rr" not in lateral["supposed"]
    assert max(real for real, _ in lateral["eigenvalues"]) > 0.0
    assert lateral["B"][2][2] < 0.0 < lateral["yaw_rate_per_output"]["rudder"]
    rudder = [turn["actuators"][2] for turn in lateral["turns"]]
    assert rudder[0] > 0.0 > rudder[-1]
    printed = run_squid("show", ROOT / "vehicles" / "remus100", "--speed", "1.54").stdout
    remarks = [line for line in printed.splitlines() if "initially" in line]
    assert masked("\n".join(remarks)) == snapshot
    planar = run_squid("show", ROOT / "vehicles" / "sparus2", "--speed", "0.3", "--json")
    assert "lateral" not in json.loads(planar.stdout)
