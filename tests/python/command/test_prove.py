"""`squid prove`: given gains are proved or refused, and a design file with them passes every verb."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from conftest import REMUS100, Run, masked, messages, mistakes, refusal
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

WEIGHTS = ROOT / "tests" / "designs" / "remus100_for_pid.toml"
MSS, PVS, MVP = (5.33, 0.43, 10.7), (5.0, 0.3, 2.0), (5.0, 1.0, 2.0)
PSARHADI, DUNE = (3.0, 1.0, 2.0), (1.5, 0.0, 1.1)


def controller(gains: tuple[float, float, float]) -> str:
    """Return a file of pitch gains kp, ki and kd, in radians of the planes per radian; gains of 0 are omitted."""
    units = {"kp": "rad/rad", "ki": "rad/(rad.s)", "kd": "rad.s/rad"}
    pitch = "".join(
        f'{key} = {{ value = {gain}, unit = "{unit}" }}\n'
        for (key, unit), gain in zip(units.items(), gains, strict=True)
        if gain
    )
    speed = 'kp = { value = 30.0, unit = "N.s/m" }\nki = { value = 10.0, unit = "N/m" }\n'
    return f'[controller]\nkind = "pid"\n[controller.pitch]\n{pitch}[controller.speed]\n{speed}'


@pytest.fixture
def vehicle(tmp_path: Path) -> Path:
    """Return REMUS 100 with constant weights."""
    vehicle = tmp_path / "remus100"
    vehicle.mkdir()
    shutil.copy(REMUS100 / "vehicle.toml", vehicle)
    shutil.copy(WEIGHTS, vehicle / "design.toml")
    return vehicle


def given(vehicle: Path, text: str) -> Path:
    path = vehicle.parent / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


HEADING = """[controller]
kind = "pid"
[controller.heading]
kp = { value = KP, unit = "rad/rad" }
ki = { value = 0.0864, unit = "rad/(rad.s)" }
kd = { value = 2.07, unit = "rad.s/rad" }
reference_weight = 0.75
"""
"""Gains that `squid tune --axis heading --controller pid` found."""


def test_gains_of_heading_are_proved(run_squid: Run, tmp_path: Path) -> None:
    """Gains of heading meet the requirements of its axis; a wrong sign, or another axis, is refused."""
    gains = tmp_path / "gains.toml"
    gains.write_text(HEADING.replace("KP", "0.81"), encoding="utf-8")
    words = ["prove", REMUS100, "--axis", "heading", "--controller", gains, "--json", "--strict"]
    done = run_squid(*words)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "proved" and found["frozen_growth"] < 0.0
    assert 0.9 < found["gain"] < 1.2 < 5.0 * found["full_order_gain"]
    done = run_squid("prove", REMUS100, "--axis", "depth", "--controller", gains, "--json")
    assert "controller.heading" in [key for _, key in mistakes(done)]
    gains.write_text(HEADING.replace("KP", "-0.81"), encoding="utf-8")
    assert mistakes(run_squid(*words)) == [(4, "controller.heading.kp")]


def test_published_gains_are_proved(run_squid: Run, vehicle: Path) -> None:
    done = run_squid("prove", vehicle, "--controller", given(vehicle, controller(PVS)), "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "proved"
    # Reference values are those of a prototype that shares no code; its delay margin, 0.083 s, is at 2.1 m/s.
    assert found["gain"] == pytest.approx(15.0, rel=0.02)
    assert found["frozen_gain"] == pytest.approx(3.33, rel=0.02)
    assert found["frozen_growth"] < 0
    assert found["sampled_gain"] > found["gain"]
    # Bound of the synthesised controller; test_generated.py checks the committed one.
    assert found["full_order_gain"] < 0.5
    assert [place["speed"] for place in found["box"]] == pytest.approx([1.4, 1.8, 2.2])
    # The prototype has 5 to 10 % of overshoot, 13 % over the box of the uncertainty.
    assert all(place["survived"] > 0.9 and 0.1 < place["overshoot"] < 0.14 for place in found["box"])
    rows = {row["key"]: row["achieved"]["value"] for row in found["verdict"]["rows"]}
    assert {"gain_margin", "phase_margin", "delay_margin", "mu", "noise", "gamma"} <= rows.keys()
    assert 5 < rows["overshoot"] < 10
    assert rows["delay_margin"] == pytest.approx(0.08, abs=0.01)
    assert {path.name for path in vehicle.parent.rglob("*.*")} == {"vehicle.toml", "design.toml", "mine.toml"}


@pytest.mark.parametrize("strict", [False, True])
def test_a_missed_requirement_is_said_by_the_exit_code(run_squid: Run, vehicle: Path, strict: bool) -> None:
    options = ["--strict"] if strict else []
    done = run_squid("prove", vehicle, "--controller", given(vehicle, controller(DUNE)), *options)
    assert done.returncode == (5 if strict else 0), done.stderr
    for stage in ("frozen", "gain", "sampled", "full order", "box"):
        assert re.search(rf"^{stage} +\S", done.stdout, re.MULTILINE), stage
    assert "MISSED" in done.stdout
    assert max(map(len, run_squid("prove", vehicle, columns="100").stderr.splitlines())) <= 100


@pytest.mark.parametrize(
    ("change", "line", "key"),
    [
        (("value = 0.3", "value = 0.0"), 5, "controller.pitch.ki"),
        (('"rad/rad"', '"rad"'), 4, "controller.pitch.kp"),
        (("value = 5.0", "value = -5.0"), 4, "controller.pitch.kp"),
        (('kind = "pid"', 'kind = "pid"\nintegrator = "scheduled input"'), 3, "controller.integrator"),
        (('kind = "pid"', 'kind = "full"'), 2, "controller.kind"),
        (("kd = {", "kdd = {"), 6, "controller.pitch.kdd"),
    ],
)
def test_what_cannot_be_proved_is_refused(
    run_squid: Run, vehicle: Path, change: tuple[str, str], line: int, key: str
) -> None:
    text = controller(PVS)
    assert change[0] in text
    done = run_squid("prove", vehicle, "--controller", given(vehicle, text.replace(*change, 1)), "--json")
    assert mistakes(done)[0] == (line, key)
    assert refusal(done, "file")["file"].endswith("mine.toml")


@pytest.mark.parametrize(("kp", "growth"), [(1.5, 0.59), (0.6, 0.48)])
def test_an_unstable_loop_is_refused_with_speed_and_growth(
    run_squid: Run, vehicle: Path, kp: float, growth: float, snapshot: SnapshotAssertion
) -> None:
    """DUNE without its derivative, and lrauv; the growth equals that of a prototype."""
    done = run_squid("prove", vehicle, "--controller", given(vehicle, controller((kp, 0.0, 0.0))), "--json")
    found = refusal(done, "refused")["refusal"]
    assert (found["check"], found["speed"]) == ("unstable_given", pytest.approx(2.2))
    assert found["growth"] == pytest.approx(growth, abs=0.005)
    assert masked(messages(done)) == snapshot


def test_a_rate_that_is_not_measured_is_named(run_squid: Run, vehicle: Path) -> None:
    path = vehicle / "design.toml"
    text = path.read_text(encoding="utf-8")
    begin = text.index('[[measure]]\nsignal = "pitch_rate"')
    path.write_text(text[:begin] + text[text.index("[control]") :], encoding="utf-8")
    done = run_squid("prove", vehicle, "--controller", given(vehicle, controller(PVS)), "--json")
    assert mistakes(done) == [(6, "controller.pitch.kd")]


def test_there_must_be_a_controller(run_squid: Run, vehicle: Path, snapshot: SnapshotAssertion) -> None:
    done = run_squid("prove", vehicle, "--json")
    refusal(done, "no_controller")
    assert messages(done) == snapshot


def test_a_design_file_with_gains_is_designed_and_exported(
    run_squid: Run, vehicle: Path, snapshot: SnapshotAssertion
) -> None:
    """The design is exported, and there is no search for other weights."""
    with (vehicle / "design.toml").open("a", encoding="utf-8") as file:
        file.write("\n" + controller(PVS).replace('"pid"', '"pid"\ntracking_time = 0.5', 1))
    out = vehicle.parent / "out"
    done = run_squid("design", vehicle, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "PID of" in done.stdout and "advice" not in done.stdout
    stored = json.loads((out / "controller.json").read_text(encoding="utf-8"))
    assert len(stored["lft"]["A"]) == 2
    assert stored["gamma"]["certified"] and stored["gamma"]["back_off"] == 0
    # Anti-windup I' = -(u - sat u)/(Tt ki) of the planes, which lower the bow; the state is in units of 5 deg.
    reach, unit = 13.6, 5.0
    assert stored["anti_windup"][0][1] == pytest.approx(reach / (unit * 0.5 * 0.3))
    for verb in (["export", vehicle, "--out", out], ["show", vehicle, "--out", out, "--controller"]):
        done = run_squid(*verb)
        assert done.returncode == 0, done.stderr
    header = next((out / "c").glob("*.h")).read_text(encoding="utf-8")
    for gain in ("pitch.kp = 5.0 (rad/rad)", "pitch.ki = 0.3 (rad/(rad.s))", "speed.kp = 30.0 (N.s/m)"):
        assert gain in header
    # A controller that does not follow from the gains is not exported.
    path = out / "controller.json"
    text = path.read_text(encoding="utf-8")
    stored["gains"][0]["coefficients"] = [5.1]
    path.write_text(json.dumps(stored), encoding="utf-8")
    done = run_squid("export", vehicle, "--out", out, "--json")
    refusal(done, "uncertified")
    assert messages(done, TMP=vehicle.parent) == snapshot
    path.write_text(text, encoding="utf-8")
    source = next((out / "c").glob("*.c"))
    done = run_squid("verify", "--c", source, "--vehicle", vehicle)
    assert done.returncode == 0, done.stderr
    for verb in (["tune", vehicle, "--designs", "1"], ["design", vehicle, "--robust", "--out", out]):
        done = run_squid(*verb, "--json")
        refusal(done, "given_controller")
        assert messages(done) == snapshot


@pytest.mark.night
@pytest.mark.parametrize(
    ("gains", "gain", "delays"),
    [
        (MSS, 10.2, (0.047, 0.018)),
        (PVS, 15.0, (0.13, 0.083)),
        (MVP, 17.1, (0.127, 0.082)),
        (PSARHADI, 3.59, (0.2, 0.115)),
        (DUNE, 351.0, (0.28, 0.186)),
    ],
)
def test_each_published_pid(
    run_squid: Run, vehicle: Path, gains: tuple, gain: float, delays: tuple[float, float]
) -> None:
    """The values are those of a prototype with another speed loop, which has the delay margins at 1.5 and 2.1 m/s."""
    done = run_squid("prove", vehicle, "--controller", given(vehicle, controller(gains)), "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["gain"] == pytest.approx(gain, rel=0.02)
    at = {place["speed"]: place["delay_margin"] for place in found["verdict"]["frozen"]}
    for speed, delay in zip((1.5, 2.1), delays, strict=True):
        nearest = min(at, key=lambda known: abs(known - speed))
        assert at[nearest] == pytest.approx(delay, rel=0.02, abs=0.002)
