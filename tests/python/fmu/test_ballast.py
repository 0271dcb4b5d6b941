"""External loads, dropped weights and buoyancy engines, in the FMUs as packaged."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import reference_plant as reference
from compare_plant import PITCH_TOLERANCE, fly_fmu, outputs_of
from conftest import REMUS100, Run, kept
from flights import sample_time
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fly.stages import ROOT
from fmpy.fmi1 import FMICallException
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

INPUTS = ("external_force_x", "external_force_z", "external_moment")
TUNABLE = ("weight", "buoyancy", "x_G", "z_G")
RATES = ("der(surge_over_ground)", "der(heave_over_ground)", "der(pitch_rate)")
DROPPED = 0.05
"""What is dropped, in weights of the vehicle."""
AT, END = 10.0, 60.0
"""When it is dropped, and the end of the flight (s)."""
HELD = 0.3
"""The largest error of depth that counts as held (m)."""


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, "--axis", "depth")


def started(fmu: Path, name: str = "one", **values: float) -> Slave:
    """Return an instance ready to step."""
    slave = Slave(fmu, name)
    slave.begin(values)
    slave.ready()
    return slave


@pytest.mark.parametrize("kind", ["plant", "loop"])
def test_the_model_description_lists_them(packages: Packages, kind: str) -> None:
    with started(getattr(packages, kind)) as slave:
        for name, unit in zip(INPUTS, ("N", "N", "N.m"), strict=True):
            one = slave.variables[name]
            assert (one.causality, one.variability, one.unit) == ("input", "continuous", unit)
            assert float(one.start) == 0.0
        tunable = {name for name, one in slave.variables.items() if one.variability == "tunable"}
        assert tunable == set(TUNABLE)


def test_the_motion_is_that_of_independent_equations(packages: Packages) -> None:
    """A load, a weight dropped off the centre of gravity, and a volume that is pumped out."""
    name = packages.plant.stem.removesuffix("_plant")
    vehicle = reference.read_vehicle(ROOT / "vehicles" / name / "vehicle.toml")
    start = reference.trim(vehicle, 1.75, 50.0)
    trim = np.array([a.taken(output) for a, output in zip(vehicle.actuators, start[6:], strict=True)])
    c = vehicle.coefficients
    light = {"weight": 0.98 * c["weight"], "mass": 0.98 * c["mass"], "x_G": c["x_G"] + 0.004}
    legs = [
        reference.Leg(2.0, trim, load=(3.0, -2.0, 0.4)),
        reference.Leg(6.0, trim, current=(0.2, 0.0), changed={**light, "z_G": 0.9 * c["z_G"]}),
        reference.Leg(10.0, trim, changed={"buoyancy": c["buoyancy"] - 0.02 * c["weight"]}),
    ]
    times, flown = fly_fmu(packages.plant, vehicle, 1.75, 50.0, legs, 0.02)
    expected = reference.fly(vehicle, start, legs, times)
    greatest = np.abs(flown - expected).max(axis=0)
    assert greatest[: len(outputs_of(vehicle))].max() < PITCH_TOLERANCE, greatest
    assert np.ptp(expected[:, reference.THETA]) > 0.02


@pytest.mark.parametrize("kind", ["plant", "loop"])
def test_derivatives_are_differences_of_the_rates(packages: Packages, kind: str) -> None:
    """The derivatives hold for a changed weight, too. Forces enter linearly: the difference is exact up to rounding."""
    with started(getattr(packages, kind)) as slave:
        unknowns = slave.references(RATES)
        before = {}
        for share in (1.0, 0.9):
            slave.set("weight", share * float(slave.variables["weight"].start))
            for name in INPUTS:
                (known,) = slave.references([name])
                exact = np.array(slave.fmu.getDirectionalDerivative(unknowns, [known], [1.0]))
                around = []
                for value in (5.0, -5.0):
                    slave.set(name, value)
                    around.append(np.array(slave.fmu.getReal(unknowns)))
                slave.set(name, 0.0)
                assert exact == pytest.approx((around[0] - around[1]) / 10.0, rel=1e-9, abs=1e-12)
                assert np.abs(exact).max() > 1e-3
                assert not np.array_equal(exact, before.get(name)), "a lighter vehicle is pushed more"
                before[name] = exact
        with pytest.raises(FMICallException):
            slave.fmu.getDirectionalDerivative(unknowns, slave.references(["weight"]), [1.0])


def test_level_more_weight_is_a_force_down(squid: Packages) -> None:
    """At level attitude more weight equals a force down, except for its mass."""
    with started(squid.plant, x_G=0.0) as plant:
        slope = plant.get("pitch")
        more = 0.05 * plant.get("weight")
        plant.set("external_force_x", -more * np.sin(slope))
        plant.set("external_force_z", more * np.cos(slope))
        plant.set("external_moment", -more * plant.get("z_G") * np.sin(slope))
        # In trim nothing else acts, so that the accelerations are those of the load.
        pulled = np.array([plant.get(name) for name in RATES])
        inverse = np.array(
            [
                plant.fmu.getDirectionalDerivative(plant.references(RATES), plant.references([name]), [1.0])
                for name in INPUTS
            ]
        ).T
        for name in INPUTS:
            plant.set(name, 0.0)
        plant.set("weight", 1.05 * plant.get("weight"))
        heavier = np.array([plant.get(name) for name in RATES])
        other = np.array(
            [
                plant.fmu.getDirectionalDerivative(plant.references(RATES), plant.references([name]), [1.0])
                for name in INPUTS
            ]
        ).T
        force, same = np.linalg.solve(inverse, pulled), np.linalg.solve(other, heavier)
        # The velocity u turns with q = 0: no inertial force but the pitch moment u p_z - w p_x, in which m cancels.
        assert same == pytest.approx(force, rel=1e-9, abs=1e-9)
        assert force[1] == pytest.approx(more * np.cos(slope), rel=1e-9)


def bent(slave: Slave, begin: float) -> list[float]:
    """Continue with a changing load, and drop more weight; return every output after every step."""
    values = []
    for step in range(25):
        slave.set("external_moment", 0.05 * (step % 7))
        if step == 12:
            slave.set("x_G", 0.002)
            slave.set("weight", 0.96 * float(slave.variables["weight"].start))
        slave.fmu.doStep(begin + 0.02 * step, 0.02)
        values += [slave.get(name) for name in slave.names("output")]
    return values


@pytest.mark.parametrize("kind", ["plant", "loop"])
@pytest.mark.parametrize("waves", [{}, {"wave_height": 0.5, "wave_period": 6.0, "initial_depth": 6.0}])
def test_a_state_has_what_was_changed_in_flight(
    remus100: Packages, kind: str, waves: dict[str, float]
) -> None:
    fmu = getattr(remus100, kind)
    with started(fmu, **waves) as first, started(fmu, "two") as second:
        first.set("external_force_z", -1.5)
        first.set("buoyancy", 300.0)
        first.set("weight", 0.98 * first.get("weight"))
        first.fmu.doStep(0.0, 0.5)
        changed = {name: first.get(name) for name in (*INPUTS, *TUNABLE)}
        state = first.fmu.getFMUstate()
        stored = first.fmu.serializeFMUstate(state)
        expected = bent(first, 0.5)
        first.fmu.setFMUstate(state)
        assert bent(first, 0.5) == expected
        read = second.fmu.deSerializeFMUstate(stored)
        second.fmu.setFMUstate(read)
        assert {name: second.get(name) for name in changed} == changed
        assert bent(second, 0.5) == expected
        for slave, one in ((first, state), (second, read)):
            slave.fmu.freeFMUstate(one)
        first.fmu.reset()
        first.begin()
        first.ready()
        assert [first.get(name) for name in INPUTS] == [0.0] * 3
        assert all(first.get(name) == float(first.variables[name].start) for name in TUNABLE)


@pytest.mark.parametrize("kind", ["plant", "loop"])
def test_bad_values_are_refused_in_a_sentence_and_the_flight_goes_on(
    squid: Packages, capsys: pytest.CaptureFixture[str], kind: str, snapshot: SnapshotAssertion
) -> None:
    with started(getattr(squid, kind)) as slave, started(getattr(squid, kind), "other") as other:
        for one in (slave, other):
            one.step_to(1.0)
        messages = []
        for name, value in (
            ("weight", 0.0),
            ("buoyancy", -1.0),
            ("z_G", 20.0),
            ("x_G", float("nan")),
            ("external_force_z", float("inf")),
            ("mass", 60.0),
        ):
            with pytest.raises(FMICallException):
                slave.fmu.setReal(slave.references(["external_moment", name]), [1.0, value])
            messages += capsys.readouterr().out.strip().splitlines()
            assert name in messages[-1] or name == "z_G"
        assert len(messages) == 6 and "\n".join(messages) == snapshot
        for one in (slave, other):
            one.step_to(5.0)
        names = [name for name, variable in slave.variables.items() if variable.type == "Real"]
        assert [slave.get(name) for name in names] == [other.get(name) for name in names]


def holding(packages: Packages, speed: float, dropped: float) -> tuple[Signals, Callable[[str], float]]:
    """Hold the depth at a speed (m/s), and drop a fraction of the weight at its centre of gravity."""
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": speed})
        controller.begin()
        tick = sample_time(packages)
        level = {name: plant.get(name) for name in ("depth", "speed")}
        weight = plant.get("weight")

        def references(sample: int, _: float) -> dict[str, float]:
            if sample == round(AT / tick):
                plant.set("weight", (1.0 - dropped) * weight)
            return {f"{name}_reference": value for name, value in level.items()}

        flown = couple(plant, controller, references, END, tick)
        limits = {name: plant.limits(name) for name in ("stern_planes", "propeller")}
    flown["error"] = flown["depth"] - level["depth"]

    def pinned(name: str) -> float:
        low, high = limits[name]
        return float(np.count_nonzero((flown[name] <= low) | (flown[name] >= high))) * tick

    return flown, pinned


@pytest.mark.parametrize("speed", [1.6, 1.8, 2.0, 2.15])
def test_depth_is_held_when_a_weight_is_dropped(deep: Packages, speed: float) -> None:
    flown, pinned = holding(deep, speed, DROPPED)
    error = np.abs(flown["error"])
    later = error[flown["time"] > AT + 30.0]
    print(
        f"{speed} m/s: at most {error.max():.4f} m, {later[0]:.1e} m after 30 s; at their limits: planes "
        f"{pinned('stern_planes'):.2f} s, propeller {pinned('propeller'):.2f} s"
    )
    assert 0.01 < error.max() < HELD
    assert later.max() < 0.01
    assert pinned("propeller") == 0.0 and pinned("stern_planes") < 3.0


def test_slow_planes_cannot_hold_a_lighter_vehicle(deep: Packages) -> None:
    """Level flight sets the limit: below 1.56 m/s no trim of the lighter vehicle is within the limits of the planes."""
    weight, mass = ((1.0 - DROPPED) * value for value in weight_and_mass(deep))

    def has_trim(speed: float) -> bool:
        with Slave(deep.plant, "light", quiet=True) as plant:
            plant.begin({"initial_speed": speed, "weight": weight, "mass": mass})
            try:
                plant.ready()
            except FMICallException:
                plant.fmu.reset()
                plant.begin()
                plant.ready()
                return False
            return True

    slow, fast = 1.4, 1.6
    assert has_trim(fast) and not has_trim(slow)
    while fast - slow > 1e-3:
        middle = 0.5 * (slow + fast)
        slow, fast = (slow, middle) if has_trim(middle) else (middle, fast)
    print(f"the slowest level trim with {1.0 - DROPPED:g} of the weight is at {fast:.3f} m/s")
    for speed, holds in ((fast + 0.02, True), (slow - 0.05, False)):
        flown, pinned = holding(deep, speed, DROPPED)
        error = np.abs(flown["error"])
        print(
            f"{speed:.3f} m/s: at most {error.max():.3f} m, planes at their limit {pinned('stern_planes'):.1f} s"
        )
        assert (error.max() < HELD) == holds
        assert (pinned("stern_planes") > 40.0) != holds


def weight_and_mass(packages: Packages) -> tuple[float, float]:
    """Return the weight (N) and the mass (kg) of the vehicle's file."""
    with started(packages.plant) as plant:
        return plant.get("weight"), plant.get("mass")


def test_the_loop_holds_as_well(deep: Packages) -> None:
    """Weight and load are variables of the closed loop, too: the same result up to rounding."""
    flown, _ = holding(deep, 1.8, DROPPED)
    with Slave(deep.loop, "loop") as loop:
        speed = 1.8
        loop.begin({"speed_from": speed, "speed_to": speed, "depth_step": 0.0})
        loop.ready()
        loop.step_to(AT)
        loop.set("weight", (1.0 - DROPPED) * loop.get("weight"))
        for time in (AT + 1.0, AT + 2.0, AT + 10.0, END):
            loop.step_to(time)
            row = np.searchsorted(flown["time"], time - 1e-6)
            assert loop.get("depth") == pytest.approx(flown["depth"][row], abs=1e-6)


def test_the_example_of_the_documentation_runs(
    deep: Packages, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "docs" / "fmi.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / deep.loop.name).symlink_to(deep.loop)
    monkeypatch.chdir(tmp_path)
    exec(example, {})
    found = float(capsys.readouterr().out.split()[-2])
    assert 0.01 < found < HELD
