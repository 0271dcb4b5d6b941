"""Run a plan with the FMI++ Library, which requires unpacked FMUs: `python fly_fmipp.py PROGRAM PLAN.json`."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description


def main() -> int:
    """Unpack the FMUs of the plan, replace them by their URIs, and run the program."""
    program, path = Path(sys.argv[1]), Path(sys.argv[2])
    plan = json.loads(path.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as name:
        folders = {key: Path(extract(fmu, Path(name) / key)) for key, fmu in plan["fmus"].items()}
        plan["fmus"] = {key: folder.as_uri() for key, folder in folders.items()}
        plan["identifiers"] = {
            key: read_model_description(folder).coSimulation.modelIdentifier
            for key, folder in folders.items()
        }
        unpacked = Path(name) / "plan.json"
        unpacked.write_text(json.dumps(plan), encoding="utf-8")
        return subprocess.run([program, unpacked], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
