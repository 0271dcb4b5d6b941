"""All tests, one after the other to the end, with a summary."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fly import build, environment, main_job, room
from fly.stages import ROOT, StageError, run

PYTHON_SOURCES = ("run.py", "tools/fly", "tests/python", "tests/importers")
VEHICLES = ("squid", "remus100")
LEAST_PYTHON = (3, 11)
DISK = 7.0
"""What the first run takes, with some to spare (GB)."""
TEMPORARY = 1.0
"""What temporary files take at the most (GB)."""


@dataclass(frozen=True)
class Check:
    """One group of tests."""

    name: str
    run: Callable[[], None]


def checks() -> list[Check]:
    """List the groups in the order in which they are run: what fails soonest comes first."""
    return [
        Check("Rust: format", lambda: run(["cargo", "fmt", "--all", "--check"])),
        Check("Rust: lints", lints),
        Check("Rust: tests", rust_tests),
        Check("Rust: documentation", documentation),
        Check("FMUs: build", build.build),
        *(Check(f"Main job: {name}", lambda name=name: fly(name)) for name in VEHICLES),
        Check("Published cases", published_cases),
        Check("Python: format, lints", python_lints),
        Check("Python: tests", python_tests),
    ]


def lints() -> None:
    """Run clippy over everything; a warning is an error."""
    run(["cargo", "clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])


def rust_tests() -> None:
    """Run the tests of all crates, and the examples in their documentation."""
    run(["cargo", "test", "--workspace", "--no-fail-fast"])


def documentation() -> None:
    """Build the documentation; a broken link is an error."""
    run(["cargo", "doc", "--workspace", "--no-deps"], variables={"RUSTDOCFLAGS": "-D warnings"})


def fly(name: str) -> None:
    """Run the main job for a vehicle."""
    main_job.run(ROOT / "vehicles" / name, "design")


def published_cases() -> None:
    """Solve the published problems by the command line, and print found against expected."""
    build.build_command()
    run([sys.executable, Path("tests") / "python" / "published_cases.py", build.squid()])


def python_lints() -> None:
    """Run ruff: format, then lints."""
    python = environment.ready()
    configuration = ["--config", ROOT / "tests" / "ruff.toml"]
    python.run("-m", "ruff", "format", "--check", "--diff", *configuration, *PYTHON_SOURCES)
    python.run("-m", "ruff", "check", *configuration, *PYTHON_SOURCES)


def python_tests() -> None:
    """Run pytest."""
    environment.ready().run("-m", "pytest", "-c", Path("tests") / "pytest.ini", "tests/python")


def run_check(check: Check) -> tuple[bool, float]:
    """Run one group, and say whether it passed and how long it took (s)."""
    print(f"\n==> {check.name}", flush=True)
    begin = time.monotonic()
    try:
        check.run()
    except StageError as error:
        print(f"FAILED: {error}", file=sys.stderr, flush=True)
        return False, time.monotonic() - begin
    return True, time.monotonic() - begin


def run_all() -> list[tuple[str, bool, float]]:
    """Run every group, whatever became of those before."""
    return [(check.name, *run_check(check)) for check in checks()]


def run_tests() -> int:
    """Run all tests, print the summary, and return the exit code."""
    if sys.version_info < LEAST_PYTHON:
        raise StageError("the tests need Python 3.11 or later; the main job is content with 3.10.")
    room.ask_for(DISK, TEMPORARY, "the tests")
    begin = time.monotonic()
    results = run_all()
    print("\nSummary")
    for name, passed, seconds in results:
        print(f"  {'passed' if passed else 'FAILED'}  {name:<24} {seconds:7.1f} s")
    failed = sum(not passed for _, passed, _ in results)
    verdict = "All tests passed" if failed == 0 else f"{failed} of {len(results)} groups FAILED"
    print(f"{verdict}, {time.monotonic() - begin:.0f} s in all.")
    return 0 if failed == 0 else 1
