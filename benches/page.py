"""Code shared by the scripts: their environment, a design, and their tables in docs/benchmarks.md."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from fly import build, environment  # noqa: E402


def in_environment(script: str, name: str = "tests", requirements: Path = environment.TESTS) -> None:
    """Restart a script in an environment in build/, which is created if it is missing."""
    if os.environ.get("SQUID_BENCH") == "1":
        return
    found = environment.ready(name, requirements)
    variables = {**os.environ, **found.variables, "SQUID_BENCH": "1"}
    sys.exit(subprocess.run([found.python, script, *sys.argv[1:]], env=variables, check=False).returncode)


def squid(*words: str | Path) -> None:
    """Run the command `squid` of the main job."""
    subprocess.run([str(word) for word in (build.squid(), *words)], check=True, stdout=subprocess.DEVNULL)


def full_order(folder: Path, *, anti_windup: bool) -> tuple[Path, Path]:
    """Design Squid's proved.toml at full order, which takes 20 s; return the vehicle and the design's folder."""
    vehicle, out = folder / "squid", folder / "design"
    shutil.copytree(ROOT / "vehicles" / "squid", vehicle)
    text = (vehicle / "proved.toml").read_text(encoding="utf-8")
    text = text.replace("[synthesis]\n", "[synthesis]\nreduce = 0\n")
    if not anti_windup:
        text = text.replace("[autopilot]\n", "[autopilot]\nanti_windup = false\n")
    (vehicle / "design.toml").write_text(text, encoding="utf-8")
    squid("design", vehicle, "--out", out)
    return vehicle, out


def put(name: str, lines: list[str]) -> None:
    """Print a table, and write it between its markers in docs/benchmarks.md."""
    path = ROOT / "docs" / "benchmarks.md"
    text = path.read_text(encoding="utf-8")
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    before, rest = text.split(begin)
    table = "\n".join(lines)
    path.write_text(f"{before}{begin}{table}\n{end}{rest.split(end)[1]}", encoding="utf-8")
    print(f"{platform.machine()}\n{table}\n", flush=True)
