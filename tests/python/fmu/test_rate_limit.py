"""Rate limit of an actuator: REMUS 100 with planes of 60 deg/s, an example, in its FMUs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import reference_plant as reference
from compare_plant import PITCH_TOLERANCE, fly_fmu, outputs_of
from conftest import with_rate
from fly.master import Slave
from fly.package import Packages
from fmpy import read_model_description
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change

RATE, LAG = np.deg2rad(60.0), 0.1
OUTPUT, DERIVATIVE = "stern_planes_output", "der(stern_planes_output)"


def ready(packages: Packages, name: str = "one") -> Slave:
    """Return a plant that has run for a while."""
    plant = Slave(packages.plant, name)
    plant.begin()
    plant.ready()
    return plant


def test_the_fmus_are_valid_and_say_it(rate_limited: Packages, remus100: Packages) -> None:
    for fmu in rate_limited.fmus:
        assert not validate_fmu(str(fmu)), fmu
    for packages, says in ((rate_limited, True), (remus100, False)):
        described = {one.name: one for one in read_model_description(str(packages.plant)).modelVariables}
        assert ("1.04719" in described[OUTPUT].description) == says


def test_the_plant_moves_as_the_reference_does(rate_limited: Packages, tmp_path: Path) -> None:
    """Steps of the planes there and back, within and beyond their limits, compared with SciPy's DOP853."""
    vehicle = reference.read_vehicle(with_rate(tmp_path / "remus100") / "vehicle.toml")
    assert vehicle.actuators[1].rate == pytest.approx(RATE)
    start = reference.trim(vehicle, 1.8, 20.0)
    planes = np.array([0.0, 1.0])
    legs = [
        reference.Leg(end, start[6:] + step * planes, (0.2, 0.0))
        for end, step in ((2.0, 0.1), (4.0, -0.2), (5.0, 1.0), (5.2, -1.0), (12.0, 0.0))
    ]
    times, flown = fly_fmu(rate_limited.plant, vehicle, 1.8, 20.0, legs, 0.02)
    expected = reference.fly(vehicle, start, legs, times)
    found = dict(zip(outputs_of(vehicle), np.abs(flown - expected).max(axis=0), strict=True))
    assert found["pitch"] < PITCH_TOLERANCE and max(found.values()) < 1e-5, found
    rates = np.abs(np.diff(flown[:, -1])) / 0.02
    assert np.count_nonzero(rates > 0.999 * RATE) > 10 and rates.max() < RATE * (1.0 + 1e-9)


def test_its_derivatives_are_exact_on_both_sides(rate_limited: Packages) -> None:
    """The rate depends on command and output below its limit, and on neither at the limit."""
    with ready(rate_limited) as plant:
        reference_of = {name: variable.valueReference for name, variable in plant.variables.items()}
        now = plant.get(OUTPUT)
        for error, rate in (
            (0.5 * RATE * LAG, 0.5 * RATE),
            (-0.5 * RATE * LAG, -0.5 * RATE),
            (2.0 * RATE * LAG, RATE),
            (-2.0 * RATE * LAG, -RATE),
        ):
            plant.set("stern_planes", now + error)
            assert plant.get(DERIVATIVE) == pytest.approx(rate, rel=1e-12)
            slope = 0.0 if abs(rate) == RATE else 1.0 / LAG
            for known, expected in (("stern_planes", slope), (OUTPUT, -slope)):
                found = plant.fmu.getDirectionalDerivative(
                    [reference_of[DERIVATIVE]], [reference_of[known]], [1.0]
                )
                assert found == [pytest.approx(expected, rel=1e-12)], (error, known)


def test_a_state_goes_on_to_the_bit(rate_limited: Packages) -> None:
    """Saved while the planes move at their maximum rate, and restored in another instance."""

    def fly_on(plant: Slave) -> list[float]:
        values = []
        for step in range(25):
            plant.fmu.doStep(0.1 + 0.02 * step, 0.02)
            values += [plant.get(name) for name in plant.names("output")]
        return values

    with ready(rate_limited) as first, ready(rate_limited, "two") as second:
        first.set("stern_planes", first.get(OUTPUT) + 0.3)
        first.fmu.doStep(0.0, 0.1)
        assert first.get(DERIVATIVE) == pytest.approx(RATE, rel=1e-12)
        stored = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
        expected = fly_on(first)
        second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(stored))
        assert fly_on(second) == expected
