"""FMUs with binaries for several platforms: requirements of the binaries, and equal results."""

from __future__ import annotations

import os
import shutil
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from platform import machine

import pefile
import pytest
from conftest import SQUID, Run
from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection
from fly import libraries, platforms
from fly.master import Signals
from fly.package import Packages
from fly.record import differences
from fly.stages import ROOT
from macholib.mach_o import (
    CPU_TYPE_NAMES,
    LC_BUILD_VERSION,
    LC_CODE_SIGNATURE,
    LC_ID_DYLIB,
    LC_LOAD_DYLIB,
    LC_RPATH,
    MH_DYLIB,
    PLATFORM_MACOS,
)
from macholib.MachO import MachO, MachOHeader
from macholib.SymbolTable import SymbolTable
from native import Plan, Unpacked, compile_host, program

AGREEMENT = 1e-12
GLIBC = (2, 17)
SYSTEM_LIBRARIES = {
    "linux64": {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "libdl.so.2", "libpthread.so.0", "librt.so.1"}
    | {"ld-linux-x86-64.so.2"},
    "aarch64-linux": {
        "libc.so.6",
        "libm.so.6",
        "libgcc_s.so.1",
        "libdl.so.2",
        "libpthread.so.0",
        "librt.so.1",
    }
    | {"ld-linux-aarch64.so.1"},
    "win64": {"kernel32.dll", "ntdll.dll"},
    "darwin64": {
        "/usr/lib/libSystem.B.dylib",
        "/usr/lib/libcharset.1.dylib",
        "/usr/lib/libiconv.2.dylib",
    },
}
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
WINDOWS_API_SETS = "api-ms-win-"
MACHINES = {"linux64": "EM_X86_64", "aarch64-linux": "EM_AARCH64"}
# Guard against code that the FMUs do not need: a TOML parser or a solver takes more than the remaining space.
LARGEST = {"plant": 1_060_000, "controller": 950_000, "loop": 1_480_000}
KINDS = ["plant", "controller", "loop"]
FOLDERS = list(platforms.TARGETS)


@pytest.fixture(scope="session")
def everywhere(squid: Packages, run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Packages:
    """Return the FMUs of Squid with binaries for all platforms."""
    platforms.build_all(FOLDERS)
    folder = shutil.copytree(squid.folder, tmp_path_factory.mktemp("everywhere") / "out")
    done = run_squid("package", SQUID, "--platforms", "all", "--out", folder)
    assert done.returncode == 0, done.stderr
    return Packages.found_in(folder)


@pytest.fixture(scope="session")
def unpacked(everywhere: Packages, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Unpacked]:
    """Return the three FMUs unpacked."""
    folder = tmp_path_factory.mktemp("unpacked")
    return {kind: Unpacked.of(getattr(everywhere, kind), folder / kind) for kind in KINDS}


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    """Return each kind of FMU in turn."""
    return request.param


@pytest.mark.night
def test_one_fmu_holds_all_platforms(everywhere: Packages, kind: str) -> None:
    fmu = getattr(everywhere, kind)
    with zipfile.ZipFile(fmu) as archive:
        binaries = {name for name in archive.namelist() if name.startswith("binaries/")}
    suffixes = {"linux64": ".so", "win64": ".dll", "aarch64-linux": ".so", "darwin64": ".dylib"}
    assert binaries == {f"binaries/{folder}/{fmu.stem}{suffix}" for folder, suffix in suffixes.items()}


@pytest.mark.night
@pytest.mark.parametrize("folder", ["linux64", "aarch64-linux"])
def test_linux_binaries_ask_for_little(unpacked: dict[str, Unpacked], kind: str, folder: str) -> None:
    with unpacked[kind].binary(folder).open("rb") as file:
        elf = ELFFile(file)
        assert elf["e_machine"] == MACHINES[folder]
        needed = {tag.needed for tag in elf.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")}
        assert needed <= SYSTEM_LIBRARIES[folder], needed
        assert glibc_versions(elf), "nothing of the C library is versioned"
        assert max(glibc_versions(elf)) <= GLIBC
        assert elf.get_section_by_name(".symtab") is None, "not stripped"
        assert not [section.name for section in elf.iter_sections() if section.name.startswith(".debug")]


@pytest.mark.change
@pytest.mark.skipif(platforms.here() is None, reason="Zig does not link the binaries of this machine")
def test_the_main_job_needs_no_newer_glibc_than_all_platforms(
    packages: Packages, kind: str, tmp_path: Path
) -> None:
    """The requirement does not depend on the glibc of this machine."""
    binary = Unpacked.of(getattr(packages, kind), tmp_path).binary(platforms.here())
    with binary.open("rb") as file:
        versions = glibc_versions(ELFFile(file))
    assert versions and max(versions) <= GLIBC


def glibc_versions(elf: ELFFile) -> list[tuple[int, ...]]:
    """Return the versions of the C library that a binary requires."""
    sections = [section for section in elf.iter_sections() if isinstance(section, GNUVerNeedSection)]
    names = [
        auxiliary.name for section in sections for _, more in section.iter_versions() for auxiliary in more
    ]
    return [tuple(map(int, name[6:].split("."))) for name in names if name.startswith("GLIBC_")]


@pytest.mark.night
def test_windows_binaries_ask_for_little(unpacked: dict[str, Unpacked], kind: str) -> None:
    """In particular not bcryptprimitives.dll, which seeds Rust's HashMap: Wine before 9 lacks it."""
    binary = pefile.PE(str(unpacked[kind].binary("win64")))
    assert binary.FILE_HEADER.Machine == pefile.MACHINE_TYPE["IMAGE_FILE_MACHINE_AMD64"]
    imported = {entry.dll.decode().lower() for entry in binary.DIRECTORY_ENTRY_IMPORT}
    others = {name for name in imported if not name.startswith(WINDOWS_API_SETS)}
    assert others <= SYSTEM_LIBRARIES["win64"], others
    assert "kernel32.dll" in imported
    assert binary.FILE_HEADER.NumberOfSymbols == 0, "not stripped"
    assert not hasattr(binary, "DIRECTORY_ENTRY_DEBUG")


@pytest.mark.night
def test_macos_library_is_one_for_both_processors_and_asks_for_little(
    unpacked: dict[str, Unpacked], kind: str
) -> None:
    """No Mac was available: this checks the file headers, not that the library runs."""
    headers = mach_headers(unpacked[kind].binary("darwin64"))
    assert {CPU_TYPE_NAMES[header.header.cputype] for header in headers} == {"x86_64", "ARM64"}
    for header in headers:
        assert header.header.filetype == MH_DYLIB
        named = {LC_ID_DYLIB: [], LC_LOAD_DYLIB: [], LC_RPATH: []}
        oldest = []
        for load, command, data in header.commands:
            if load.cmd in named:
                named[load.cmd].append(data.rstrip(b"\0").decode())
            elif load.cmd == LC_BUILD_VERSION:
                oldest.append((command.platform, command.minos >> 16, command.minos >> 8 & 0xFF))
        (own,) = named[LC_ID_DYLIB]
        # The name must be that of the right library for either processor: mixed libraries could be joined unnoticed.
        assert own == f"@rpath/libsquid_fmu_{kind}_library.dylib"
        assert "/usr/lib/libSystem.B.dylib" in named[LC_LOAD_DYLIB]
        assert set(named[LC_LOAD_DYLIB]) <= SYSTEM_LIBRARIES["darwin64"]
        assert named[LC_RPATH] == []
        assert oldest == [(PLATFORM_MACOS, *map(int, platforms.MACOS.split(".")))]
        # Apple's processors run only signed code; the linker signs ad hoc.
        is_signed = LC_CODE_SIGNATURE in {load.cmd for load, _, _ in header.commands}
        assert is_signed or CPU_TYPE_NAMES[header.header.cputype] == "x86_64"


def mach_headers(binary: Path) -> list[MachOHeader]:
    """Return the header of a macOS library for each of its processors."""
    return MachO(str(binary)).headers


@pytest.mark.night
@pytest.mark.parametrize("folder", FOLDERS)
def test_binaries_name_no_folder_of_the_machine_that_built_them(
    unpacked: dict[str, Unpacked], kind: str, folder: str
) -> None:
    binary = unpacked[kind].binary(folder).read_bytes()
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    for place in (ROOT, home, Path.home() / ".rustup", libraries.target_directory()):
        assert bytes(place) + b"/" not in binary, place


@pytest.mark.night
def test_all_platforms_export_the_same_functions(unpacked: dict[str, Unpacked], kind: str) -> None:
    of_windows = pefile.PE(str(unpacked[kind].binary("win64"))).DIRECTORY_ENTRY_EXPORT.symbols
    names = {"win64": {symbol.name.decode() for symbol in of_windows}}
    for folder in ("linux64", "aarch64-linux"):
        with unpacked[kind].binary(folder).open("rb") as file:
            symbols = ELFFile(file).get_section_by_name(".dynsym").iter_symbols()
            names[folder] = {s.name for s in symbols if s["st_shndx"] != "SHN_UNDEF"}
    for header in mach_headers(unpacked[kind].binary("darwin64")):
        found = {name.decode().removeprefix("_") for _, name in SymbolTable(header.parent, header).extdefsyms}
        names[f"darwin64 {header.header.cputype}"] = found
    functions = [{name for name in found if name.startswith("fmi2")} for found in names.values()]
    assert len(functions) == 5
    assert all(one == functions[0] for one in functions)
    assert {"fmi2Instantiate", "fmi2DoStep", "fmi2GetReal", "fmi2FreeInstance"} <= functions[0]
    assert names["linux64"] == names["aarch64-linux"] == functions[0], "nothing but FMI is exported on Linux"


@pytest.mark.night
@pytest.mark.parametrize("folder", FOLDERS)
def test_binaries_stay_small(unpacked: dict[str, Unpacked], kind: str, folder: str) -> None:
    processors = 2 if folder == "darwin64" else 1
    assert unpacked[kind].binary(folder).stat().st_size <= LARGEST[kind] * processors


def plan_of(kind: str, unpacked: Unpacked) -> Plan:
    """Return a plan in which every part of an FMU is active."""
    if kind == "loop":
        return Plan({}, 0.02, 3000, 50)
    if kind == "controller":
        return Plan({"speed_reference": 2.0, "pitch_reference": 0.1}, 0.02, 1000, 10)
    actuator = next(iter(unpacked.references("input")))
    return Plan({actuator: 10.0, "current_horizontal": 0.1}, 0.02, 1000, 10)


@pytest.fixture(scope="session")
def here(unpacked: dict[str, Unpacked], host: Path) -> Callable[[str], Signals]:
    """Return a function that simulates a kind of FMU on this machine, once."""
    own = platforms.HERE[(sys.platform, machine())]
    return cache(lambda kind: unpacked[kind].flight([host], own, plan_of(kind, unpacked[kind])))


@pytest.fixture(scope="session")
def cross(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return a function that compiles the importer for another platform with Zig, stripped as the FMUs are.

    For unstripped programs Zig compiles the C library of Windows once more, which takes a minute.
    """
    folder = tmp_path_factory.mktemp("cross")
    zig = [platforms.tools().python, "-m", "ziglang", "cc", "-s", "-target"]
    return lambda target, name: compile_host([*zig, target], folder / name)


@pytest.fixture(scope="session")
def windows(
    cross: Callable[[str, str], Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[list[str | Path], dict[str, str]]:
    """Return the command that runs the importer on Windows or Wine, and its variables."""
    host = cross("x86_64-windows-gnu", "host.exe")
    if sys.platform == "win32":
        return [host], {}
    wine = program("wine64", "wine64", "/usr/lib/wine/wine64", "wine")
    return [wine, host], {"WINEPREFIX": str(tmp_path_factory.mktemp("wine")), "WINEDEBUG": "-all"}


@pytest.fixture(scope="session")
def arm(cross: Callable[[str, str], Path]) -> list[str | Path]:
    """Return the command that runs the importer on 64-bit ARM."""
    host = cross(f"aarch64-linux-gnu.{platforms.GLIBC}", "host-arm")
    if machine() == "aarch64":
        return [host]
    emulator = program("qemu-user", "qemu-aarch64")
    program("libc6-arm64-cross", str(ARM_LIBRARIES / "lib" / "ld-linux-aarch64.so.1"))
    return [emulator, "-L", ARM_LIBRARIES, host]


def agree(one: Signals, other: Signals) -> None:
    found = differences(one, other)
    assert len(found) > 2
    assert max(found.values()) <= AGREEMENT, found
    assert any(abs(signal[-1] - signal[0]) > 1e-3 for name, signal in one.items() if name != "time")


@pytest.mark.night
def test_flies_on_windows(
    unpacked: dict[str, Unpacked],
    kind: str,
    here: Callable[[str], Signals],
    windows: tuple[list[str | Path], dict[str, str]],
) -> None:
    command, variables = windows
    plan = plan_of(kind, unpacked[kind])
    agree(here(kind), unpacked[kind].flight(command, "win64", plan, root="Z:", variables=variables))


@pytest.mark.night
def test_flies_on_arm(
    unpacked: dict[str, Unpacked], kind: str, here: Callable[[str], Signals], arm: list[str | Path]
) -> None:
    plan = plan_of(kind, unpacked[kind])
    agree(here(kind), unpacked[kind].flight(arm, "aarch64-linux", plan))
