"""Run a plan with Ecos, the co-simulation engine of NTNU Aalesund: `python fly_ecos.py PLAN.json`."""

from __future__ import annotations

import csv
import ctypes
import json
import sys
from importlib.metadata import files
from pathlib import Path

# Ecos is linked with oneTBB but does not include it; the wheel `tbb` does, outside the loader's path.
for found in files("tbb") or []:
    if found.name == "libtbb.so.12":
        ctypes.CDLL(str(found.locate()), ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402


def structure_of(plan: dict) -> EcosSimulationStructure:
    """Return models, connections and start values of a plan."""
    structure = EcosSimulationStructure()
    for name, path in plan["fmus"].items():
        structure.add_model(name, path)
    for source, sink in plan.get("connections", []):
        structure.make_real_connection(source.replace(".", "::", 1), sink.replace(".", "::", 1))
    values = {path.replace(".", "::", 1): float(value) for path, value in plan.get("values", {}).items()}
    structure.add_parameter_set("start", values)
    return structure


def main() -> None:
    """Build and run the simulation, and write the record."""
    plan = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    if "ssp" in plan:
        simulation = EcosSimulation(step_size=plan["step"], ssp_path=plan["ssp"])
    else:
        simulation = EcosSimulation(step_size=plan["step"], structure=structure_of(plan))
    simulation.init(parameter_set=plan.get("parameter_set", "start"))
    with Path(plan["out"]).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time", *plan["record"]])
        for row in range(plan["count"] // plan["every"]):
            simulation.step(plan["every"])
            values = [simulation.get_real(path.replace(".", "::", 1)) for path in plan["record"]]
            writer.writerow([repr((row + 1) * plan["every"] * plan["step"]), *map(repr, values)])
    simulation.terminate()


if __name__ == "__main__":
    main()
