"""`squid gains`: gains in an autopilot's file are read as `[controller]`, proved, and written back into the file."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from conftest import REMUS100, Run, masked, messages, mistakes, refusal
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

WEIGHTS = ROOT / "tests" / "designs" / "remus100_for_pid.toml"
BLUEROV2 = ROOT / "vehicles" / "bluerov2_heavy"
SPEED = '\n[controller.speed]\nkp = { value = 30.0, unit = "N.s/m" }\nki = { value = 10.0, unit = "N/m" }\n'
DUNE = """\
[Control.AUV.Attitude]
Depth PID Gains      = 0.6, 0.0, 0.7
Pitch PID Gains      = 1.5, 0.0, 1.1    ; LAUV, etc/auv/control.ini of DUNE
Roll PID Gains       = 2.1, 0.0, 0.4

[Control.AUV.Allocator]
Fin effect M         = 0.5
"""
ARDUSUB = "ATC_ANG_PIT_P,6.0\nATC_RAT_PIT_P,0.135\nATC_RAT_PIT_I,0.09\nATC_RAT_PIT_D,0.0036\n"


@pytest.fixture
def ini(tmp_path: Path) -> Path:
    path = tmp_path / "control.ini"
    path.write_text(DUNE, encoding="utf-8")
    return path


def test_gains_of_dune_are_proved(
    run_squid: Run, ini: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The gains of the file have the proved gain listed in docs/pid.md."""
    vehicle, mine = tmp_path / "remus100", tmp_path / "mine.toml"
    vehicle.mkdir()
    shutil.copy(REMUS100 / "vehicle.toml", vehicle)
    shutil.copy(WEIGHTS, vehicle / "design.toml")
    done = run_squid("gains", "import", ini, "--format", "dune", "--out", mine)
    assert done.returncode == 0, done.stderr
    assert messages(done, TMP=tmp_path) == snapshot
    # Without speed gains the proof reports them as missing.
    ((_, key),) = mistakes(run_squid("prove", vehicle, "--controller", mine, "--json"))
    assert key == "controller.speed"
    with mine.open("a", encoding="utf-8") as file:
        file.write(SPEED)
    done = run_squid("prove", vehicle, "--controller", mine, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "proved" and found["gain"] == pytest.approx(350, rel=0.02)


HEADING = """\
[Control.AUV.Attitude]
Heading PID Gains      = 0.5, 0.0, 0.0
Heading Rate PID Gains = 2.0, 0.0, 0.0
"""


def test_gains_of_the_heading_of_dune_are_proved(run_squid: Run, tmp_path: Path) -> None:
    """Two nested proportional loops equal a PID with kp = 2 x 0.5 and kd = 2, over 2 x 0.5 N m/rad."""
    ini, mine = tmp_path / "control.ini", tmp_path / "mine.toml"
    ini.write_text(HEADING, encoding="utf-8")
    done = run_squid("gains", "import", ini, "--format", "dune", "--axis", "heading", "--out", mine, "--json")
    assert done.returncode == 0, done.stderr
    gains = {gain["name"]: gain["value"] for gain in json.loads(done.stdout)["gains"]}
    assert gains == pytest.approx({"heading.kp": 1.0, "heading.kd": 2.0}, rel=1e-12)
    done = run_squid("prove", REMUS100, "--axis", "heading", "--controller", mine, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["status"] == "proved"
    back = run_squid("gains", "export", mine, "--format", "dune", "--into", ini)
    assert back.returncode == 0 and ini.read_text(encoding="utf-8") == HEADING


def test_a_file_without_out_is_printed_whole(run_squid: Run, ini: Path, tmp_path: Path) -> None:
    """The printed text equals the written file, also on a narrow terminal."""
    mine = tmp_path / "mine.toml"
    printed = run_squid("gains", "import", ini, "--format", "dune", columns="40").stdout
    assert run_squid("gains", "import", ini, "--format", "dune", "--out", mine).returncode == 0
    assert mine.read_text(encoding="utf-8") == printed
    answer = json.loads(run_squid("gains", "import", ini, "--format", "dune", "--json").stdout)
    assert answer["controller"] == printed
    assert [(gain["name"], gain["value"], gain["unit"]) for gain in answer["gains"]] == [
        ("pitch.kp", 1.5, "rad/rad"),
        ("pitch.kd", 1.1, "rad.s/rad"),
    ]


def test_gains_are_written_into_the_file_alone(
    run_squid: Run, ini: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A byte order mark, line ends, and a link to the file are preserved; values that are not written are reported."""
    mine, link = tmp_path / "mine.toml", tmp_path / "link.ini"
    ini.write_bytes(b"\xef\xbb\xbf" + DUNE.replace("\n", "\r\n").encode())
    before = ini.read_bytes()
    link.symlink_to(ini)
    assert run_squid("gains", "import", ini, "--format", "dune", "--out", mine).returncode == 0
    export = ("gains", "export", mine, "--format", "dune", "--into", link, "--json")
    assert json.loads(run_squid(*export).stdout)["changes"] == [] and ini.read_bytes() == before
    text = mine.read_text(encoding="utf-8").replace("value = 1.5", "value = 2.25") + SPEED
    mine.write_text(text, encoding="utf-8")
    done = run_squid(*export)
    assert done.returncode == 0, done.stderr
    key = "[Control.AUV.Attitude] Pitch PID Gains"
    assert json.loads(done.stdout)["changes"] == [{"line": 3, "key": key, "from": "1.5", "to": "2.25"}]
    assert messages(done) == snapshot
    assert link.is_symlink() and ini.read_bytes() == before.replace(b"= 1.5", b"= 2.25")


def test_what_cannot_be_written_leaves_everything_as_it_was(
    run_squid: Run, ini: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    mine = tmp_path / "mine.toml"
    assert run_squid("gains", "import", ini, "--format", "dune", "--out", mine).returncode == 0
    text = mine.read_text(encoding="utf-8")
    mine.write_text(text.replace("value = 1.5", "value = [1.5, 0.2]"), encoding="utf-8")
    done = run_squid("gains", "export", mine, "--format", "dune", "--into", ini, "--json")
    line = 1 + text[: text.index("value = 1.5")].count("\n")
    assert mistakes(done) == [(line, "controller.pitch.kp")]
    assert ini.read_text(encoding="utf-8") == DUNE
    done = run_squid("gains", "import", ini, "--format", "dune", "--out", ini, "--json")
    refusal(done, "argument", 64)
    assert messages(done, TMP=tmp_path) == snapshot
    assert ini.read_text(encoding="utf-8") == DUNE
    # Refused gains leave no file.
    none = tmp_path / "none.toml"
    ini.write_text(DUNE.replace("1.5", "x"), encoding="utf-8")
    done = run_squid("gains", "import", ini, "--format", "dune", "--out", none, "--json")
    assert mistakes(done) == [(3, "[Control.AUV.Attitude] Pitch PID Gains")] and not none.exists()


def test_the_full_output_of_ardusub_must_be_given(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    param = tmp_path / "sub.param"
    param.write_text(ARDUSUB, encoding="utf-8")
    done = run_squid("gains", "import", param, "--format", "ardusub", "--vehicle", BLUEROV2, "--json")
    assert mistakes(done) == [(2, "ATC_RAT_PIT_P")]
    assert masked(messages(done, TMP=tmp_path)) == snapshot
    done = run_squid("gains", "import", param, "--format", "ardusub", "--full-output", "30", "--json")
    gains = {gain["name"]: gain["value"] for gain in json.loads(done.stdout)["gains"]}
    # 30 (0.135 6 + 0.09), 30 0.09 6, 30 0.135, 0.135 6/(0.135 6 + 0.09)
    expected = {"pitch.kp": 27.0, "pitch.ki": 16.2, "pitch.kd": 4.05, "pitch.reference_weight": 0.9}
    assert gains == pytest.approx(expected, rel=1e-12)


def test_the_unit_of_mvp_is_given(run_squid: Run, tmp_path: Path) -> None:
    modes = tmp_path / "modes.yaml"
    limits = "i_max: 10, i_min: -10"
    flight = f"flight: {{pitch: {{p: 5.0, i: 1.0, d: 2.0, {limits}}}, surge: {{p: 10.0, i: 3.0, {limits}}}}}"
    modes.write_text(f"control_modes:\n  {flight}\n  hold: {{pitch: {{p: 6.0}}}}\n", encoding="utf-8")
    unit = (2, "control_modes.flight.pitch.p")
    for options, mistake in (([], (1, "control_modes")), (["--mode", "flight"], unit)):
        assert mistakes(run_squid("gains", "import", modes, "--format", "mvp", *options, "--json")) == [
            mistake
        ]
    options = ["--format", "mvp", "--mode", "flight", "--unit", "N.m"]
    gains = json.loads(run_squid("gains", "import", modes, *options, "--json").stdout)["gains"]
    assert {gain["name"]: (gain["value"], gain["unit"]) for gain in gains} == {
        "pitch.kp": (5.0, "N.m/rad"),
        "pitch.ki": (1.0, "N.m/(rad.s)"),
        "pitch.kd": (2.0, "N.m.s/rad"),
        "speed.kp": (10.0, "N.s/m"),
        "speed.ki": (3.0, "N/m"),
    }


@pytest.mark.parametrize(
    "options",
    [
        ["--full-output", "-3"],
        ["--full-output", "nan"],
        ["--full-output", "3", "--unit", "rad"],
        ["--full-output", "3", "--mode", "flight"],
    ],
    ids=" ".join,
)
def test_options_are_checked(
    run_squid: Run, tmp_path: Path, options: list[str], snapshot: SnapshotAssertion
) -> None:
    param = tmp_path / "sub.param"
    param.write_text(ARDUSUB, encoding="utf-8")
    done = run_squid("gains", "import", param, "--format", "ardusub", *options)
    assert done.returncode == 64
    assert messages(done, TMP=tmp_path) == snapshot
