"""Python environments in build/ with pinned versions: one for simulations and tests, and others by name."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path

from fly import stamp
from fly.stages import BUILD, ROOT, StageError, run

FLIGHTS = ROOT / "tools" / "flights.txt"
"""What a flight needs."""
TESTS = ROOT / "tests" / "requirements.txt"
"""What the tests need besides."""


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


def for_tests() -> Environment:
    """Return the environment of the tests."""
    return ready("tests", TESTS)


def ready(name: str = "", requirements: Path = FLIGHTS) -> Environment:
    """Return an environment; create it if it is missing or its requirements have changed."""
    own = f"{name}-" if name else ""
    path = os.pathsep.join(
        [str(ROOT / "tools"), *([os.environ["PYTHONPATH"]] if "PYTHONPATH" in os.environ else [])]
    )
    # The digest is the same for the user's Python and for that of another environment made from it.
    expected = stamp.digest([requirements, FLIGHTS], sys.version, sys.base_prefix)
    install = ["-m", "pip", "install", "--disable-pip-version-check", "-r", requirements]
    if importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip"):
        home = BUILD / f"{own}venv"
        python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        _fill(home, python, expected, venv=[sys.executable, "-m", "venv", home], pip=[python, *install])
        return Environment(python, {"PYTHONPATH": path})
    # This Python was packaged without venv.
    if importlib.util.find_spec("pip"):
        home, python = BUILD / f"{own}site", Path(sys.executable)
        _fill(home, python, expected, pip=[python, *install, "--target", home])
        return Environment(python, {"PYTHONPATH": os.pathsep.join([str(home), path])}, shared=True)
    raise StageError("this Python has neither venv nor pip; on Debian and Ubuntu: apt install python3-venv.")


def _fill(home: Path, python: Path, expected: str, **commands: list[str | Path]) -> None:
    """Fill a folder with commands, each with a log of its name, unless its stamp is current and its Python exists."""
    mark = home / "stamp"
    if not (stamp.is_fresh(mark, expected) and python.exists()):
        shutil.rmtree(home, ignore_errors=True)
        for log, command in commands.items():
            run(command, log=log)
        stamp.write(mark, expected)
