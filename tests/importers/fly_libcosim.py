"""Run a plan with libcosim, the C++ library of the Open Simulation Platform: `python fly_libcosim.py PLAN.json`."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

from libcosimpy._internal import get_last_error_message
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def references(execution: CosimExecution, slave: int) -> dict[str, tuple[int, CosimVariableType]]:
    """Return value reference and type of each variable of a slave."""
    return {
        v.name.decode(): (v.reference, CosimVariableType(v.type)) for v in execution.slave_variables(slave)
    }


def main() -> None:
    """Build and run the execution, and write the record."""
    plan = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    nanoseconds = round(1e9 * plan["step"])
    if "ssp" in plan:
        execution = CosimExecution.from_ssp_file(plan["ssp"], nanoseconds)
        slaves = {name: execution.slave_index_from_instance_name(name) for name in plan["instances"]}
    else:
        execution = CosimExecution.from_step_size(nanoseconds)
        local = {name: CosimLocalSlave(path, name) for name, path in plan["fmus"].items()}
        slaves = {name: execution.add_local_slave(slave) for name, slave in local.items()}
    table = {name: references(execution, index) for name, index in slaves.items()}

    def find(path: str) -> tuple[int, int]:
        name, variable = path.split(".", 1)
        return slaves[name], table[name][variable][0]

    for path, value in plan.get("values", {}).items():
        if not execution.real_initial_value(*find(path), value):
            raise SystemExit(f"{path}: not set")
    for source, sink in plan.get("connections", []):
        if execution.connect_real_variables(*find(source), *find(sink)) != 0:
            raise SystemExit(f"{source} to {sink}: {get_last_error_message()}")
    observer = CosimObserver.create_last_value()
    if not execution.add_observer(observer):
        raise SystemExit("no observer")
    with Path(plan["out"]).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time", *plan["record"]])
        for row in range(plan["count"] // plan["every"]):
            if not execution.step(plan["every"]):
                raise SystemExit(f"step {row * plan['every']} failed")
            values = [observer.last_real_values(slave, [vr])[0] for slave, vr in map(find, plan["record"])]
            writer.writerow([repr((row + 1) * plan["every"] * plan["step"]), *map(repr, values)])


if __name__ == "__main__":
    main()
