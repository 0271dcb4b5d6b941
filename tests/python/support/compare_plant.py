"""Flies the plant FMU beside the independent equations of motion, and says how far apart they end up.

    python compare_plant.py squid_plant.fmu vehicles/squid/vehicle.toml

flies 60 s from trim at 1.75 m/s and 50 m: steps of the first actuator, also beyond its limit, in a current that
turns and ends. It prints the greatest difference of each output, and fails if pitch differs by more than 1e-6 rad.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
import reference_plant as reference
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

PITCH_TOLERANCE = 1e-6  # rad
MOTION = ["speed", "heave", "pitch_rate", "pitch", "distance", "depth"]


def outputs_of(vehicle):
    """Names of the FMU's outputs in the order of the reference's state."""
    return MOTION + [f"{actuator.name}_output" for actuator in vehicle.actuators]


def manoeuvre(vehicle, start):
    """Sixty seconds of steps; each step is a fifth of the first actuator's reach, or beyond its limit."""
    trim = start[6:]
    step = np.zeros(len(trim))
    step[0] = 0.2 * vehicle.actuators[0].max

    def commands(outputs):
        return np.array([a.taken(output) for a, output in zip(vehicle.actuators, outputs, strict=True)])

    beyond = np.zeros(len(trim))
    beyond[0] = 2.0 * vehicle.actuators[0].taken(vehicle.actuators[0].max)
    return [
        reference.Leg(5.0, commands(trim), (0.3, 0.0)),
        reference.Leg(20.0, commands(trim + step), (0.3, 0.0)),
        reference.Leg(40.0, commands(trim - step), (-0.2, 0.1)),
        reference.Leg(45.0, commands(trim) + beyond),
        reference.Leg(60.0, commands(trim)),
    ]


def fly_fmu(path, vehicle, speed, depth, legs, step, parameters=None):
    """Flies the FMU with a communication step, from its own trim; returns times and outputs."""
    description = read_model_description(str(path))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = extract(str(path))
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="plant",
    )
    inputs = [references[actuator.name] for actuator in vehicle.actuators]
    inputs += [references["current_horizontal"], references["current_vertical"]]
    outputs = [references[name] for name in outputs_of(vehicle)]
    settings = {"initial_speed": speed, "initial_depth": depth, **(parameters or {})}
    times = np.round(np.arange(round(legs[-1].end / step) + 1) * step, 9)
    try:
        slave.instantiate()
        slave.setReal([references[name] for name in settings], list(settings.values()))
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.setReal(inputs, [*legs[0].commands, *legs[0].current])
        slave.exitInitializationMode()
        rows = [slave.getReal(outputs)]
        for time in times[:-1]:
            leg = next(leg for leg in legs if time < leg.end)
            slave.setReal(inputs, [*leg.commands, *leg.current])
            slave.doStep(time, step)
            rows.append(slave.getReal(outputs))
        slave.terminate()
        slave.freeInstance()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return times, np.array(rows)


def differences(path, vehicle, speed=1.75, depth=50.0, step=0.02, parameters=None):
    """The greatest difference of each output over the manoeuvre, and how far the pitch travelled, in rad."""
    vehicle = vehicle.changed(**(parameters or {}))
    start = reference.trim(vehicle, speed, depth)
    legs = manoeuvre(vehicle, start)
    times, flown = fly_fmu(path, vehicle, speed, depth, legs, step, parameters)
    expected = reference.fly(vehicle, start, legs, times)
    greatest = np.abs(flown - expected).max(axis=0)
    return dict(zip(outputs_of(vehicle), greatest, strict=True)), np.ptp(expected[:, reference.THETA])


def main(fmu, vehicle_file):
    found, travelled = differences(Path(fmu), reference.read_vehicle(Path(vehicle_file)))
    for name, difference in found.items():
        print(f"{name:24} {difference:.2e}")
    print(f"pitch travelled {np.degrees(travelled):.1f} deg")
    return 0 if found["pitch"] < PITCH_TOLERANCE else 1


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2]))
