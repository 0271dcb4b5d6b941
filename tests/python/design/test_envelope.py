"""References beyond what the vehicle can hold, with the FMUs: limited, flagged, and followed again afterwards.

Without limits a depth step of REMUS 100 by 10, 20, 30 and 50 m took its pitch to -35, -49, -85 and -442 deg.
"""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import REMUS100, Run, design, kept, masked
from flights import fly_alone, sample_time
from fly.master import Signals, Slave, couple
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

DEGREE = math.pi / 180.0
BEGIN, BACK, END = 5.0, 45.0, 75.0
RETURNS = 20.0
"""After what time (s) no reference is on its way back from where planes were at their limit."""
DEEP = 2000.0
"""So deep (m) that no climb reaches the surface; there the buoyancy is to be the one that is given."""
FACTORS = (1.5, 3.0, 10.0)


def frozen(folder: Path) -> dict:
    return json.loads((folder / "controller.json").read_text(encoding="utf-8"))


def over_speed(controller: dict, ends: list) -> list[np.ndarray]:
    """Return both ends of a limit, each as a number for each row of the trim table."""
    rows = len(controller["trim"]["speed"])
    return [np.broadcast_to(np.asarray(end, dtype=float), rows) for end in ends]


def pitch_at(controller: dict, forward_speed: float) -> tuple[float, float, float]:
    """Return the trim pitch and the least and the largest pitch reference at a forward speed."""
    trim = controller["trim"]
    columns = (trim["signals"]["pitch"], *over_speed(controller, controller["envelope"]["pitch"]["range"]))
    level, least, largest = (float(np.interp(forward_speed, trim["forward_speed"], c)) for c in columns)
    return level, least, largest


def held(
    packages: Packages, path_speed: float, asked: float | None
) -> tuple[Signals, list[tuple[float, bool]]]:
    """Request a pitch for 40 s, from level flight and back; return the record, and the times of limited references."""
    said: list[tuple[float, bool]] = []
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": path_speed, "initial_depth": DEEP, "reference_depth": DEEP})
        controller.begin()
        start = {"pitch_reference": plant.get("trim_pitch"), "speed_reference": plant.get("speed")}

        def references(_: int, time: float) -> dict[str, float]:
            said.append((time, bool(controller.get("reference_limited"))))
            return start | ({"pitch_reference": asked} if BEGIN <= time < BACK else {})

        return couple(plant, controller, references, END, sample_time(packages)), said


@pytest.mark.parametrize("name", ["squid", "remus100"])
@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("way", [1, 2], ids=["down", "up"])
def test_a_pitch_that_cannot_be_held(
    request: pytest.FixtureRequest, name: str, part: float, way: int
) -> None:
    """Whatever the factor, the end of the envelope is used instead, at the requested speed, and the flag is set."""
    packages: Packages = request.getfixturevalue(name)
    controller, tick = frozen(packages.folder), sample_time(packages)
    speeds = controller["trim"]["speed"]
    path_speed = speeds[0] + part * (speeds[-1] - speeds[0])
    forward = float(np.interp(path_speed, speeds, controller["trim"]["forward_speed"]))
    limits = pitch_at(controller, forward)
    level, end = limits[0], limits[way]
    assert abs(end - level) > 2.0 * DEGREE
    first = None
    for factor in FACTORS:
        asked = level + factor * (end - level)
        flown, said = held(packages, path_speed, asked)
        assert flown["pitch_reference_used"].max() <= max(level, end) + 1e-12
        assert flown["pitch_reference_used"].min() >= min(level, end) - 1e-12
        last = np.searchsorted(flown["time"], BACK) - 1
        assert flown["pitch"][last] == pytest.approx(end, abs=0.05 * abs(end - level)), factor
        assert flown["speed"][last] == pytest.approx(forward, rel=0.1), factor
        # The flag of a tick is read before the next one and is set exactly while a reference is not used as requested.
        # It may stay set after the request ends if the reference yielded to saturated planes.
        start = flown["pitch_reference_used"][0]
        for (time, limited), used in zip(said[1:], flown["pitch_reference_used"][:-1], strict=True):
            taken = asked if BEGIN < time - 0.5 * tick < BACK else start
            assert limited == (used != taken), time
        assert all(limited for time, limited in said[1:] if BEGIN < time - 0.5 * tick < BACK)
        assert not any(limited for time, limited in said if time > BACK + RETURNS)
        assert flown["pitch"][-1] == pytest.approx(level, abs=0.05 * abs(end - level)), factor
        first = flown if first is None else first
        for signal in ("pitch", "speed", "depth"):
            assert np.array_equal(flown[signal], first[signal]), "how much too much is asked plays no part"


def test_a_reference_within_the_envelope_is_used_as_it_is(squid: Packages) -> None:
    controller = frozen(squid.folder)
    forward = float(np.interp(1.5, controller["trim"]["speed"], controller["trim"]["forward_speed"]))
    level, _, largest = pitch_at(controller, forward)
    asked = level + 0.99 * (largest - level)
    flown, said = held(squid, 1.5, asked)
    assert not any(limited for _, limited in said)
    assert flown["pitch_reference_used"].max() == asked


@pytest.mark.parametrize("wanted", [0.1, 5.0])
def test_a_speed_outside_the_range_is_its_end(squid: Packages, wanted: float) -> None:
    """Through the loop's inputs: the speed goes to the end of the range, no faster than the thrusters allow."""
    controller = frozen(squid.folder)
    limits = controller["envelope"]["speed"]
    [least], [largest] = limits["range"]
    end = min(max(wanted, least), largest)
    [slowest], [fastest] = limits["rate"]
    tick = sample_time(squid)
    limited: list[float] = []
    with Slave(squid.loop, "loop") as loop:
        loop.begin({"speed_from": 1.5, "speed_to": 1.5, "pitch_step": 0.0})
        loop.ready()
        used = [loop.get("speed_reference_used")]
        loop.set("manual", True)
        loop.set("pitch_reference", loop.get("trim_pitch"))
        for k in range(round(60.0 / tick)):
            loop.set("speed_reference", wanted if k * tick < 40.0 else 1.5)
            loop.step_to((k + 1) * tick)
            used.append(loop.get("speed_reference_used"))
            limited.append(loop.get("reference_limited"))
            if loop.time < 40.0:
                speed = loop.get("speed")
        after = loop.get("speed")
    rates = np.diff(used) / tick
    assert slowest - 1e-9 <= rates.min() and rates.max() <= fastest + 1e-9
    assert speed == pytest.approx(end, abs=0.01) and after == pytest.approx(1.5, abs=0.01)
    before = round(40.0 / tick)
    assert all(limited[:before]) and not any(limited[before + round(2.0 / tick) :])
    assert used[before] == pytest.approx(end, abs=1e-12) and used[-1] == 1.5


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, "--axis", "depth")


@pytest.mark.parametrize("step", [10.0, 20.0, 30.0, 50.0, -10.0, -20.0, -30.0, -50.0])
@pytest.mark.parametrize("speed", [1.5, 2.1])
def test_a_depth_step_of_any_height_arrives(deep: Packages, step: float, speed: float) -> None:
    """The path is no steeper than 30 deg, without a loop or a path to the surface."""
    begin = 20.0 + max(-step, 0.0)
    end = 5.0 + abs(step) / (speed * math.sin(10.0 * DEGREE)) + 40.0

    def inputs(time: float) -> dict[str, float]:
        wanted = begin + (step if time >= 5.0 else 0.0)
        return {"manual": True, "depth_reference": wanted, "speed_reference": start["speed"]}

    values = {"speed_from": speed, "speed_to": speed, "depth_step": 0.0, "initial_depth": begin}
    with Slave(deep.loop, "loop") as loop:
        loop.begin(values)
        start = {"speed": loop.get("speed")}
        loop.ready()
    flown = fly_alone(deep.loop, end, sample_time(deep), values, inputs)
    print(
        step,
        speed,
        np.degrees([flown["pitch"].min(), flown["pitch"].max()]),
        flown["depth"][-1] - begin - step,
    )
    assert np.abs(flown["pitch"]).max() < 40.0 * DEGREE
    assert flown["depth"].min() > 15.0
    assert flown["depth"][-1] == pytest.approx(begin + step, abs=0.05)
    beyond = np.sign(step) * (flown["depth"] - begin - step)
    assert beyond.max() < 0.5
    sinking = np.diff(flown["depth_reference_used"]) / sample_time(deep)
    rates = frozen(deep.folder)["envelope"]["depth"]["rate"]
    assert min(rates[0]) - 1e-9 <= sinking.min() and sinking.max() <= max(rates[1]) + 1e-9
    assert max(map(abs, (min(rates[0]), max(rates[1])))) <= 2.2 * math.sin(30.0 * DEGREE) + 1e-9


@pytest.mark.parametrize(
    ("lines", "narrower"),
    [
        ('pitch = [-10.0, 5.0]\nunit = "deg"\n', True),
        ("authority = 0.3\n", True),
        ("authority = 0.85\n", False),
    ],
)
def test_the_design_file_narrows_what_is_frozen(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, lines: str, narrower: bool
) -> None:
    vehicle = Path(shutil.copytree(quick_vehicle, tmp_path / "squid"))
    design(run_squid, vehicle, tmp_path / "without")
    with (vehicle / "design.toml").open("a", encoding="utf-8") as file:
        file.write(f"\n[envelope]\n{lines}")
    design(run_squid, vehicle, tmp_path / "with")
    both = [frozen(tmp_path / name) for name in ("without", "with")]
    one, other = (over_speed(each, each["envelope"]["pitch"]["range"]) for each in both)
    (least, largest), (new_least, new_largest) = one, other
    if not narrower:
        assert np.array_equal(one, other)
    elif "pitch" in lines:
        level = np.array(frozen(tmp_path / "with")["trim"]["signals"]["pitch"])
        assert np.all(new_least == pytest.approx(-10.0 * DEGREE)) and np.all(
            new_largest == pytest.approx(5.0 * DEGREE)
        )
        assert np.all((new_least < level) & (level < new_largest))
    assert np.all(new_least >= least - 1e-12) and np.all(new_largest <= largest + 1e-12)
    assert narrower == bool(np.any(new_largest < largest - 0.5 * DEGREE))


def test_an_envelope_without_room_for_the_default_flight_is_said(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    vehicle = Path(shutil.copytree(quick_vehicle, tmp_path / "squid"))
    with (vehicle / "design.toml").open("a", encoding="utf-8") as file:
        file.write('\n[envelope]\npitch = [-1.0, 1.0]\nunit = "deg"\n')
    done = run_squid("design", vehicle, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    (warning,) = json.loads(done.stdout)["warnings"]
    assert (warning["kind"], warning["unit"]) == ("step_limited", "deg")
    assert warning["limit"] < warning["value"]
    assert masked(warning["why"]) == snapshot
    # Level flight, at -6 deg at the slowest speed, stays within the allowed references.
    controller = frozen(tmp_path / "out")
    least, largest = over_speed(controller, controller["envelope"]["pitch"]["range"])
    level = controller["trim"]["signals"]["pitch"]
    assert min(level) < -1.0 * DEGREE
    assert all(a <= b <= c for a, b, c in zip(least, level, largest, strict=True))
