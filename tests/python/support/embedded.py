"""The C autopilot of `squid export`: compiled for this and other machines, and simulated in place of an FMU."""

from __future__ import annotations

import ctypes
import re
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from conftest import PITCHING, Run
from fly import platforms
from fly.package import Packages
from fly.stages import ROOT
from native import program

DRIVERS = ROOT / "tests" / "embedded"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
M4 = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding", "-nostdlib")
MORE, LARGE = 2, 4096
"""Numbers that hold the status after the outputs, and any state."""
SIZES = {"pitch": 0.1, "speed": 1.5, "pitch_rate": 0.1, "heave": 0.1, "age": 0.25}
"""How far a signal or an age moves in the random ticks (rad, m/s, rad/s, m/s, s)."""
NEVER = 0xFFFFFFFF
"""Ticks after which no measurement is stale."""


def gcc() -> list[str | Path]:
    """Return the command of gcc."""
    return [program("gcc", "gcc")]


def clang(*target: str) -> list[str | Path]:
    """Return the command of Zig's clang, without Zig's own additions."""
    return [platforms.tools().python, "-m", "ziglang", "cc", "-fno-sanitize=all", *target]


def arm_gcc() -> list[str | Path]:
    """Return the command of gcc for a Cortex-M4."""
    return [program("gcc-arm-none-eabi", "arm-none-eabi-gcc"), *M4]


def call(*words: str | Path | int) -> str:
    """Run a program that must succeed, and return its output."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    return done.stdout


@dataclass(frozen=True)
class Exported:
    """Header and source of one autopilot."""

    folder: Path
    name: str

    @classmethod
    def of(cls, run_squid: Run, packages: Packages, folder: Path, *options: str) -> Exported:
        """Export the design of some FMUs."""
        vehicle = PITCHING if packages.vehicle == "remus100" else ROOT / "vehicles" / packages.vehicle
        done = run_squid("export", vehicle, "--out", packages.folder, "--to", folder, *options)
        assert done.returncode == 0, done.stderr
        (header,) = folder.glob("*.h")
        return cls(folder, header.stem)

    @property
    def header(self) -> Path:
        """Path of the header."""
        return self.folder / f"{self.name}.h"

    @property
    def source(self) -> Path:
        """Path of the source."""
        return self.folder / f"{self.name}.c"

    def members(self, struct: str) -> list[str]:
        """Return the names of the numbers in a struct of the header, in order."""
        text = self.header.read_text(encoding="utf-8").split(f"}} {self.name}_{struct};")[0]
        return re.findall(rf"{self.name}_real (\w+);", text.rsplit("typedef struct {", 1)[1])

    def constant(self, name: str) -> float:
        """Return a constant of the header."""
        text = self.header.read_text(encoding="utf-8")
        found = re.search(rf"#define \w+?_{name} (\S+)", text)[1].rstrip("u")
        return float(int(found, 16) if found.startswith("0x") else found)

    def has(self, name: str) -> bool:
        """Return True if the header has a constant."""
        return re.search(rf"#define \w+?_{name} ", self.header.read_text(encoding="utf-8")) is not None

    def without_noise(self) -> Exported:
        """Disable the check for constant measurements, which are those of a simulation in trim."""
        text = self.source.read_text(encoding="utf-8")
        text, count = re.subn(r"(\.stale = )\d+u", rf"\g<1>{NEVER}u", text)
        assert count == sum(name.endswith("_age") for name in self.members("inputs"))
        self.source.write_text(text, encoding="utf-8")
        return self

    def ticks(self) -> list[str]:
        """Return the options that define a driver's random ticks."""
        names = self.members("inputs")
        signals = ["age" if name.endswith("_age") else name.removesuffix("_reference") for name in names]
        middle = (self.constant("SPEED_MINIMUM") + self.constant("SPEED_MAXIMUM")) / 2.0
        bits = {
            name: int(self.constant(f"LOST_{name}"))
            for name in ("SPEED", "DEPTH", "PITCH", "HEADING")
            if self.has(f"LOST_{name}")
        }
        speed = bits.pop("SPEED", 0)
        middles = {"speed": middle, "age": SIZES["age"]}
        return [
            f'-DHEADER="{self.name}.h"',
            f"-DOF(name)={self.name}_##name",
            f"-DSAMPLE_TIME={self.constant('SAMPLE_TIME')!r}",
            f"-DMIDDLE={{{', '.join(repr(middles.get(signal, 0.0)) for signal in signals)}}}",
            f"-DSIZES={{{', '.join(repr(SIZES[signal]) for signal in signals)}}}",
            f"-DSENSORS={signals.count('age')}",
            f"-DSTALE_AFTER={self.constant('STALE_AFTER')!r}",
            f"-DLOST_SPEED={speed}u",
            f"-DRECKONED={sum(bits.values())}u",
            f"-I{self.folder}",
            f"-I{DRIVERS}",
        ]

    def program(
        self,
        to: Path,
        compiler: Sequence[str | Path],
        driver: str,
        *link: str | Path,
        defined: str = "-DNDEBUG",
    ) -> Path:
        """Compile a driver and the source into a folder, and link both.

        The source is compiled with a user's plain options. The driver gives the same numbers everywhere only if
        products and sums are not fused.
        """
        own, source = to / f"{driver}.o", to / f"{self.name}.o"
        plain = [*compiler, "-O2", "-std=c99", "-Wall", "-Wextra", "-Werror"]
        call(*plain, "-c", "-o", source, self.source)
        call(*plain, "-ffp-contract=off", defined, *self.ticks(), "-c", "-o", own, DRIVERS / f"{driver}.c")
        call(*compiler, "-o", to / driver, own, source, *link)
        return to / driver


class Shell:
    """The compiled autopilot with the functions of FMPy's FMU, so that the master can step it."""

    def __init__(self, exported: Exported, references: dict[str, int]) -> None:
        library = exported.folder / "autopilot.so"
        call(*gcc(), "-O2", *STRICT, "-shared", "-fPIC", "-o", library, exported.source)
        self.library, self.name = ctypes.CDLL(str(library)), exported.name
        wide = f"typedef double {self.name}_real;" in exported.header.read_text(encoding="utf-8")
        real = ctypes.c_double if wide else ctypes.c_float
        members = exported.members("inputs")
        self.inputs = [name for name in members if not name.endswith("_age")]
        self.outputs = exported.members("outputs")
        self.names = {number: name for name, number in references.items()}
        self.taken = (real * len(members))()
        self.given = (real * (len(self.outputs) + MORE))()
        self.state = (ctypes.c_double * LARGE)()
        self.is_ready = False
        self.call("init", self.state, self.given)

    def call(self, name: str, *arguments: ctypes.Array) -> None:
        """Call a function of the source, which must succeed."""
        assert getattr(self.library, f"{self.name}_{name}")(*arguments) == 0

    def setReal(self, references: Sequence[int], values: Sequence[float]) -> None:  # noqa: N802 - as in FMPy
        """Set inputs."""
        for number, value in zip(references, values, strict=True):
            self.taken[self.inputs.index(self.names[number])] = value

    def getReal(self, references: Sequence[int]) -> list[float]:  # noqa: N802 - as in FMPy
        """Return outputs; before the first tick they follow the inputs."""
        if not self.is_ready:
            self.call("reset", self.state, self.taken, self.given)
        return [self.given[self.outputs.index(self.names[number])] for number in references]

    def exitInitializationMode(self) -> None:  # noqa: N802 - as in FMPy
        """Restart with the current inputs."""
        self.call("reset", self.state, self.taken, self.given)
        self.is_ready = True

    def doStep(self, **_: float) -> None:  # noqa: N802 - as in FMPy
        """Run one tick."""
        self.call("step", self.state, self.taken, self.given)

    def __getattr__(self, name: str) -> Callable[..., None]:
        """Return a function that does nothing, for calls that only an FMU needs."""
        if name not in ("setupExperiment", "enterInitializationMode", "terminate", "freeInstance"):
            raise AttributeError(name)
        return lambda **_: None
