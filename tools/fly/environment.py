"""Python environments in build/ with pinned versions: one for flights and tests, and others by name."""

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
    shared: bool = False
    """Whether this is the user's own interpreter, with the packages in a separate folder."""

    @property
    def scripts(self) -> Path:
        """Folder of the commands that the packages install."""
        site = self.variables["PYTHONPATH"].split(os.pathsep)[0]
        return Path(site) / "bin" if self.shared else self.python.parent

    def run(self, *words: str | Path, log: str | None = None) -> None:
        """Run this Python with arguments."""
        run([self.python, *words], variables=self.variables, log=log)


def ready(name: str = "", requirements: Path = REQUIREMENTS) -> Environment:
    """Return an environment; create it if it is missing or its requirements have changed."""
    own = f"{name}-" if name else ""
    path = os.pathsep.join(
        [str(ROOT / "tools"), *([os.environ["PYTHONPATH"]] if "PYTHONPATH" in os.environ else [])]
    )
    # The same whether the user's Python asks or that of another environment here, made of it.
    expected = stamp.digest([requirements], sys.version, sys.base_prefix)
    if importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip"):
        python = _venv(BUILD / f"{own}venv", requirements, expected)
        return Environment(python, {"PYTHONPATH": path})
    if importlib.util.find_spec("pip"):
        site = _site(BUILD / f"{own}site", requirements, expected)
        variables = {"PYTHONPATH": os.pathsep.join([str(site), path])}
        return Environment(Path(sys.executable), variables, shared=True)
    raise StageError("this Python has neither venv nor pip; on Debian and Ubuntu: apt install python3-venv.")


def _venv(home: Path, requirements: Path, expected: str) -> Path:
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    mark = home / "stamp"
    if not (stamp.is_fresh(mark, expected) and python.exists()):
        shutil.rmtree(home, ignore_errors=True)
        run([sys.executable, "-m", "venv", home], log="venv")
        run([python, "-m", "pip", "install", "--disable-pip-version-check", "-r", requirements], log="pip")
        stamp.write(mark, expected)
    return python


def _site(home: Path, requirements: Path, expected: str) -> Path:
    """Install into a folder, for a Python that was packaged without venv."""
    mark = home / "stamp"
    if not stamp.is_fresh(mark, expected):
        shutil.rmtree(home, ignore_errors=True)
        install = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check"]
        run([*install, "--target", home, "-r", requirements], log="pip")
        stamp.write(mark, expected)
    return home
