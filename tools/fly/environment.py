"""The Python environment of the flights and the tests: FMPy and its company, in build/, versions pinned."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path

from fly import stamp
from fly.stages import BUILD, ROOT, StageError, run

REQUIREMENTS = ROOT / "tests" / "requirements.txt"


@dataclass(frozen=True)
class Environment:
    """A Python interpreter and the variables that it needs."""

    python: Path
    variables: dict[str, str] = field(default_factory=dict)

    def run(self, *words: str | Path, log: str | None = None) -> None:
        """Run this Python with arguments."""
        run([self.python, *words], variables=self.variables, log=log)


def ready() -> Environment:
    """Return the environment, made first if it is missing or its requirements have changed."""
    path = os.pathsep.join(
        [str(ROOT / "tools"), *([os.environ["PYTHONPATH"]] if "PYTHONPATH" in os.environ else [])]
    )
    expected = stamp.digest([REQUIREMENTS], sys.version, sys.executable)
    if importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip"):
        python = _venv(expected)
        return Environment(python, {"PYTHONPATH": path})
    if importlib.util.find_spec("pip"):
        site = _site(expected)
        return Environment(Path(sys.executable), {"PYTHONPATH": os.pathsep.join([str(site), path])})
    raise StageError("this Python has neither venv nor pip; on Debian and Ubuntu: apt install python3-venv.")


def _venv(expected: str) -> Path:
    home = BUILD / "venv"
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    mark = home / "stamp"
    if not (stamp.is_fresh(mark, expected) and python.exists()):
        shutil.rmtree(home, ignore_errors=True)
        run([sys.executable, "-m", "venv", home], log="venv")
        run([python, "-m", "pip", "install", "--disable-pip-version-check", "-r", REQUIREMENTS], log="pip")
        stamp.write(mark, expected)
    return python


def _site(expected: str) -> Path:
    """Install beside the interpreter, for a Python that was packaged without venv."""
    home = BUILD / "site"
    mark = home / "stamp"
    if not stamp.is_fresh(mark, expected):
        shutil.rmtree(home, ignore_errors=True)
        install = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check"]
        run([*install, "--target", home, "-r", REQUIREMENTS], log="pip")
        stamp.write(mark, expected)
    return home
