"""The tests, Rust and Python in parallel, with a summary; a failure does not stop the others."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Event

from fly import build, environment, main_job, package, platforms, room
from fly.stages import ROOT, StageError, run

PYTHON_SOURCES = ("run.py", "tools", "crates/python", "tests/python", "tests/importers")
VEHICLES = ("squid", "remus100")
LEAST_PYTHON = (3, 11)
DISK = 5.0
"""Disk space of the first run, with a margin (GB)."""
DISK_OF_ALL = 3.0
"""Additional disk space for other platforms and importers that are compiled (GB)."""
FUZZ_MINUTES = "2"
"""How long each test of random calls runs among all tests."""
TEMPORARY = 1.0
"""Largest disk space of temporary files (GB)."""


@dataclass(frozen=True)
class Check:
    """One group of tests."""

    name: str
    run: Callable[[], None]


def lanes(every: bool) -> tuple[list[Check], list[Check]]:
    """Return the groups of Rust and of Python in the order in which they run: the fastest to fail first.

    These are all groups, or those that a change needs.

    Both lanes run in parallel. Lints, tests and the command share a profile, so that their dependencies are compiled
    once; cargo builds of one profile wait for each other, so Python begins with the binaries, which have another
    profile.
    """
    rust = [
        Check("Rust: format", lambda: run(["cargo", "fmt", "--all", "--check"], log="format")),
        Check("Rust: lints", lints),
        Check("Rust: tests", lambda: rust_tests(every)),
        Check("Rust: tests in the docs", doc_tests),
        Check("Rust: documentation", documentation),
        *([Check("Rust: long fuzz", fuzz)] if every else []),
    ]
    python = [
        Check("Python: format, lints", python_lints),
        Check("FMUs and command", lambda: build.build(list(platforms.TARGETS) if every else ())),
        *(Check(f"Main job: {name}", lambda name=name: fly(name)) for name in VEHICLES),
        Check("Published cases", published_cases),
        Check("Python: tests", lambda: python_tests(every)),
    ]
    return rust, python


def cargo(name: str, *words: str, **variables: str) -> None:
    """Run cargo on the workspace with its output in a log, because the Python tests print at the same time."""
    run(["cargo", words[0], "--release", "--workspace", *words[1:]], variables=variables, log=name)


def lints() -> None:
    """Run clippy over everything; a warning is an error."""
    cargo("lints", "clippy", "--all-targets", "--", "-D", "warnings")


def rust_tests(every: bool) -> None:
    """Run the tests of all crates. The examples are not built: the lints check that they compile."""
    cargo("rust-tests", "test", "--no-fail-fast", "--tests", *(["--", "--include-ignored"] if every else []))


def fuzz() -> None:
    """Fuzz the FMUs for longer than their tests do."""
    words = ["cargo", "test", "--release", "-p", "squid-fmu-loop", "--test", "suite", "--", "random::"]
    run([*words, "--test-threads=12"], variables={"SQUID_FUZZ_MINUTES": FUZZ_MINUTES}, log="fuzz")


def doc_tests() -> None:
    """Run the examples in the documentation of all crates."""
    cargo("rust-doc-tests", "test", "--no-fail-fast", "--doc")


def documentation() -> None:
    """Build the documentation; a broken link is an error."""
    cargo("documentation", "doc", "--no-deps", RUSTDOCFLAGS="-D warnings")


def fly(name: str) -> None:
    """Run the main job for a vehicle."""
    main_job.run(package.Design(ROOT / "vehicles" / name, "design"))


def published_cases() -> None:
    """Solve the published problems with the command `squid`, and print computed and expected values."""
    build.build_command()
    run([sys.executable, Path("tests") / "python" / "support" / "published_cases.py", build.squid()])


def budget(every: bool) -> None:
    """Compare the processor time of commands with benches/budget.toml; with all tests, a large excess fails."""
    build.build_command()
    run([sys.executable, Path("benches") / "budget.py", build.squid(), *(["--every"] if every else [])])


def python_lints() -> None:
    """Run ruff: format, then lints."""
    python = environment.for_tests()
    configuration = ["--config", ROOT / "tests" / "ruff.toml"]
    python.run("-m", "ruff", "format", "--check", "--diff", *configuration, *PYTHON_SOURCES)
    python.run("-m", "ruff", "check", *configuration, *PYTHON_SOURCES)


def python_tests(every: bool) -> None:
    """Run pytest with one process per processor; each test file runs in one process."""
    tier = () if every else ("-m", "not night")
    parallel = ("--numprocesses", "auto", "--dist", "loadfile", "--no-loadscope-reorder")
    words = ("-m", "pytest", "-c", Path("tests") / "pytest.ini", *parallel, *tier, "tests/python")
    environment.for_tests().run(*words)


def run_check(check: Check) -> tuple[str, bool, float]:
    """Run one group; return its name, whether it passed and how long it took (s)."""
    print(f"\n==> {check.name}", flush=True)
    begin = time.monotonic()
    try:
        check.run()
    except StageError as error:
        print(f"FAILED: {check.name}: {error}", file=sys.stderr, flush=True)
        return check.name, False, time.monotonic() - begin
    seconds = time.monotonic() - begin
    print(f"    {check.name}: passed in {seconds:.1f} s", flush=True)
    return check.name, True, seconds


def run_all(every: bool) -> list[tuple[str, bool, float]]:
    """Run every group, even after a failure; after an interrupt from the keyboard start no further one."""
    stopped = Event()

    def run_lane(lane: list[Check]) -> list[tuple[str, bool, float]]:
        return [run_check(check) for check in lane if not stopped.is_set()]

    with ThreadPoolExecutor() as pool:
        try:
            return [result for lane in pool.map(run_lane, lanes(every)) for result in lane]
        except KeyboardInterrupt:
            stopped.set()
            raise


def run_tests(every: bool) -> int:
    """Run the tests that a change needs, or those of every tier, print the summary, and return the exit code."""
    if sys.version_info < LEAST_PYTHON:
        raise StageError("the tests require Python 3.11 or later; `run.py fly` requires 3.10.")
    room.ask_for(DISK + (DISK_OF_ALL if every else 0.0), TEMPORARY, "the tests")
    begin = time.monotonic()
    results = run_all(every)
    # Measured while nothing else runs; Windows does not report the processor time of a command.
    if sys.platform != "win32":
        results.append(run_check(Check("Processor time", lambda: budget(every))))
    print("\nSummary")
    for name, passed, seconds in results:
        print(f"  {'passed' if passed else 'FAILED'}  {name:<24} {seconds:7.1f} s")
    failed = sum(not passed for _, passed, _ in results)
    verdict = "All tests passed" if failed == 0 else f"{failed} of {len(results)} groups FAILED"
    print(f"{verdict}, {time.monotonic() - begin:.0f} s in total.")
    return 0 if failed == 0 else 1
