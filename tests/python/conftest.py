"""Shared fixtures: the command, the FMUs of two vehicles made by the main job, and of others, each made once."""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from types import ModuleType

import pytest
from filelock import FileLock
from fly import build, stamp, wheel
from fly.package import Design, Packages, design_and_package
from fly.stages import BUILD, ROOT
from native import compile_host, program
from tiers import check

Run = Callable[..., subprocess.CompletedProcess]

KEPT = BUILD / "tests"
"""What was designed and packaged, by the hash of what it is made from: for all processes and the next run."""
KEPT_FOR = 7 * 86400.0
"""What nothing has asked for so long (s) is removed."""
LONGEST = (
    "test_report_pages",
    "test_closed_loop",
    "test_constant",
    "test_uncertainty",
    "test_importers",
    "test_platforms",
    "test_other_systems",
    "test_verdict",
    "test_command_line",
)
CRATES = ("crates", "fmu-plant", "fmu-controller", "fmu-loop", "modelDescription")
"""What the Python package is compiled from."""
UNBROKEN = "100000"
"""So many columns that no line of the command is broken."""
SQUID = ROOT / "vehicles" / "squid"
REMUS100 = ROOT / "vehicles" / "remus100"
"""With an autopilot of depth, speed and heading: two axes."""
ERRORS_ALONE = ROOT / "tests" / "designs" / "errors_alone.toml"


FAILED = "boxed failed"
"""The class of what a report has in place of a section that could not be computed."""


def in_pitch(vehicle: Path) -> Path:
    """Write the folder of a vehicle with its design of pitch as the default, and return it."""
    to = KEPT / "vehicles" / vehicle.name
    to.mkdir(parents=True, exist_ok=True)
    with FileLock(to.with_suffix(".lock")):
        for name, source in (("vehicle", "vehicle"), ("design", "pitch")):
            text = (vehicle / f"{source}.toml").read_text(encoding="utf-8")
            path = to / f"{name}.toml"
            if not path.is_file() or path.read_text(encoding="utf-8") != text:
                path.write_text(text, encoding="utf-8")
    return to


PITCHING = in_pitch(REMUS100)
"""REMUS 100 with its design of pitch alone as the default."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Check the tiers, and start with the files that take longest, so that they do not finish last."""
    check(items)
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


@pytest.fixture(scope="session")
def squid_command() -> Path:
    """Return the command `squid`, with the binaries of the FMUs built beside it."""
    KEPT.mkdir(parents=True, exist_ok=True)
    with FileLock(KEPT / "build.lock"):
        build.build()
    return build.squid()


@pytest.fixture(scope="session")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the small importer for this machine."""
    return compile_host([program("gcc", "cc", "gcc", "clang")], tmp_path_factory.mktemp("host") / "host")


@pytest.fixture(scope="session")
def run_squid(squid_command: Path) -> Run:
    """Return a function that runs `squid` with arguments and returns exit code and output.

    Output is not wrapped as it is for people, unless a number of columns is given; with "" it is.
    """

    def run(
        *words: str | Path, timeout: float = 300.0, columns: str = UNBROKEN, cwd: Path = ROOT
    ) -> subprocess.CompletedProcess:
        return subprocess.run(
            [squid_command, *map(str, words)],
            cwd=cwd,
            capture_output=True,
            text=True,
            timeout=timeout,
            env={**os.environ, "COLUMNS": columns},
            check=False,
        )

    return run


def refusal(done: subprocess.CompletedProcess, key: str, code: int = 1) -> dict:
    """Return the answer to --json of a command that refuses with this key and this exit code."""
    answer = json.loads(done.stdout)
    assert (done.returncode, answer["key"]) == (code, key), answer
    assert answer["reason"].strip() in done.stderr and "panicked" not in done.stderr
    return answer


def mistakes(done: subprocess.CompletedProcess) -> list[tuple[int, str]]:
    """Return line and key, or kind, of each mistake in a file, as the answer to --json of a command that refuses it."""
    found = refusal(done, "file")["mistakes"]
    return [(mistake["line"], mistake.get("key", mistake["problem"])) for mistake in found]


def allowed_keys(found: list[dict]) -> dict[str, set[str]]:
    """Return the keys that are allowed in each table, by mistakes that are unknown keys in these tables."""
    allowed: dict[str, set[str]] = {}
    for mistake in found:
        if mistake["problem"] == "unknown_key":
            allowed.setdefault(mistake["key"].rpartition(".")[0], set()).update(
                mistake["allowed"].split(", ")
            )
    return allowed


def messages(done: subprocess.CompletedProcess, **folders: Path) -> str:
    """Return what the command wrote to standard error, for a snapshot, with each folder by its name."""
    return named(done.stderr, **folders)


def named(text: str, **folders: Path) -> str:
    """Return a text for a snapshot, with each folder by its name."""
    # A folder inside another is named first.
    named_folders = sorted({**folders, "ROOT": ROOT}.items(), key=lambda one: -len(str(one[1])))
    for name, folder in named_folders:
        text = text.replace(str(folder), name)
    return text


def masked(text: str) -> str:
    """Return a text for a snapshot, with # for each decimal fraction: computed digits depend on the machine."""
    return re.sub(r"\d+\.\d+(?:e[+-]?\d+)?", "#", text)


def kinds(report: dict, of: str = "findings") -> list[str]:
    """Return the kinds of the findings of a report, or of the warnings of an answer."""
    return [found["kind"] for found in report[of]]


def design(run_squid: Run, vehicle: Path, folder: Path, *options: str) -> None:
    """Design a vehicle into a folder; the output is in `design.txt`."""
    written(run_squid, folder, "design", vehicle, "--no-advise", *options)


def package(run_squid: Run, vehicle: Path, folder: Path, *options: str) -> Packages:
    """Design and package a vehicle into a folder; the output of each verb is in a file of its name."""
    design(run_squid, vehicle, folder, *options)
    written(run_squid, folder, "package", vehicle, *options)
    return Packages.found_in(of_axis(folder, options))


def of_axis(folder: Path, options: tuple[str, ...]) -> Path:
    """Return the folder of the named axis below that of all, or that folder itself if no axis is named."""
    return folder / options[options.index("--axis") + 1] if "--axis" in options else folder


def written(run_squid: Run, folder: Path, verb: str, vehicle: Path, *options: str) -> None:
    """Run a verb of the command that writes to a folder; its output is in a file of its name."""
    done = run_squid(verb, vehicle, "--out", folder, *options, timeout=900.0)
    assert done.returncode == 0, f"squid {verb}:\n{done.stdout}\n{done.stderr}"
    (folder / f"{verb}.txt").write_text(done.stdout, encoding="utf-8")


def once(made_from: Iterable[Path], words: Iterable[str], make: Callable[[Path], object]) -> Path:
    """Return the folder that `make` fills, once for the same files and words; it must not be changed."""
    folder = KEPT / stamp.digest(made_from, *words)[:16]
    KEPT.mkdir(parents=True, exist_ok=True)
    with FileLock(KEPT / f"{folder.name}.lock"):
        if not folder.is_dir():
            unfinished = KEPT / f"{folder.name}.unfinished"
            shutil.rmtree(unfinished, ignore_errors=True)
            make(unfinished)
            unfinished.rename(folder)
        os.utime(folder)
    return folder


def designed(run_squid: Run, vehicle: Path, *options: str) -> Path:
    """Return the folder of a design, made once; it must not be changed."""
    made_from = [build.squid(), *sorted(vehicle.glob("*.toml"))]
    make = lambda folder: design(run_squid, vehicle, folder, *options)  # noqa: E731
    return of_axis(once(made_from, ["design", *options], make), options)


def kept(run_squid: Run, vehicle: Path, *options: str) -> Packages:
    """Return the packages of a vehicle, made once; they must not be changed."""
    made_from = [build.squid(), *build.binaries(), *sorted(vehicle.glob("*.toml"))]
    made = once(made_from, options, lambda folder: package(run_squid, vehicle, folder, *options))
    return Packages.found_in(of_axis(made, options))


def heading_alone(run_squid: Run) -> Path:
    """Return the folder of the heading axis of REMUS 100 with its package, made once; it must not be changed."""
    return kept(run_squid, REMUS100, "--axis", "heading").folder


def rewritten(fmu: Path, copy: Path, name: str, change: Callable[[bytes], bytes | None]) -> Path:
    """Copy an FMU with one of its entries changed, or left out if `change` returns None."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(copy, "w", zipfile.ZIP_DEFLATED) as target:
        for entry in source.infolist():
            content = source.read(entry)
            new = change(content) if entry.filename == name else content
            if new is not None:
                target.writestr(entry, new)
    return copy


def with_rate(vehicle: Path) -> Path:
    """Return REMUS 100 with a limit of 60 deg/s on the rate of its planes, which is an example."""
    shutil.copytree(PITCHING, vehicle)
    path, head = vehicle / "vehicle.toml", 'name = "stern_planes"\n'
    text = path.read_text(encoding="utf-8")
    assert text.count(head) == 1
    rate = 'rate = { value = 60.0, unit = "deg/s", source = "an example" }\n'
    path.write_text(text.replace(head, head + rate), encoding="utf-8")
    return vehicle


def of_main_job(run_squid: Run, vehicle: Path) -> Packages:
    """Return the result of the main job for a vehicle, which runs if necessary; it must not be changed."""
    default = Design(vehicle, "design")
    KEPT.mkdir(parents=True, exist_ok=True)
    with FileLock(KEPT / f"{vehicle.name}.lock"):
        return design_and_package(default, default.folder, [])


def reported(run_squid: Run, vehicle: Path) -> str:
    """Return the page of the report on a vehicle, made once."""
    return report_in(run_squid, vehicle, designed(run_squid, vehicle))


def report_in(run_squid: Run, vehicle: Path, folder: Path) -> str:
    """Return the page of the report on a stored design, made once."""
    with FileLock(KEPT / f"{folder.name}.lock"):
        if not (folder / "report.html").is_file():
            written(run_squid, folder, "report", vehicle)
    return (folder / "report.html").read_text(encoding="utf-8")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Remove results of earlier files."""
    for old in KEPT.glob("*"):
        if time.time() - old.stat().st_mtime > KEPT_FOR:
            shutil.rmtree(old) if old.is_dir() else old.unlink()


@pytest.fixture(scope="session")
def squid(run_squid: Run) -> Packages:
    """Return the FMUs of the surrogate of Squid."""
    return of_main_job(run_squid, SQUID)


@pytest.fixture(scope="session")
def remus100(run_squid: Run) -> Packages:
    """Return the FMUs of REMUS 100 in pitch, which steers by stern planes."""
    return kept(run_squid, PITCHING)


@pytest.fixture(scope="session")
def turning(run_squid: Run) -> Packages:
    """Return the FMUs of REMUS 100 in six degrees of freedom, with its axes of depth and of heading."""
    return of_main_job(run_squid, REMUS100)


@pytest.fixture(scope="session")
def rate_limited(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Packages:
    """Return the FMUs of REMUS 100 with a limit on the rate of its planes."""
    return kept(run_squid, with_rate(tmp_path_factory.mktemp("rate") / "remus100"))


@pytest.fixture(scope="session")
def squid_by_errors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the vehicle of Squid with a design whose controller uses tracking errors only."""
    vehicle = tmp_path_factory.mktemp("errors") / "vehicle"
    vehicle.mkdir()
    shutil.copy(SQUID / "vehicle.toml", vehicle)
    shutil.copy(ERRORS_ALONE, vehicle / "design.toml")
    return vehicle


@pytest.fixture(scope="session")
def quick_vehicle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return Squid with the tuning of the paper and no uncertainty, for tests of any design: it takes a second.

    The tuning is too slow for a reference beyond the envelope, after which 15.4 % of the step remain: 20 % are allowed.
    """
    folder = tmp_path_factory.mktemp("quick")
    shutil.copytree(SQUID, folder / "whole")
    shutil.copy(SQUID / "paper.toml", folder / "whole" / "design.toml")
    vehicle = without_uncertainty(folder / "whole", folder / "squid")
    with (vehicle / "design.toml").open("a", encoding="utf-8") as file:
        file.write("\n[require]\nbeyond_recovery = 20.0  # %\n")
    return vehicle


@pytest.fixture(params=["squid", "remus100"])
def packages(request: pytest.FixtureRequest) -> Packages:
    """Return the FMUs of each vehicle in turn."""
    return request.getfixturevalue(request.param)


@pytest.fixture(params=["squid", "remus100", "turning"])
def all_packages(request: pytest.FixtureRequest) -> Packages:
    """Return the FMUs of each vehicle in turn, and of one in six degrees of freedom."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def copied_vehicle(tmp_path: Path) -> Path:
    """Return a copy of the vehicle of Squid that a test may modify."""
    return Path(shutil.copytree(SQUID, tmp_path / "vehicle"))


@pytest.fixture
def stored_design(squid: Packages, tmp_path: Path) -> Path:
    """Return a copy of the design of Squid that a test may modify, without FMUs."""
    return Path(
        shutil.copytree(squid.folder, tmp_path / "out", ignore=shutil.ignore_patterns("*.fmu", "*.ssp"))
    )


def without_uncertainty(vehicle: Path, copy: Path) -> Path:
    """Copy a vehicle without its uncertainty: the same controller, and a report without the work on mu."""
    shutil.copytree(vehicle, copy)
    design = copy / "design.toml"
    certain, found, _ = design.read_text(encoding="utf-8").partition("\n[uncertainty]\n")
    assert found
    design.write_text(f"{certain}\n", encoding="utf-8")
    return copy


def wheel_for(platform: str, *, optimised: bool = True) -> Path:
    """Return the wheel for a platform, built once."""
    crates = [path for folder in CRATES for path in sorted((ROOT / folder).rglob("*"))]
    sources = [
        path
        for path in crates
        if path.is_file() and path.suffix != ".pyc" and "tests" not in path.relative_to(ROOT).parts
    ]
    tools = [*sorted((ROOT / "tools" / "fly").glob("*.py")), *sorted((ROOT / "tools").glob("*.txt"))]
    made_from = [ROOT / "Cargo.toml", ROOT / "Cargo.lock", *tools, *sources]
    compiler = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    flags = [os.environ.get(name, "") for name in ("RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS")]
    words = ["wheel", platform, str(optimised), compiler, *flags]
    folder = once(made_from, words, lambda folder: wheel.build(platform, folder, optimised=optimised))
    return next(folder.rglob("*.whl"))


@pytest.fixture(scope="session")
def wheel_file() -> Path:
    """Return the wheel of this machine."""
    return wheel_for("host")


@pytest.fixture(scope="session")
def site(wheel_file: Path) -> Path:
    """Return a folder with only the package."""
    site = KEPT / "wheel-site"
    with FileLock(KEPT / "wheel.lock"):
        mark, expected = site / "stamp", stamp.digest([wheel_file])
        if not stamp.is_fresh(mark, expected):
            install = [
                sys.executable,
                "-m",
                "pip",
                "install",
                "--quiet",
                "--no-deps",
                "--upgrade",
                "--target",
                site,
            ]
            subprocess.run([*install, wheel_file], check=True)
            stamp.write(mark, expected)
    return site


@pytest.fixture(scope="session")
def sq(site: Path) -> ModuleType:
    """Return the package."""
    sys.path.insert(0, str(site))
    return importlib.import_module("squid_lpv")
