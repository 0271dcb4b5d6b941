"""Measure the processor time of commands against benches/budget.toml: `budget.py SQUID [--every] [--write]`.

Processor time is compared with that of a Python loop, run on every processor at once just afterwards, so that the ratio
depends little on the machine and its load. Prints a line for each command. With `--every` long commands are measured
too, and a ratio beyond 1.5 fails. With `--write` the file is updated with the measurements.
"""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parents[1]
BUDGET = Path(__file__).with_suffix(".toml")
MOST = 1.5
"""Largest ratio of the measured processor time to that of the file."""
LOOP = "x = 0.0\nfor i in range(10_000_000):\n    x += i * 1e-9\n"
"""The calibration loop, about a second."""


def processor_time(commands: list[list[str]]) -> float:
    """Run commands in parallel; return the processor time of all (s)."""

    def used() -> float:
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return children.ru_utime + children.ru_stime

    begin = used()
    running = [subprocess.Popen(words, cwd=ROOT, stdout=subprocess.DEVNULL) for words in commands]
    codes = [one.wait() for one in running]
    if any(codes):
        sys.exit(f"{' '.join(commands[0])}: exit code {max(codes)}")
    return used() - begin


def unit() -> float:
    """Return the processor time of the calibration loop (s)."""
    count = os.cpu_count() or 1
    return processor_time([[sys.executable, "-c", LOOP]] * count) / count


def measured(squid: str, command: dict, out: str) -> float:
    """Return the processor time of a command, in units of the calibration loop."""
    words = [word.replace("{out}", out) for word in command["words"]]
    return processor_time([[squid, *words]]) / unit()


def main() -> int:
    """Measure, print, and return the exit code."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    squid, *options = sys.argv[1:]
    every = "--every" in options
    text = BUDGET.read_text(encoding="utf-8")
    commands = [one for one in tomllib.loads(text)["command"] if every or not one.get("every")]
    beyond = 0
    with tempfile.TemporaryDirectory() as out:
        for command in commands:
            found = measured(squid, command, out)
            ratio = found / command["units"]
            beyond += ratio > MOST
            print(f"  {command['name']:<38} {found:7.2f} units, {ratio:.2f} of its budget", flush=True)
            if "--write" in options:
                of_command = rf'(name = "{re.escape(command["name"])}"\n(?:.*\n)*?units = ).*'
                text = re.sub(of_command, rf"\g<1>{found:.2f}", text, count=1)
    if "--write" in options:
        BUDGET.write_text(text, encoding="utf-8")
    if every and beyond:
        print(f"{beyond} commands take more than {MOST} times their budget", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
