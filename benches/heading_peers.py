"""Simulate the heading autopilot of REMUS 100 and other heading laws with the FMUs, in six degrees of freedom.

Run `python3 run.py fly vehicles/remus100` first; another folder with its FMUs may be given. Depth, pitch and speed are
controlled by squid in every simulation: a peer commands the rudder only. Writes a table to docs/benchmarks.md.
"""

from __future__ import annotations

import math
import statistics
import sys
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import tomllib
from heading_laws import PEERS, Law
from page import ROOT, in_environment, put

if TYPE_CHECKING:
    from fly.master import Loop, Slave

VEHICLE = ROOT / "vehicles" / "remus100"
FOLDER = ROOT / "build" / "remus100" / "depth-heading"
TICK = 0.02  # s
CURRENT = {"current_north": 0.43, "current_east": 0.25}  # m/s
TURN, TURN_TIME, AFTER = math.radians(-60.0), 10.0, 150.0  # Start of the turn, and time for which it is observed (s).
DEPTHS = 10.0, 30.0  # Before and after the start of the turn (m).
BAND = 0.02  # Fraction of the turn.
HELD = 20.0  # Seconds at the end of a simulation in which the heading must be within the band,
REST = math.radians(1.0)  # and in which the rudder may move by this angle; otherwise it oscillates.
ROLL, ASTRAY = math.radians(60.0), math.pi  # A vehicle beyond this roll or heading error has departed.
NOISE = math.radians(0.3), math.radians(0.1)  # Noise of a sample of the heading, and of its rate.
STEADY = 300.0  # Seconds in which the rudder is measured under noise.
OFFSET, LATER = (
    math.radians(1.0),
    60.0,
)  # Offset of a misaligned rudder, and time at which the heading is measured (s).
CORNERS, SEED = 40, 7
DELAY_SPEEDS = 1.54, 2.1  # m/s
CORNER_SPEEDS = 1.6, 2.1
LONGEST_DELAY = 60  # Ticks.
OURS = "squid"
LAWS: tuple[str, ...] = (OURS, *(peer.name for peer in PEERS))


@dataclass(frozen=True)
class Corner:
    """A vehicle at a corner of the declared uncertainty: its coefficients, and the effect of its rudder.

    The FMU has no parameter for the moment of the rudder: the difference (kg/rad) is applied as an external moment.
    """

    coefficients: dict[str, float]
    moment: float = 0.0
    gain: float = 1.0


NOMINAL = Corner({})


@dataclass(frozen=True)
class Flight:
    """A simulation; the delay of the rudder command is in ticks."""

    vehicle: Corner = NOMINAL
    speed: float = 1.54
    turn: float = TURN
    depths: tuple[float, float] = DEPTHS
    duration: float = TURN_TIME + AFTER
    delay: int = 0
    noise: bool = False
    offset: float = 0.0


class Seen(NamedTuple):
    """Outputs of the plant that are read at each sample."""

    heading: float
    heading_rate: float
    angular_velocity_z: float
    depth: float
    roll: float
    speed: float
    rudder_output: float

    def plus(self, angle: float, rate: float) -> Seen:
        """Return the measurement with errors of the heading and of its rate."""
        return self._replace(
            heading=self.heading + angle,
            heading_rate=self.heading_rate + rate,
            angular_velocity_z=self.angular_velocity_z + rate,
        )


class Turn:
    """The record of a simulation, until its end or until the vehicle departs."""

    def __init__(self, wanted: float) -> None:
        self.wanted = wanted
        self.heading: list[float] = []
        self.depth: list[float] = []
        self.command: list[float] = []
        self.rudder: list[float] = []
        self.departed = False

    def add(self, now: Seen, command: float) -> None:
        """Record a sample."""
        self.heading.append(now.heading)
        self.depth.append(now.depth)
        self.command.append(command)
        self.rudder.append(now.rudder_output)

    def part(self) -> list[float]:
        """Return the completed fraction of the turn, from its start."""
        return [value / self.wanted for value in self.heading[round(TURN_TIME / TICK) :]]

    def settled(self) -> float:
        """Return the time after which the heading stays in the band (s); infinite without rest at the end."""
        part, held = self.part(), round(HELD / TICK)
        last = max((k for k, value in enumerate(part) if abs(value - 1.0) > BAND), default=-1)
        at_rest = last < len(part) - held and max(self.rudder[-held:]) - min(self.rudder[-held:]) < REST
        return (last + 1) * TICK if at_rest and not self.departed else math.inf

    def rise(self) -> float:
        """Return the time from 10 to 90 % of the turn (s)."""
        part = self.part()
        begin, end = (next((k for k, value in enumerate(part) if value >= x), math.inf) for x in (0.1, 0.9))
        return (end - begin) * TICK

    def overshoot(self) -> float:
        """Return the overshoot of the heading (%)."""
        return max(0.0, 100.0 * (max(self.part()) - 1.0))

    def travel(self) -> float:
        """Return the sum of all movements of the rudder (deg)."""
        return math.degrees(sum(abs(b - a) for a, b in pairwise(self.rudder)))


@contextmanager
def vehicle(folder: Path, flight: Flight) -> Iterator[tuple[Loop, dict[str, float]]]:
    """Yield the loop of plant and controller, initialised in trim, and the references before the turn."""
    from fly.master import Loop, Slave

    names = (folder / f"remus100_{name}.fmu" for name in ("plant", "controller"))
    with (
        Slave(next(names), "plant", quiet=True) as plant,
        Slave(next(names), "controller", quiet=True) as controller,
    ):
        start = {"initial_speed": flight.speed, "initial_depth": flight.depths[0], "initial_heading": 0.0}
        plant.begin(start | CURRENT | flight.vehicle.coefficients)
        controller.begin()
        loop = Loop(plant, controller)
        references = {
            "speed_reference": plant.get("speed"),
            "depth_reference": flight.depths[0],
            "heading_reference": 0.0,
        }
        loop.inform(references)
        loop.command()
        plant.ready()
        controller.ready()
        yield loop, references


def fly(folder: Path, law: Law | None, flight: Flight) -> Turn:
    """Simulate the law of a peer, or squid's own if there is none."""
    import numpy as np

    turn, steps = Turn(flight.turn), round(flight.duration / TICK)
    noise = np.random.default_rng(SEED).normal(size=(steps, 2)) * NOISE * flight.noise
    with vehicle(folder, flight) as (loop, references):
        seen = loop.plant.references(Seen._fields)
        waiting = deque([0.0] * flight.delay)
        for k in range(steps):
            if k * TICK >= TURN_TIME:
                references |= {"depth_reference": flight.depths[1], "heading_reference": flight.turn}
            now = Seen(*loop.plant.fmu.getReal(seen))
            loop.inform(references)
            command = decide(loop, law, references["heading_reference"], now.plus(*noise[k]), (k + 1) * TICK)
            waiting.append(command)
            act(loop.plant, flight, waiting.popleft(), now)
            loop.plant.step_to((k + 1) * TICK)
            turn.add(now, command)
            turn.departed = (
                abs(now.roll) > ROLL or abs(now.heading - references["heading_reference"]) > ASTRAY
            )
            if turn.departed:
                break
    return turn


def decide(loop: Loop, law: Law | None, reference: float, measured: Seen, time: float) -> float:
    """Step the controller, apply all commands but the rudder's, and return the rudder command within its limits."""
    loop.controller.set("heading", measured.heading)
    loop.controller.set("heading_rate", measured.heading_rate)
    loop.controller.step_to(time)
    loop.command()
    if law:
        command = -law.rudder(reference, measured.heading, measured.angular_velocity_z)
    else:
        command = loop.controller.get("rudder")
    low, high = loop.plant.limits("rudder")
    return max(low, min(high, command))


def act(plant: Slave, flight: Flight, command: float, now: Seen) -> None:
    """Apply the rudder command to a vehicle that may differ from the plant's."""
    plant.set("rudder", flight.vehicle.gain * command + flight.offset)
    plant.set("external_moment_z", flight.vehicle.moment * now.speed * abs(now.speed) * now.rudder_output)


def made(name: str) -> Law | None:
    """Return a law at its start; None stands for that in squid's FMU."""
    return next((peer.make(TICK) for peer in PEERS if peer.name == name), None)


def corners(folder: Path) -> list[Corner]:
    """Sample corners of the uncertainty declared in design.toml."""
    import numpy as np
    from fly.master import Slave

    with Slave(folder / "remus100_plant.fmu", "plant", quiet=True) as plant:
        plant.begin()
        plant.ready()
        start = plant.start_values()
    declared = tomllib.loads((VEHICLE / "design.toml").read_text(encoding="utf-8"))["uncertainty"]
    surfaces = tomllib.loads((VEHICLE / "vehicle.toml").read_text(encoding="utf-8"))["control_surface"]
    effect = next(one["N_uu_delta"]["value"] for one in surfaces if one["name"] == "rudder")
    ranges = {name: part for name, part in declared["coefficients"].items() if name[0] in "YN" or name[:6] == "rudder"}
    of_rudder = ranges.pop("rudder.N_uu_delta")
    drawn = np.random.default_rng(SEED).choice((-1.0, 1.0), size=(CORNERS, len(ranges) + 2)).tolist()
    return [
        Corner(
            {
                name: start[name] * (1.0 + sign * part)
                for (name, part), sign in zip(ranges.items(), signs, strict=False)
            },
            effect * of_rudder * signs[-2],
            1.0 + declared["actuator_gain"] * signs[-1],
        )
        for signs in drawn
    ]


def nominal(folder: Path, name: str) -> dict[str, float]:
    """Return the figures of the turn of the nominal vehicle."""
    turn, straight = (fly(folder, made(name), Flight(turn=to)) for to in (TURN, 0.0))
    moved = max(abs(a - b) for a, b in zip(turn.depth, straight.depth, strict=False))
    return {
        "rise": turn.rise(),
        "settled": turn.settled(),
        "overshoot": turn.overshoot(),
        "largest rudder": math.degrees(max(map(abs, turn.rudder))),
        "travel": turn.travel(),
        "depth moved": 1e3 * moved,
    }


def under_noise(folder: Path, name: str) -> float:
    """Return the rms of the rudder command in steady flight, under noise (deg)."""
    steady = Flight(turn=0.0, depths=DEPTHS[1:] * 2, duration=TURN_TIME + STEADY, noise=True)
    command = fly(folder, made(name), steady).command[round(TURN_TIME / TICK) :]
    return math.degrees(math.sqrt(statistics.fmean(one * one for one in command)))


def askew(folder: Path, name: str) -> float:
    """Return the heading error held with a misaligned rudder (deg)."""
    held = Flight(turn=0.0, depths=DEPTHS[1:] * 2, duration=LATER, offset=OFFSET)
    return math.degrees(abs(fly(folder, made(name), held).heading[-1]))


def delay_survived(folder: Path, name: str, speed: float) -> float:
    """Return the longest added delay with which, and with every shorter one, the turn settles (ms)."""
    ticks = 0
    while ticks < LONGEST_DELAY and math.isfinite(
        fly(folder, made(name), Flight(speed=speed, delay=ticks + 1)).settled()
    ):
        ticks += 1
    return 1e3 * TICK * ticks


def at_corner(folder: Path, name: str, speed: float, corner: Corner) -> tuple[float, float]:
    """Return the settling time (s) and the overshoot (%) of a vehicle at a corner."""
    turn = fly(folder, made(name), Flight(corner, speed))
    return turn.settled(), turn.overshoot()


@dataclass(frozen=True)
class Row:
    """A row of the table: the difference of two figures, relative to squid's or in their unit, that counts."""

    label: str
    key: str
    places: int = 0
    more: bool = False
    relative: float = 0.02
    absolute: float = 0.0

    def judge(self, ours: float, theirs: float) -> int:
        """Return 1 if squid is better, -1 if the other is, and 0 for a draw."""
        if ours == theirs:
            return 0
        margin = max(self.absolute, self.relative * ours) if math.isfinite(ours) else 0.0
        gain = ours - theirs if self.more else theirs - ours
        return 0 if abs(gain) <= margin else int(math.copysign(1.0, gain))

    def cell(self, value: float) -> str:
        """Return a figure as printed."""
        return f"{value:.{self.places}f}" if math.isfinite(value) else "never"


def at(speed: float) -> str:
    """Return a speed as printed."""
    return f"{speed:g} m/s"


ROWS = (
    Row("turn: rise, 10 to 90 % (s)", "rise", 2),
    Row("turn: settled (s)", "settled", 1),
    Row("turn: overshoot (%)", "overshoot", 1, relative=0.0, absolute=0.5),
    Row("turn: largest rudder (deg)", "largest rudder", 1),
    Row("turn: travel of the rudder (deg)", "travel", 1),
    Row("turn: depth moved (mm)", "depth moved", 1),
    Row("noise: rudder command, rms (deg)", "noise", 2),
    Row("rudder 1 deg askew: heading off after 60 s (deg)", "askew", 3, absolute=0.01),
    *(
        Row(f"added delay with which the turn settles, {at(speed)} (ms)", f"delay {speed}", more=True)
        for speed in DELAY_SPEEDS
    ),
    *(
        row
        for speed in CORNER_SPEEDS
        for row in (
            Row(f"corners, {at(speed)}: settled, of {CORNERS}", f"count {speed}", more=True, relative=0.0),
            Row(f"corners, {at(speed)}: slowest to settle (s)", f"slowest {speed}", 1),
            Row(
                f"corners, {at(speed)}: largest overshoot (%)",
                f"over {speed}",
                1,
                relative=0.0,
                absolute=0.5,
            ),
        )
    ),
)


@dataclass(frozen=True)
class Asked:
    """The running simulations of a law; by speed those with a delay and those at corners."""

    turn: Future[dict[str, float]]
    noise: Future[float]
    askew: Future[float]
    delays: dict[float, Future[float]]
    corners: dict[float, list[Future[tuple[float, float]]]]


def of_corners(speed: float, turns: list[tuple[float, float]]) -> dict[str, float]:
    """Return the number of vehicles that settle, and their worst figures."""
    settled = [(time, over) for time, over in turns if math.isfinite(time)]
    slowest, over = (max((one[k] for one in settled), default=math.inf) for k in (0, 1))
    return {f"count {speed}": len(settled), f"slowest {speed}": slowest, f"over {speed}": over}


def measure(folder: Path) -> dict[str, dict[str, float]]:
    """Simulate every law, on all cores, and return its figures."""
    drawn = corners(folder)
    with ProcessPoolExecutor() as pool:
        asked = {name: ask(pool, folder, name, drawn) for name in LAWS}
        return {name: gathered(name, one) for name, one in asked.items()}


def ask(pool: ProcessPoolExecutor, folder: Path, name: str, drawn: list[Corner]) -> Asked:
    """Start the simulations of a law."""
    return Asked(
        pool.submit(nominal, folder, name),
        pool.submit(under_noise, folder, name),
        pool.submit(askew, folder, name),
        {speed: pool.submit(delay_survived, folder, name, speed) for speed in DELAY_SPEEDS},
        {
            speed: [pool.submit(at_corner, folder, name, speed, one) for one in drawn]
            for speed in CORNER_SPEEDS
        },
    )


def gathered(name: str, asked: Asked) -> dict[str, float]:
    """Return the figures of a law when its simulations have ended, and print them."""
    figures = asked.turn.result() | {"noise": asked.noise.result(), "askew": asked.askew.result()}
    figures |= {f"delay {speed}": delay.result() for speed, delay in asked.delays.items()}
    for speed, turns in asked.corners.items():
        figures |= of_corners(speed, [one.result() for one in turns])
    print(name, *(f"    {row.label}: {row.cell(figures[row.key])}" for row in ROWS), sep="\n", flush=True)
    return figures


def line(row: Row, figures: dict[str, dict[str, float]]) -> str:
    """Return a row of the table, with figures better than squid's in bold."""
    ours = figures[OURS][row.key]
    judged = {name: row.judge(ours, figures[name][row.key]) for name in LAWS[1:]}
    cells = [row.cell(ours)]
    for name, outcome in judged.items():
        cell = row.cell(figures[name][row.key])
        cells.append(f"**{cell}**" if outcome < 0 else cell)
    worst = min(judged.values())
    return "| " + " | ".join((row.label, *cells, {-1: "lost", 0: "drawn", 1: "won"}[worst])) + " |"


def tally(name: str, figures: dict[str, dict[str, float]]) -> str:
    """Return how many rows squid wins, draws and loses against a peer."""
    judged = [row.judge(figures[OURS][row.key], figures[name][row.key]) for row in ROWS]
    won, drawn, lost = (judged.count(outcome) for outcome in (1, 0, -1))
    return f"{name} {won}, {drawn}, {lost}"


def table(figures: dict[str, dict[str, float]]) -> list[str]:
    """Return the table, the tally and the sources of the gains."""
    tallies = "; ".join(tally(name, figures) for name in LAWS[1:])
    return [
        "| | " + " | ".join(LAWS) + " | squid against the best |",
        "|---" * (len(LAWS) + 2) + "|",
        *(line(row, figures) for row in ROWS),
        "",
        f"Rows that squid wins, draws and loses: {tallies}.",
        "",
        *(f"- *{peer.name}*: {peer.source}." for peer in PEERS),
    ]


def main() -> int:
    """Measure, and write the table."""
    in_environment(__file__)
    from fly import fix

    folder = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else FOLDER
    put("heading", fix.wrap("\n".join(table(measure(folder)))).splitlines())
    return 0


if __name__ == "__main__":
    sys.exit(main())
