"""Run a plan with the FMU Manipulation Toolbox: its container, an FMU whose binary imports others, run by FMPy.

The container exchanges signals after each step, and during the initialization before the first step.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import simulate_fmu


def container(plan: dict, folder: Path) -> Path:
    """Build a container FMU from the FMUs of a plan."""
    # Plugs of the plan, that is terminals of the FMUs, replace the connections.
    names = {name: Path(path).name for name, path in plan["fmus"].items()}
    for path in plan["fmus"].values():
        shutil.copy(path, folder)

    def find(path: str) -> list[str]:
        slave, variable = path.split(".", 1)
        return [names[slave], variable]

    described = {
        "name": "container.fmu",
        "step_size": plan["step"],
        "auto_link": False,
        "auto_input": False,
        "auto_output": False,
        "fmu": list(names.values()),
        "link": [[*find(one), *find(other)] for one, other in plan.get("plugs", plan["connections"])],
        "start": [[*find(path), value] for path, value in plan["values"].items()],
        "output": [[*find(path), path.replace(".", "_")] for path in plan["record"]],
    }
    (folder / "container.json").write_text(json.dumps(described), encoding="utf-8")
    words = ["-fmu-directory", folder, "-container", "container.json"]
    subprocess.run([Path(sys.executable).with_name("fmucontainer"), *words], cwd=folder, check=True)
    return folder / "container.fmu"


def main() -> None:
    """Run a plan and write the record."""
    plan = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    columns = [path.replace(".", "_") for path in plan["record"]]
    with tempfile.TemporaryDirectory() as folder:
        flown = simulate_fmu(
            container(plan, Path(folder)),
            stop_time=plan["count"] * plan["step"],
            output_interval=plan["step"] * plan["every"],
            output=columns,
        )
    rows = [",".join(["time", *plan["record"]])]
    rows += [",".join(map(repr, map(float, row))) for row in flown[["time", *columns]][1:]]
    Path(plan["out"]).write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
