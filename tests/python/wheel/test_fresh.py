"""The wheel in an environment of its own, with only NumPy; and its contents."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from fly.stages import ROOT, run

pytestmark = pytest.mark.change

README = ROOT / "crates" / "python" / "README.md"
PROBE = """
import json, sys
import numpy as np
import squid_lpv as sq
P = sq.StateSpace(np.array([[0, 1.], [-2, -.5]]), np.array([[0, 0, 0], [1, 0, 1.]]),
    np.array([[1, 0], [0, 0], [1, 0.]]), np.array([[0, 0, 0], [0, 0, .3], [0, .1, 0]]))
K, CL, gam, rcond = sq.hinfsyn(P, 1, 1)
print(json.dumps([gam, sq.hinfnorm(CL)[0], type(K).__module__, sorted(m for m in sys.modules if m == "scipy")]))
"""


def fresh(wheel_file: Path, home: Path, *beside: str) -> Path:
    """Return the Python of a new environment with a wheel, its requirements, and `beside`; nothing else."""
    shutil.rmtree(home, ignore_errors=True)
    run([sys.executable, "-m", "venv", home], log="wheel-venv")
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install = [python, "-m", "pip", "install", "--disable-pip-version-check", wheel_file, *beside]
    run(install, log="wheel-pip")
    return python


def packages(python: Path) -> set[str]:
    """Return the names of the installed packages besides pip and setuptools."""
    done = subprocess.run(
        [python, "-m", "pip", "list", "--format", "freeze"], capture_output=True, text=True, check=True
    )
    names = {line.partition("==")[0].lower() for line in done.stdout.splitlines() if "==" in line}
    return names - {"pip", "setuptools"}


def test_it_needs_nothing_but_numpy(wheel_file: Path, tmp_path: Path) -> None:
    python = fresh(wheel_file, tmp_path / "venv")
    assert packages(python) == {"numpy", "squid-lpv"}
    done = subprocess.run([python, "-c", PROBE], capture_output=True, text=True, cwd=tmp_path, check=True)
    gam, norm, module, others = json.loads(done.stdout)
    assert norm < gam < 1.2 * norm
    assert (module, others) == ("squid_lpv.systems", [])


def test_what_is_in_it(wheel_file: Path) -> None:
    """Sources, complete stubs of the compiled module, the marker of types, and licences; for every later Python."""
    assert re.fullmatch(r"squid_lpv-[\d.]+-cp310-abi3-\w+\.whl", wheel_file.name)
    with zipfile.ZipFile(wheel_file) as archive:
        names = archive.namelist()
        stub = ast.parse(archive.read("squid_lpv/_core.pyi"))
        metadata = next(name for name in names if name.endswith("METADATA"))
        assert "Requires-Dist: numpy" in archive.read(metadata).decode()
    assert {"squid_lpv/py.typed", "squid_lpv/__init__.py"} <= set(names)
    defined = {node.name for node in stub.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert defined == {
        *("Vehicle", "augw", "gain", "h2syn", "hinfnorm", "mu", "musyn", "prove", "synth"),
    }
