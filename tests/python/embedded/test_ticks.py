"""The autopilot in C against the controller's FMU, bit for bit: on this machine, 64-bit ARM, and a microcontroller."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from platform import machine

import pytest
from conftest import Run
from elftools.elf.elffile import ELFFile
from embedded import DRIVERS, STRICT, Exported, arm_gcc, call, clang, gcc
from fly import platforms
from fly.package import Packages
from native import Unpacked, program

pytestmark = pytest.mark.change

TICKS, TICKS_OF_M4 = 1_000_000, 3000
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
LARGEST = {
    "double": {"flash": 17_700, "state": 432, "stack": 1350},
    "float": {"flash": 10_700, "state": 248, "stack": 700},
}
"""Bytes on a Cortex-M4, as docs/embedding.md states them: of the source alone, without arithmetic of the compiler."""


@pytest.fixture(scope="module", params=["double", "float"])
def real(request: pytest.FixtureRequest) -> str:
    """Return each number type in turn."""
    return request.param


@pytest.fixture(scope="module")
def exported(
    squid: Packages, run_squid: Run, tmp_path_factory: pytest.TempPathFactory, real: str
) -> Exported:
    """Return the autopilot of Squid with a number type; it must not be changed."""
    return Exported.of(run_squid, squid, tmp_path_factory.mktemp(real), "--real", real)


def against_fmu(exported: Exported, packages: Packages, folder: Path) -> subprocess.CompletedProcess:
    """Run the random ticks in the source and in the controller's FMU."""
    fmu = Unpacked.of(packages.controller, folder / "fmu")
    references = fmu.references("input") | fmu.references("output")
    valid = {name.replace("_valid", "_age"): one for name, one in fmu.references("input", "Boolean").items()}
    references |= {name: one for name, one in valid.items() if name.endswith("_age")}
    flags = fmu.references("output", "Boolean") | fmu.references("output", "Enumeration")
    flags |= fmu.references("parameter")
    words = [
        exported.program(folder, gcc(), "against_fmu", "-ldl"),
        fmu.binary(platforms.HERE[(sys.platform, machine())]),
        fmu.guid,
        f"file://{(fmu.folder / 'resources').as_posix()}",
        TICKS,
        *(flags[name] for name in ("speed_out_of_range", "reference_limited", "status", "stale_after")),
        *(references[name] for name in exported.members("inputs") + exported.members("outputs")),
    ]
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)


def test_every_bit_is_that_of_the_fmu(packages: Packages, run_squid: Run, tmp_path: Path) -> None:
    """Resets, speeds out of range, limits of commands and references, lost sensors, and NaN."""
    exported = Exported.of(run_squid, packages, tmp_path / "c")
    done = against_fmu(exported, packages, tmp_path)
    assert done.returncode == 0, done.stderr
    ok, refused, *others = map(int, done.stdout.split()[1:])
    assert ok + refused + sum(others[:2]) == TICKS
    resets, *often = others[2:]
    print(refused, *others)
    assert refused > 100 and resets > 100
    assert all(0.02 * TICKS < count < 0.9 * TICKS for count in often)


def test_the_comparison_sees_the_last_bit(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """One number of the source is changed by its last digit."""
    exported = Exported.of(run_squid, squid, tmp_path / "c")
    text = exported.source.read_text(encoding="utf-8")
    changed, count = re.subn(r"HALF_RANGE = (\S+);", r"HALF_RANGE = \1 + \1 * 0x1p-52;", text)
    assert count == 1
    exported.source.write_text(changed, encoding="utf-8")
    done = against_fmu(exported, squid, tmp_path)
    assert done.returncode == 1 and done.stderr.startswith("output ")


@pytest.mark.night
def test_the_same_bits_on_arm(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """On ARM every compiler would fuse a product and a sum into one rounding."""
    exported = Exported.of(run_squid, squid, tmp_path / "c")
    expected = call(exported.program(tmp_path, gcc(), "hash"), TICKS)
    of_arm = exported.program(tmp_path, clang("-target", f"aarch64-linux-gnu.{platforms.GLIBC}"), "hash")
    emulator = [] if machine() == "aarch64" else [program("qemu-user", "qemu-aarch64"), "-L", ARM_LIBRARIES]
    if emulator:
        program("libc6-arm64-cross", str(ARM_LIBRARIES / "lib" / "ld-linux-aarch64.so.1"))
    assert call(*emulator, of_arm, TICKS) == expected


@pytest.mark.night
def test_runs_on_a_microcontroller(exported: Exported, real: str, tmp_path: Path) -> None:
    """The same bits on a Cortex-M4, where double is emulated by the compiler, within the stated memory."""
    emulator = program("qemu-system-arm", "qemu-system-arm")
    expected = call(exported.program(tmp_path, gcc(), "hash"), TICKS_OF_M4)
    script = ["-T", DRIVERS / "m4.ld", "-Wl,--no-warn-rwx-segments", "-lgcc"]
    image = exported.program(tmp_path, arm_gcc(), "m4", *script, defined=f"-DCOUNT={TICKS_OF_M4}")
    words = [
        "-M",
        "mps2-an386",
        "-nographic",
        "-semihosting-config",
        "enable=on,target=native",
        "-kernel",
        image,
    ]
    done = subprocess.run(
        [emulator, *map(str, words)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    said = (done.stdout + done.stderr).split()
    assert said[0] == expected.strip()
    state, stack = (int(number, 16) for number in said[1:])
    with (tmp_path / f"{exported.name}.o").open("rb") as file:
        sections = list(ELFFile(file).iter_sections())
    kept = [section for section in sections if section["sh_flags"] & 0x2]
    assert not [section for section in kept if section["sh_flags"] & 0x1 and section.data_size], (
        "no variables"
    )
    found = {"flash": sum(section.data_size for section in kept), "state": state, "stack": stack}
    print(f"{real}: {found}")
    assert all(0.5 * most < found[what] <= most for what, most in LARGEST[real].items()), found


@pytest.mark.parametrize("compiler", [gcc, clang, pytest.param(arm_gcc, marks=pytest.mark.night)])
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_compiles_without_a_warning(exported: Exported, compiler, level: str, tmp_path: Path) -> None:
    call(*compiler(), *STRICT, level, "-c", "-o", tmp_path / "x.o", exported.source)


def test_a_header_of_cpp(exported: Exported, tmp_path: Path) -> None:
    program = tmp_path / "x.cpp"
    program.write_text(f'#include "{exported.header.name}"\n', encoding="utf-8")
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    call("g++", *strict, f"-I{exported.folder}", "-c", "-o", tmp_path / "x.o", program)


@pytest.mark.skipif(machine() != "x86_64", reason="the instructions are those of x86-64")
@pytest.mark.parametrize("compiler", [gcc, clang])
def test_no_product_and_sum_are_fused(exported: Exported, compiler, tmp_path: Path) -> None:
    """Products and sums are not fused although compiler and processor could; without the pragma they are."""
    text = exported.source.read_text(encoding="utf-8")
    without = "\n".join(line for line in text.splitlines() if not line.startswith("#pragma"))

    def fuses(source: str) -> bool:
        (tmp_path / "x.c").write_text(f"{source}\n", encoding="utf-8")
        fast = ["-std=gnu99", "-O2", "-g0", "-mfma", f"-I{exported.folder}"]
        call(*compiler(), *fast, "-S", "-o", tmp_path / "x.s", tmp_path / "x.c")
        return "vfmadd" in (tmp_path / "x.s").read_text(encoding="utf-8")

    assert not fuses(text) and fuses(without)


def test_fast_math_is_refused(exported: Exported, tmp_path: Path) -> None:
    words = [*gcc(), "-ffast-math", "-c", "-o", tmp_path / "x.o", exported.source]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "without -ffast-math" in done.stderr
