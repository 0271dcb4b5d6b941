#!/usr/bin/env python3
"""Design, package and fly a vehicle from its file, or run all tests."""

import argparse
import shutil
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent

EXAMPLES = {
    "python3 run.py fly": "design and fly the Squid surrogate",
    "python3 run.py fly vehicles/remus100": "another vehicle: depth, speed and heading, in six degrees of freedom",
    "python3 run.py fly --design paper": "another design file of the vehicle: vehicles/squid/paper.toml",
    "python3 run.py fly --platforms all": "FMUs for Linux (x86-64 and ARM), Windows and macOS",
    "python3 run.py wheels": "the Python package for Linux, Windows and macOS",
    "python3 run.py test": "the tests that a change needs, Rust and Python",
    "python3 run.py test --all": "all tests: other platforms and importers, too",
}
NEEDED = (
    "Requirements: cargo (rustup.rs), a C compiler for the linker, Python 3.10 or later (3.11 for the tests), and "
    "for the first run access to the package registries of cargo and pip. All output is in build/ and target/: "
    "3 GB for fly, 5 GB for the tests, 8 GB with --all."
)


def epilog(width: int) -> str:
    """Return the end of the help: the examples, one per line, and the requirements."""
    longest = max(map(len, EXAMPLES))
    lines = [f"  {command:<{longest}}  {what}" for command, what in EXAMPLES.items()]
    wrapped = [textwrap.fill(line, width, subsequent_indent=" " * 6) for line in lines]
    return "\n".join(["examples:", *wrapped, "", textwrap.fill(NEEDED, width)])


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line, with help as wide as the terminal."""
    width = shutil.get_terminal_size().columns - 2
    top = argparse.ArgumentParser(
        prog="run.py",
        description=textwrap.fill(__doc__, width),
        epilog=epilog(width),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    verbs = top.add_subparsers(dest="verb", required=True, metavar="{fly,wheels,test,fix,freeze}")
    fly = verbs.add_parser(
        "fly",
        help="build, design, package, validate, fly, compare, plot",
        description="Build everything, design the controller of a vehicle, write its three FMUs, validate them "
        "with FMPy, simulate plant and controller coupled and in one FMU, compare the two, and plot.",
    )
    fly.add_argument(
        "vehicle",
        nargs="?",
        default=str(ROOT / "vehicles" / "squid"),
        metavar="VEHICLE_DIR",
        help="directory with vehicle.toml and its designs (default: vehicles/squid)",
    )
    fly.add_argument(
        "--design",
        default="design",
        metavar="NAME",
        help="name of the design file in VEHICLE_DIR, without .toml (default: design)",
    )
    fly.add_argument(
        "--platforms",
        default="host",
        metavar="LIST",
        help="platforms of the FMUs: host, all, or a comma-separated list of linux64, win64, "
        "aarch64-linux, darwin64 (default: host; macOS was never run)",
    )
    wheels = verbs.add_parser(
        "wheels",
        help="build the Python package squid-lpv",
        description="Build the wheels of the Python package squid-lpv, one a platform, into build/wheels.",
    )
    wheels.add_argument(
        "--platforms",
        default="all",
        metavar="LIST",
        help="host, for this machine alone; all (default), or a comma-separated list of linux64, win64, "
        "aarch64-linux, darwin64, for any such machine (macOS was never run)",
    )
    test = verbs.add_parser(
        "test",
        help="tests: format, lints, Rust, documentation, generated files, Python",
        description="Run the tests that a change needs, on this machine's platform, also after a failure, and print "
        "a summary. Exit code 0: all passed.",
    )
    test.add_argument(
        "--all",
        action="store_true",
        help="other platforms (Wine, QEMU), their wheels, Valgrind, importers that are compiled first, the report in "
        "Chromium, long searches and fuzzing, too; .ci/run --all installs what they need",
    )
    fix = verbs.add_parser(
        "fix",
        help="for contributors: format Rust, Python and Markdown as the tests ask",
        description="Format in place what the tests check: cargo fmt, ruff format and ruff check --fix, and prose in "
        "Markdown of more than 120 columns. It does not regenerate the generated files: `run.py freeze` does.",
    )
    fix.add_argument(
        "--snapshots",
        action="store_true",
        help="instead, write the messages that tests hold as snapshots again; review them in the diff",
    )
    verbs.add_parser(
        "freeze",
        help="for contributors: regenerate the committed generated files",
        description="Regenerate the frozen design of Squid (vehicles/squid/frozen) and the model descriptions "
        "(modelDescription/*.xml); commit them with the change that altered them.",
    )
    return top


def main() -> int:
    """Run the command and return its exit code."""
    arguments = parser().parse_args()
    if sys.version_info < (3, 10):
        print("Python 3.10 or later is required; this is %d.%d." % sys.version_info[:2], file=sys.stderr)
        return 1
    sys.path.insert(0, str(ROOT / "tools"))
    from fly import all_tests, fix, freeze, main_job, package, wheel
    from fly.stages import StageError

    try:
        if arguments.verb == "fly":
            design = package.Design(Path(arguments.vehicle), arguments.design)
            return main_job.run(design, arguments.platforms)
        if arguments.verb == "wheels":
            return wheel.build_all(arguments.platforms)
        if arguments.verb == "fix":
            return fix.snapshots() if arguments.snapshots else fix.fix()
        if arguments.verb == "freeze":
            return freeze.freeze()
        return all_tests.run_tests(arguments.all)
    except StageError as error:
        print(f"\nStopped: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nInterrupted.", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
