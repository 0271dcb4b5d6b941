"""Importers of `tests/importers`: their commands, and the check of their results."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from filelock import FileLock
from fly import environment, record
from fly.environment import Environment
from fly.master import Signals
from fly.stages import BUILD, ROOT

FOLDER = ROOT / "tests" / "importers"


class ImporterError(Exception):
    """An importer failed."""


@cache
def others() -> Environment:
    """Return the Python environment with the importers from PyPI; the first of two processes creates it."""
    BUILD.mkdir(exist_ok=True)
    with FileLock(BUILD / "importers.lock"):
        return environment.ready("importers", ROOT / "tests" / "importers.txt")


def of_pypi(name: str) -> list[str | Path]:
    """Return the command of an importer from PyPI; the plan follows as an argument."""
    return [others().python, FOLDER / f"fly_{name}.py"]


def fly(importer: list[str | Path], plan: Mapping, folder: Path) -> Signals:
    """Simulate a plan; check exit code and record, because some importers end with 0 after a failure."""
    path, out = folder / "plan.json", folder / "record.csv"
    path.write_text(json.dumps({**plan, "out": str(out)}), encoding="utf-8")
    done = subprocess.run([*importer, path], capture_output=True, text=True, timeout=120, check=False)
    output = f"{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    if done.returncode != 0 or not out.is_file():
        raise ImporterError(output)
    signals = record.read(out)
    if len(signals["time"]) != plan["count"] // plan["every"]:
        raise ImporterError(f"{len(signals['time'])} rows: {output}")
    return signals
