"""Two ways to simulate a part of a campaign on a worker: the files sent, and the processing of the results."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fly.package import Packages

from squid_campaign.worker import CONTROLLER, PLANT, fly_by_command, fly_fmus

Part = tuple[int, int]
"""The first and the last flight of a file of results."""

LARGEST = 4 << 30
"""The most that the records of a part may unpack to, in bytes."""


class CampaignError(Exception):
    """A campaign ended early; the message says why."""


class Command:
    """The command `squid campaign` with the user's arguments."""

    def __init__(self, squid: str, words: list[str]) -> None:
        self.squid, self.words = squid, words

    def run(self, *more: str, aloud: bool = False) -> str:
        """Run it with further arguments, and return its output unless that is for the user."""
        return self.call("campaign", *self.words, *more, aloud=aloud)

    def call(self, *words: str, aloud: bool = False) -> str:
        """Run `squid` with only these arguments."""
        to = None if aloud else subprocess.PIPE
        try:
            done = subprocess.run([self.squid, *words], stdout=to, encoding="utf-8", check=False)
        except OSError as reason:
            raise CampaignError(f"{self.squid}: {reason.strerror}; name the command with --squid.") from None
        if done.returncode != 0:
            # The command has printed the reason.
            sys.exit(done.returncode)
        return done.stdout or ""

    def ask(self, *more: str) -> dict[str, Any]:
        """Return the missing parts and the directory of the results; with `--only` also the random values."""
        return json.loads(self.run(*more, "--dry-run", "--json"))


class ByCommand:
    """A worker runs the command, and sends a file of results."""

    def __init__(self, command: Command, asked: dict[str, Any]) -> None:
        self.squid, self.asked, self.version = command.squid, asked, command.call("--version")

    def files(self) -> dict[str, bytes]:
        """Return the files that a worker needs: vehicle, design, sea."""
        campaign, design = self.asked["campaign"], Path(self.asked["design"])
        vehicle, sea = Path(campaign["vehicle"]), campaign["sea"]
        names = ("vehicle.toml", f"{campaign['design']}.toml")
        found = {f"vehicle/{name}": (vehicle / name).read_bytes() for name in names}
        # The folder of an axis is in that of its autopilot.
        stored = [path for folder in (design, *design.iterdir()) for path in folder.glob("*.json")]
        to = Path("design", campaign.get("axis", ""))
        found |= {str(to / path.relative_to(design)): path.read_bytes() for path in stored}
        return found | ({"sea.toml": sea.encode()} if sea else {})

    def task(self, name: str, part: Part) -> Callable[[], bytes]:
        """Return the function that a worker calls, without a name, so that Dask sends its code."""
        campaign = self.asked["campaign"]
        words = ["--design", campaign["design"], "--out", "design", "--seed", str(campaign["seed"])]
        words += ["--points", campaign["points"]]
        words += ["--axis", campaign["axis"]] if "axis" in campaign else []
        words += ["--starts", campaign["starts"]] if "starts" in campaign else []
        words += ["--sea", "sea.toml"] if campaign["sea"] else []
        words += [] if campaign["bandwidth"] is None else ["--bandwidth", repr(campaign["bandwidth"])]
        command, version = [self.squid, "campaign", "vehicle", *words], self.version
        return lambda: fly_by_command(name, command, version, part)

    def keep(self, part: Part, results: bytes) -> None:
        """Write the file completely or not at all."""
        first, last = part
        path = Path(self.asked["to"], f"flights-{first:08}-{last:08}.parquet")
        unfinished = path.with_name(f".squid-{path.name}.part")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as file:
                file.write(results)
                # Some file systems report only here that they are full.
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(path)
        except OSError as reason:
            unfinished.unlink(missing_ok=True)
            raise CampaignError(f"{path}: cannot be written: {reason.strerror}.") from None


class ByFmus:
    """A worker simulates the FMUs, and sends records, which the command evaluates on this machine."""

    def __init__(self, command: Command, asked: dict[str, Any], records: Path) -> None:
        self.command, self.asked, self.records = command, asked, records

    def files(self) -> dict[str, bytes]:
        """Return the FMUs; raise an error if they do not belong to the design."""
        folder = Path(self.asked["design"])
        packages = Packages.found_in(folder)
        remedy = "run `squid package` for this design first."
        try:
            designed = (folder / "controller.json").read_bytes()
            with zipfile.ZipFile(packages.controller) as archive:
                inside = archive.getinfo("resources/controller.json")
                # No more than the file's size is read.
                same = inside.file_size == len(designed) and archive.read(inside) == designed
            fmus = {PLANT: packages.plant.read_bytes(), CONTROLLER: packages.controller.read_bytes()}
        except OSError as reason:
            raise CampaignError(f"{reason.filename}: {reason.strerror}; {remedy}") from None
        except (KeyError, zipfile.BadZipFile) as reason:
            raise CampaignError(
                f"{packages.controller} is no FMU of a controller: {reason}; {remedy}"
            ) from None
        if not same:
            raise CampaignError(f"{packages.controller} is of another design; {remedy}")
        return fmus

    def task(self, name: str, part: Part) -> Callable[[], bytes]:
        """Return the function that a worker calls, without a name, so that Dask sends its code."""
        drawn = self.command.ask("--only", "{}-{}".format(*part))["drawn"]
        return lambda: fly_fmus(name, drawn)

    def keep(self, part: Part, results: bytes) -> None:
        """Let the command evaluate the records, which writes the file of results."""
        with zipfile.ZipFile(io.BytesIO(results)) as archive:
            size = sum(record.file_size for record in archive.infolist())
            if size > LARGEST:
                raise CampaignError(f"the records of {part} have {size} bytes; at most {LARGEST} are read.")
            try:
                archive.extractall(self.records)
            except OSError as reason:
                raise CampaignError(f"{self.records}: cannot be written: {reason.strerror}.") from None
            self.command.run("--only", "{}-{}".format(*part))
            for name in archive.namelist():
                (self.records / name).unlink()
