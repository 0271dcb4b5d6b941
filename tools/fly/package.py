"""Make three FMUs from a vehicle's directory with the command `squid`."""

from __future__ import annotations

import json
import os
import shlex
from dataclasses import dataclass
from pathlib import Path

from fly import build, platforms, stamp
from fly.stages import BUILD, StageError, run

FIGURES = "design.json"


@dataclass(frozen=True)
class Packages:
    """The FMUs of one design of one vehicle."""

    folder: Path
    vehicle: str
    """First part of the names of all three."""

    @classmethod
    def found_in(cls, folder: Path) -> Packages:
        """Return the FMUs in a folder; `design.json` there, or in the folder of an axis, contains their name."""
        found = figures_in(folder)
        if not found:
            raise StageError(f"{folder} has no {FIGURES}; run `squid design` first.")
        path = found[0]
        try:
            figures = json.loads(path.read_text(encoding="utf-8"))
            return cls(folder, str(figures["fmu_identifier"]))
        except OSError as error:
            raise StageError(f"{path}: {error.strerror}.") from None
        except (ValueError, TypeError, KeyError):
            raise StageError(f"{path} has no 'fmu_identifier'; run `squid design` again.") from None

    @property
    def plant(self) -> Path:
        """FMU of the vehicle."""
        return self.folder / f"{self.vehicle}_plant.fmu"

    @property
    def controller(self) -> Path:
        """FMU of the controller."""
        return self.folder / f"{self.vehicle}_controller.fmu"

    @property
    def loop(self) -> Path:
        """FMU of the closed loop."""
        return self.folder / f"{self.vehicle}.fmu"

    @property
    def fmus(self) -> tuple[Path, Path, Path]:
        """All three FMUs."""
        return self.plant, self.controller, self.loop

    @property
    def figures(self) -> list[Path]:
        """Files with the figures of the design, one per axis."""
        return figures_in(self.folder)


def figures_in(folder: Path) -> list[Path]:
    """Return the files of figures in the folder of a design: one there, or one for each axis."""
    return [path for path in (folder / FIGURES, *sorted(folder.glob(f"*/{FIGURES}"))) if path.is_file()]


@dataclass(frozen=True)
class Design:
    """A design of a vehicle."""

    vehicle: Path
    name: str

    def __str__(self) -> str:
        return f"{self.vehicle.resolve().name} (design '{self.name}')"

    def check(self) -> list[Path]:
        """Return the input files; raise an error that names a missing one."""
        sources = [self.vehicle / "vehicle.toml", self.vehicle / f"{self.name}.toml"]
        for source in sources:
            if not source.is_file():
                raise StageError(
                    f"{source}: there is no such file; VEHICLE_DIR must contain vehicle.toml and the design file."
                )
        return sources

    @property
    def folder(self) -> Path:
        """Folder of the main job."""
        return BUILD / self.vehicle.resolve().name / self.name


def report_of(design: Design, folder: Path) -> str:
    """Return the command that writes the full report of a design, as typed in this directory."""
    which = "" if design.name == "design" else f" --design {design.name}"
    return f"cargo squid report {typed(design.vehicle)}{which} --out {typed(folder)}"


def typed(path: Path) -> str:
    """Return a path as typed in a shell."""
    return shlex.quote(os.path.relpath(path))


def design_and_package(design: Design, folder: Path, names: list[str]) -> Packages:
    """Run `squid design` and `squid package`, unless their results exist and nothing has changed since.

    The FMUs support the host platform and those named, by their FMI names.
    """
    sources = design.check()
    binaries = dict.fromkeys([*build.binaries(), *platforms.binaries(names)])
    made_from = [build.squid(), *binaries, *sources]
    words = [design.name, *names]
    mark = folder / "stamp"
    packages = made_before(folder) if mark.is_file() else None
    if packages and stamp.is_fresh(mark, digest_of(made_from, packages, words)):
        print("    nothing has changed since the last run")
        return packages
    folder.mkdir(parents=True, exist_ok=True)
    mark.unlink(missing_ok=True)
    which = [design.vehicle, "--design", design.name, "--out", folder]
    run([build.squid(), "design", *which])
    run([build.squid(), "package", *which, "--platforms", platforms.option(names)])
    packages = Packages.found_in(folder)
    if not packages.plant.is_file():
        raise StageError(
            f"{sources[1]} is a design of heading alone, which is packed as a controller ({packages.controller}): "
            "to fly it, put it beside one of pitch or depth, each as an [[axis]] of one file."
        )
    stamp.write(mark, digest_of(made_from, packages, words))
    return packages


def made_before(folder: Path) -> Packages | None:
    """Return the FMUs of an earlier run if all exist; an earlier version may have written other files."""
    try:
        packages = Packages.found_in(folder)
    except StageError:
        return None
    return packages if all(path.is_file() for path in packages.fmus) else None


def digest_of(made_from: list[Path], packages: Packages, words: list[str]) -> str:
    """Return the digest of the inputs and the outputs of a design."""
    return stamp.digest([*made_from, *packages.fmus, *packages.figures], *words)
