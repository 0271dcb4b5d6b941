"""The importer of the FMI++ Library, compiled from its sources and the headers of Boost, both from PyPI."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fly import libraries, platforms, stamp
from importers import FOLDER, others
from native import program

LIBRARY, BOOST = "fmipp==2.1.0", "cmeel-boost==1.90.0"
PARTS = ("base", "integrators")


def built() -> Path:
    """Return the program, made first if it is missing or its source has changed."""
    source = FOLDER / "fmipp" / "fly.cpp"
    folder = libraries.target_directory() / "importers" / "fmipp"
    made, mark = folder / "fly-fmipp", folder / "stamp"
    compiler = program("g++", "g++", "clang++")
    expected = stamp.digest([source], LIBRARY, BOOST, compiler)
    if not (stamp.is_fresh(mark, expected) and made.exists()):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        with tempfile.TemporaryDirectory() as name:
            compile_in(Path(name), compiler, source, made)
        stamp.write(mark, expected)
    return made


def compile_in(folder: Path, compiler: str, source: Path, made: Path) -> None:
    """Compile library and program in a folder; warnings of the library's own code are hidden."""
    library, boost = sources(folder) / "fmipp", headers(folder)
    words = [compiler, "-std=c++17", *macros(), f"-isystem{library}", f"-isystem{boost}"]
    files = [path for part in PARTS for path in sorted((library / "import" / part / "src").glob("*.cpp"))]
    objects = [folder / f"{path.stem}.o" for path in files]

    def compile_one(file: Path, to: Path) -> None:
        subprocess.run([*words, "-w", "-c", file, "-o", to], check=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(compile_one, files, objects))
    subprocess.run([*words, "-Wall", "-Wextra", "-Werror", source, *objects, "-ldl", "-o", made], check=True)


def macros() -> list[str]:
    """Return the macros for the location of the binary in an FMU, as in the library's own `setup.py`."""
    here = platforms.HERE[sys.platform, platform.machine()]
    return [f'-DFMU_BIN_DIR="{here}"', '-DFMU_BIN_EXT=".so"']


def sources(folder: Path) -> Path:
    """Return the folder with the library's sources, fetched by pip."""
    fetch(folder, "--no-binary", "fmipp", LIBRARY)
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        # Python before 3.11.4 has no such filter and asks for none.
        opened.extraction_filter = getattr(tarfile, "data_filter", None)
        opened.extractall(folder)
    (unpacked,) = folder.glob("fmipp-*/source")
    return unpacked


def headers(folder: Path) -> Path:
    """Return the folder with the headers of Boost, fetched by pip: the same for every Python and platform."""
    wheel = ["--only-binary", ":all:", "--python-version", "3.11", "--platform", "manylinux_2_28_x86_64"]
    fetch(folder, *wheel, BOOST)
    (archive,) = folder.glob("*.whl")
    include = "cmeel.prefix/include/"
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder, [name for name in opened.namelist() if name.startswith(include)])
    return folder / include


def fetch(folder: Path, *words: str) -> None:
    """Download a package into a folder."""
    pip = [others().python, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    subprocess.run([*pip, "--dest", folder, *words], env={**os.environ, **others().variables}, check=True)
