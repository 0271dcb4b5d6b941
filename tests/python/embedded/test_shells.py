"""Shells of docs/embedding around the autopilot of Squid, run with a simulated clock and with faults.

`tests/embedded/stand_in` replaces ROS 2 and DUNE. The measurements are slow waves with a little noise: the vehicle is
not simulated, so that commands differ between runs only by the changes of a test.
"""

from __future__ import annotations

import math
import random
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from conftest import SQUID, Run
from embedded import DRIVERS, STRICT, Exported, call, gcc
from fly.stages import ROOT
from native import program
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

STRICT_CPP = ("-std=c++17", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
MEASURED, WANTED = ("pitch", "speed", "pitch_rate"), ("pitch_reference", "speed_reference")
APPLIED = ("lower_applied", "upper_port_applied", "upper_starboard_applied")
TICK, START, FAULT, GAP = 0.02, 100.0, 5.0, 10.0
"""Between two ticks, when the clock begins, how long after that a fault comes, and how long a gap lasts (s)."""
SAFE_WITHIN = 1.0 + TICK
"""From a sensor's last message to the commands that are safe (s)."""
LEAST, MOST = -60.0, 100.0
JUMP = 0.02 * (MOST - LEAST)
"""What a command may change by in a tick (N)."""
FAILED, LOST_PITCH, LOST_SPEED = 0x8, 0x10, 0x20
LOST = {FAILED: "the pitch rate", LOST_PITCH: "the pitch", LOST_SPEED: "the speed"}
ESTA_FAULT = 2

Heard = dict[str, float]
Change = Callable[[float, Heard], None]


@dataclass(frozen=True)
class Tick:
    """Result of a shell at one call of its timer, `time` after the first (s)."""

    time: float
    commands: np.ndarray | None
    status: int
    said: int
    words: str


@dataclass(frozen=True)
class Shell:
    """A compiled shell."""

    name: str
    program: Path

    def fly(self, calls: Iterable[tuple[float, Heard]]) -> Flight:
        """Call the timer at each time with the messages since the last call."""
        calls, signals = list(calls), (*MEASURED, *WANTED, *APPLIED, "engaged")
        lines = [
            " ".join([repr(START + time), *(str(heard.get(signal, "-")) for signal in signals)])
            for time, heard in calls
        ]
        done = subprocess.run(
            [self.program], input="\n".join(lines), capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        safe, *answers = done.stdout.splitlines()
        assert len(answers) == len(calls)
        return Flight(self, np.array(safe.split(), dtype=float), [*map(read, calls, answers)])


def read(called: tuple[float, Heard], answer: str) -> Tick:
    """Parse the answer to one call: all actuators are commanded within their limits, or none."""
    published, *numbers = answer.split(maxsplit=6)
    commands, (status, said, *words) = np.array(numbers[:3], dtype=float), numbers[3:]
    if published == "0":
        return Tick(called[0], None, int(status), int(said), "".join(words))
    assert published == "3" and np.isfinite(commands).all()
    assert (commands >= LEAST).all() and (commands <= MOST).all()
    return Tick(called[0], commands, int(status), int(said), "".join(words))


@dataclass(frozen=True)
class Flight:
    """Results of a shell."""

    shell: Shell
    safe: np.ndarray
    ticks: list[Tick]

    def commands(self, begin: float = 0.0, end: float = math.inf) -> np.ndarray:
        """Return the commands of an interval (s); in it each call must have published all."""
        return np.array([tick.commands for tick in self.ticks if begin - 1e-9 <= tick.time < end - 1e-9])

    def largest_change(self, begin: float = 0.0) -> float:
        """Return the largest change of a command in a tick from a time on."""
        return np.abs(np.diff(self.commands(begin), axis=0)).max()

    def is_safe(self, begin: float, end: float = math.inf) -> bool:
        """Return True if all commands of an interval are those of `squid_safe`."""
        return bool((np.abs(self.commands(begin, end) - self.safe) < 1e-4).all())

    def shows(self, bit: int, tick: int = -1) -> bool:
        """Return True if a tick shows a lost sensor by a bit of the status, by the entity state, and as text."""
        last = self.ticks[tick]
        status = last.status & bit if self.shell.name == "ros2_node" else last.status == ESTA_FAULT
        return bool(status) and f"{LOST[bit]} is" in last.words


@pytest.fixture(scope="module")
def exported(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Return the autopilot of the committed design."""
    folder = tmp_path_factory.mktemp("c")
    done = run_squid("export", SQUID, "--out", SQUID / "frozen", "--to", folder)
    assert done.returncode == 0, done.stderr
    call(*gcc(), *STRICT, "-O2", "-c", "-o", folder / "squid.o", folder / "squid.c")
    return Exported(folder, "squid")


@pytest.fixture(scope="module", params=["ros2_node", "dune_task"])
def shell(request: pytest.FixtureRequest, exported: Exported) -> Shell:
    """Compile each shell in turn, and its driver; no warning is allowed."""
    folder, name = exported.folder, request.param
    compiler = [program("g++", "g++"), *STRICT_CPP, f"-I{folder}", f"-I{DRIVERS / 'stand_in'}"]
    call(*compiler, "-c", "-o", folder / f"{name}.o", ROOT / "docs" / "embedding" / f"{name}.cpp")
    driver = DRIVERS / "shells" / f"{name}.cpp"
    call(*compiler, "-o", folder / name, driver, folder / f"{name}.o", folder / "squid.o")
    return Shell(name, folder / name)


def both(one: Change, other: Change) -> Change:
    """Combine two faults."""

    def change(time: float, heard: Heard) -> None:
        one(time, heard)
        other(time, heard)

    return change


def unchanged(time: float, heard: Heard) -> None:
    """Add no fault."""


def calls(until: float, change: Change = unchanged, period: float = TICK) -> list[tuple[float, Heard]]:
    """Return the messages of each period until a time (s); `change` adds faults. The pilot engages at once."""
    noise, taken = random.Random(1), []
    for k in range(round(until / period)):
        time = k * period
        heard = {
            "pitch": 0.003 * math.sin(0.5 * time) + noise.uniform(-1e-4, 1e-4),
            "speed": 1.5 + 0.01 * math.sin(0.3 * time) + noise.uniform(-1e-3, 1e-3),
            "pitch_rate": 0.0015 * math.cos(0.5 * time) + noise.uniform(-1e-4, 1e-4),
            "pitch_reference": 0.0,
            "speed_reference": 1.5,
            "engaged": 1.0,
        }
        change(time, heard)
        taken.append((time, heard))
    return taken


def silent(*signals: str, begin: float = FAULT, end: float = math.inf) -> Change:
    """Remove signals during an interval (s)."""

    def change(time: float, heard: Heard) -> None:
        for signal in signals if begin <= time < end else ():
            heard.pop(signal, None)

    return change


def set_to(number: float, *signals: str, begin: float = FAULT, end: float = math.inf) -> Change:
    """Set signals to a number during an interval (s)."""

    def change(time: float, heard: Heard) -> None:
        heard.update(dict.fromkeys(signals, number) if begin <= time < end else {})

    return change


def waving(time: float, heard: Heard) -> None:
    """Let the vehicle pitch by 2 degrees, enough to distinguish a stuck sensor from a slow one."""
    heard["pitch"] += 0.035 * math.sin(0.5 * time)
    heard["pitch_rate"] += 0.0175 * math.cos(0.5 * time)


def test_flies(shell: Shell) -> None:
    flight = shell.fly(calls(20.0))
    assert len(flight.commands()) == 1000 and flight.largest_change(1.0) < JUMP
    assert not any(flight.is_safe(time, time + 1.0) for time in range(20))
    assert flight.ticks[-1].said == (1 if shell.name == "dune_task" else 0)


def test_nothing_is_commanded_without_a_message(shell: Shell) -> None:
    flight = shell.fly((k * TICK, {}) for k in range(500))
    assert all(tick.commands is None for tick in flight.ticks)
    assert flight.ticks[-1].said == 1


def test_says_what_is_lost(shell: Shell, snapshot: SnapshotAssertion) -> None:
    faults = [
        silent(*MEASURED, *WANTED, begin=0.0),
        silent("pitch_rate"),
        both(waving, set_to(0.01, "pitch")),
        silent("speed"),
    ]
    assert [shell.fly(calls(15.0, fault)).ticks[-1].words for fault in faults] == snapshot


@pytest.mark.parametrize("missing", [*MEASURED, *WANTED])
def test_nothing_is_commanded_before_all_have_spoken(shell: Shell, missing: str) -> None:
    flight = shell.fly(calls(8.0, silent(missing, begin=0.0, end=FAULT)))
    assert all((tick.commands is None) == (tick.time < FAULT - 1e-9) for tick in flight.ticks)
    assert flight.largest_change(FAULT) < JUMP


@pytest.mark.parametrize(
    "fault",
    [
        silent(*MEASURED),
        silent("pitch", "pitch_rate"),
        silent("pitch_rate"),
        set_to(math.nan, "pitch_rate"),
        set_to(math.inf, "pitch_rate"),
        set_to(0.001, "pitch_rate"),
    ],
    ids=["all silent", "pitch and rate silent", "silent", "NaN", "infinite", "stuck"],
)
def test_commands_are_safe_after_the_pitch_rate_is_lost(shell: Shell, fault: Change) -> None:
    flight = shell.fly(calls(15.0, fault))
    assert not flight.is_safe(FAULT - 1.0, FAULT)
    assert flight.is_safe(FAULT - TICK + SAFE_WITHIN) and len(flight.commands()) == 750
    assert flight.shows(FAILED)
    assert flight.ticks[-1].said - flight.ticks[round(FAULT / TICK)].said <= 2


@pytest.mark.parametrize("stuck", [0.0, 0.01])
def test_a_pitch_that_is_stuck_is_reckoned(shell: Shell, stuck: float) -> None:
    """The pitch rate shows that pitch should have changed."""
    flight = shell.fly(calls(15.0, both(waving, set_to(stuck, "pitch"))))
    assert flight.shows(LOST_PITCH)
    assert not any(flight.is_safe(time, time + 1.0) for time in range(15))


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_flies_on_without_the_pitch(shell: Shell, number: float) -> None:
    """Commands hardly change, because pitch is integrated from its rate."""
    flight = shell.fly(calls(15.0, both(waving, set_to(number, "pitch"))))
    whole = shell.fly(calls(15.0, waving))
    assert flight.shows(LOST_PITCH)
    assert flight.largest_change(1.0) < JUMP
    assert np.abs(flight.commands() - whole.commands()).max() < 1.0


@pytest.mark.parametrize(
    "fault",
    [silent("speed"), set_to(math.nan, "speed"), set_to(1.5, "speed")],
    ids=["silent", "NaN", "stuck"],
)
def test_flies_on_without_the_speed(shell: Shell, fault: Change) -> None:
    flight, whole = shell.fly(calls(15.0, fault)), shell.fly(calls(15.0))
    assert flight.shows(LOST_SPEED) and "pitch" not in flight.ticks[-1].words
    assert flight.largest_change() < JUMP
    assert np.abs(flight.commands() - whole.commands()).max() < 10.0
    assert not any(flight.is_safe(time, time + 1.0) for time in range(15))


@pytest.mark.parametrize(
    "lost", [MEASURED, ("pitch", "pitch_rate"), ("speed",)], ids=["all", "pitch", "speed"]
)
def test_takes_over_without_a_jump_when_sensors_return(shell: Shell, lost: tuple[str, ...]) -> None:
    """The first command is the last one; the next ones change as fast as the autopilot acts."""
    flight = shell.fly(calls(15.0, silent(*lost, end=10.0)))
    shown = LOST_SPEED if lost == ("speed",) else FAILED
    taken = max(tick for tick in range(len(flight.ticks)) if flight.shows(shown, tick)) + 1
    assert flight.ticks[taken].time == pytest.approx(10.0 + 0.5 - TICK)
    commands = flight.commands()
    assert np.abs(commands[taken] - commands[taken - 1]).max() < 0.5
    assert np.abs(commands[-1] - commands[taken]).max() > 0.5 and not flight.is_safe(14.0)


def test_a_reference_that_falls_silent_is_kept(shell: Shell) -> None:
    flight, whole = shell.fly(calls(15.0, silent(*WANTED))), shell.fly(calls(15.0))
    assert np.array_equal(flight.commands(), whole.commands())


def test_a_reference_that_is_no_number_is_not_taken(shell: Shell) -> None:
    """A NaN reference does not hide that a sensor falls silent either."""
    wrong = [set_to(math.nan, wanted) for wanted in WANTED]
    flight, whole = shell.fly(calls(15.0, both(*wrong))), shell.fly(calls(15.0))
    assert np.array_equal(flight.commands(), whole.commands())
    blind = shell.fly(calls(15.0, both(both(*wrong), silent("pitch_rate", begin=8.0))))
    assert blind.is_safe(8.0 + SAFE_WITHIN) and blind.shows(FAILED)


@pytest.mark.parametrize("period", [0.026, 0.034, 0.08])
def test_missed_ticks_are_made_up_for(shell: Shell, period: float) -> None:
    """The timer is too slow while the speed reference rises; otherwise this takes longer."""
    rise = set_to(1.6, "speed_reference", begin=1.0)
    whole, slow = shell.fly(calls(8.0, rise)), shell.fly(calls(8.0, rise, period))
    ticks = [tick for tick in slow.ticks if 1.0 < tick.time < 8.0 - TICK]
    expected = np.array([whole.ticks[round(tick.time / TICK)].commands for tick in ticks])
    assert np.ptp(expected, axis=0).min() > 5.0
    assert np.abs([tick.commands for tick in ticks] - expected).max() < 1.0


def after_a_gap(shell: Shell, change: Change = unchanged) -> Flight:
    """Miss all ticks of a gap. DUNE then calls once for each of them, which must have no effect."""
    steps = [step for step in calls(30.0, change) if not FAULT - 1e-9 <= step[0] < FAULT + GAP - 1e-9]
    if shell.name == "ros2_node":
        return shell.fly(steps)
    first = round(FAULT / TICK) + 1
    more = round(GAP / TICK)
    flight = shell.fly(steps[:first] + [(steps[first - 1][0], {})] * more + steps[first:])
    assert all(tick.commands is None for tick in flight.ticks[first : first + more])
    return Flight(shell, flight.safe, flight.ticks[:first] + flight.ticks[first + more :])


def test_begins_anew_after_a_gap_where_it_was(shell: Shell) -> None:
    """The first command is the last one; the next ones are those of an autopilot without history."""
    flight, resumed = after_a_gap(shell), FAULT + GAP
    last, first = flight.commands(FAULT - TICK, FAULT)[0], flight.commands(resumed, resumed + TICK)[0]
    assert np.abs(first - last).max() < 0.5 and np.abs(last - flight.commands()[0]).max() > 5.0
    assert flight.largest_change(resumed + 1.0) < JUMP
    assert not any(flight.shows(bit) for bit in LOST)


@pytest.mark.parametrize("lost", MEASURED)
@pytest.mark.parametrize("fault", [silent, partial(set_to, math.nan)], ids=["silent", "NaN"])
def test_knows_after_a_gap_what_is_lost(shell: Shell, fault: Callable[..., Change], lost: str) -> None:
    """The age of silent signals shows it at once; NaN makes the reset fail."""
    flight = after_a_gap(shell, fault(lost))
    if shell.name == "dune_task" and lost == "pitch" and fault is silent:
        lost = "pitch_rate"  # one message brings both
    shown = {"pitch": LOST_PITCH, "speed": LOST_SPEED, "pitch_rate": FAILED}[lost]
    assert flight.shows(shown, round(FAULT / TICK)) and flight.shows(shown)
    assert flight.is_safe(FAULT + GAP + SAFE_WITHIN) == (lost == "pitch_rate")


def test_a_clock_that_jumps_back_does_no_harm(shell: Shell) -> None:
    """A clock that jumps back does not hide that the sensors fall silent then."""
    steps = calls(20.0, silent(*MEASURED, begin=12.0))
    back = [(time if time < FAULT else time - 50.0, heard) for time, heard in steps]
    flight, silence = shell.fly(back), round(12.0 / TICK)
    commands = np.array([tick.commands for tick in flight.ticks])
    assert np.abs(np.diff(commands[:silence], axis=0)).max() < JUMP
    assert not any(flight.shows(bit, silence - 1) for bit in LOST) and flight.shows(FAILED)
    assert np.abs(commands[silence + round(SAFE_WITHIN / TICK) :] - flight.safe).max() < 1e-4


def piloted(*spans: tuple[float, float]) -> Change:
    """Engage only during these intervals (s); in between a pilot commands increasing thrust."""

    def change(time: float, heard: Heard) -> None:
        heard["engaged"] = float(any(begin <= time < end for begin, end in spans))
        if not heard["engaged"]:
            heard.update(zip(APPLIED, pilot(time), strict=True))

    return change


def pilot(time: float) -> np.ndarray:
    """Return the commands of the pilot (N)."""
    return np.array([6.0, 5.0, 5.0]) + 0.2 * time


def test_commands_nothing_until_it_is_engaged(shell: Shell) -> None:
    silence = silent("engaged", begin=0.0)
    flight = shell.fly(calls(10.0, silence))
    assert all(tick.commands is None for tick in flight.ticks)


def test_says_what_is_lost_while_it_is_not_engaged(shell: Shell) -> None:
    flight = shell.fly(calls(10.0, both(both(piloted(), waving), set_to(0.01, "pitch"))))
    assert all(tick.commands is None for tick in flight.ticks)
    assert flight.shows(LOST_PITCH) and not flight.shows(LOST_PITCH, round(FAULT / TICK))


def test_engages_where_the_pilot_was(shell: Shell) -> None:
    flight = shell.fly(calls(20.0, piloted((5.0, 10.0), (15.0, 20.0))))
    assert all((tick.commands is not None) == (tick.time % 10.0 > 5.0 - 1e-9) for tick in flight.ticks)
    for begin in (5.0, 15.0):
        commands = flight.commands(begin, begin + 5.0)
        assert np.abs(commands[0] - pilot(begin)).max() < 0.5
        assert np.abs(np.diff(commands, axis=0)).max() < JUMP
        assert np.abs(commands[-1] - commands[0]).max() > 2.0


def test_engages_without_what_is_applied(shell: Shell) -> None:
    """The autopilot then starts as after a reset, however long it has waited."""

    def late(time: float, heard: Heard) -> None:
        heard["engaged"] = float(time >= FAULT)

    def at_once(time: float, heard: Heard) -> None:
        silent(*MEASURED, *WANTED, "engaged", begin=0.0, end=FAULT)(time, heard)

    waited, fresh = shell.fly(calls(10.0, late)), shell.fly(calls(10.0, at_once))
    assert all((tick.commands is None) == (tick.time < FAULT - 1e-9) for tick in waited.ticks)
    assert np.array_equal(waited.commands(FAULT), fresh.commands(FAULT))
