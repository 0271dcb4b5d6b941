"""Time a step of controllers of many sizes through the C ABI, against hand-written C with the same law, and plot it.

The controllers are random, with n states and r channels; everything else is that of the packaged controller. Run
`python3 run.py fly` first, which builds the command and the binaries. Writes docs/step.svg and docs/benchmarks.md.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from copy import copy
from pathlib import Path

from abi_peers import (
    HERE,
    Peer,
    by_hand,
    check_agreement,
    compiled_driver,
    from_fmu,
    law_of,
    packaged,
)
from page import ROOT, in_environment, put

STATES = (4, 8, 12, 16, 20, 24)
CHANNELS = (0, 2, 4, 6, 8, 10)
COUNT, ROUNDS, TURNS = 5_000, 5, 5

Times = dict[tuple[int, int], tuple[float, float]]
"""Nanoseconds a step of squid's controller and of C by hand, by n and r."""


def random_design(design: dict, n: int, r: int) -> dict:
    """Return a design with a random LFT: stable, and well posed for all |rho| <= 1 since |Dtt| = 1/2."""
    import numpy as np

    random = np.random.default_rng([n, r])
    m, p = len(design["actuators"]), len(design["controller_inputs"])
    shapes = {"A": (n, n), "By": (n, p), "Bt": (n, r), "Cu": (m, n), "Duy": (m, p), "Dut": (m, r)}
    shapes |= {"Ct": (r, n), "Dty": (r, p), "Dtt": (r, r)}
    lft = {name: random.uniform(-0.5, 0.5, shape) for name, shape in shapes.items()}
    lft["A"] -= np.eye(n) * (0.5 + np.linalg.norm(lft["A"], 2))
    if r > 0:
        lft["Dtt"] *= 0.5 / np.linalg.norm(lft["Dtt"], 2)
    # A controller that never follows applied commands needs no gain for it.
    design = {key: value for key, value in design.items() if key != "follow"}
    return {**design, "lft": {"blocks": [r] if r > 0 else []} | {key: m.tolist() for key, m in lft.items()}}


def of_squid(packaged: Peer, design: dict, driver: Path, folder: Path) -> Peer:
    """Return the packaged binary with another design in its resources."""
    resources = folder / "resources"
    resources.mkdir(exist_ok=True)
    (resources / "controller.json").write_text(json.dumps(design), encoding="utf-8")
    peer = copy(packaged)
    peer.head = [packaged.head[0], "unknown", resources.as_uri()]
    # The GUID is a hash of the resources; the binary states it when it refuses another one.
    words = [driver, *peer.head, "0.02", 1, 1, *peer.tail]
    refused = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    guid = re.search(r"belong to '(\{.*?\})'", refused.stderr)
    if guid is None:
        raise SystemExit(f"the controller with a drawn design: {refused.stderr}")
    peer.head[1] = guid[1]
    return peer


def times_of(pair: tuple[Peer, Peer], driver: Path, step: float) -> tuple[float, float]:
    """Check that both compute the same commands, and return the least nanoseconds per step of each.

    The processor's clock changes between turns, and a cell is compared with its neighbours.
    """
    check_agreement(pair, driver, step)
    turns = [[peer.measure(driver, step, COUNT, ROUNDS)[0] for peer in pair] for _ in range(TURNS)]
    mine, floor = (min(column) for column in zip(*turns, strict=True))
    return mine, floor


def measured(design: dict, fmu: Path) -> Times:
    """Measure every size."""
    actuators = [one["name"] for one in design["actuators"]]
    times = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        driver = compiled_driver(folder)
        squid = from_fmu("squid's controller", fmu, folder / "controller", actuators, COUNT)
        for n, r in ((n, r) for n in STATES for r in CHANNELS):
            of_size = random_design(design, n, r)
            pair = (of_squid(squid, of_size, driver, folder), by_hand(law_of(of_size), actuators, folder))
            times[n, r] = times_of(pair, driver, design["sample_time"])
    return times


def draw(times: Times, path: Path) -> None:
    """Draw the times over n and over r."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "step"
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 4), sharey=True)
    for color, r, n in zip(("tab:blue", "tab:orange", "tab:green"), (0, 4, 10), (4, 12, 24), strict=True):
        for which, (style, law) in enumerate((("o-", ""), ("s:", "C, "))):
            of_n, of_r = ([times[i, r][which] for i in STATES], [times[n, i][which] for i in CHANNELS])
            left.plot(STATES, of_n, style, color=color, label=f"{law}r = {r}")
            right.plot(CHANNELS, of_r, style, color=color, label=f"{law}n = {n}")
    left.set_xticks(STATES)
    left.set_xlabel("states n")
    left.set_ylabel("set + step + get, ns")
    # Space for the legends above the lines.
    left.set_ylim(0, 1.35 * max(map(max, times.values())))
    right.set_xticks(CHANNELS)
    right.set_xlabel("channels r")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small", ncols=3, loc="upper left")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def table(times: Times) -> list[str]:
    """Return the table, a row for each n."""
    lines = ["| n | " + " | ".join(f"r = {r}" for r in CHANNELS) + " |", "|---" * (len(CHANNELS) + 1) + "|"]
    for n in STATES:
        cells = (f"{times[n, r][0]:.0f} / {times[n, r][1]:.0f}" for r in CHANNELS)
        lines.append(f"| {n} | " + " | ".join(cells) + " |")
    ratios = [mine / floor for mine, floor in times.values()]
    return [*lines, "", f"squid's controller takes {min(ratios):.2f} to {max(ratios):.2f} times C by hand."]


def main() -> int:
    """Measure, draw, and write the table."""
    in_environment(__file__, "abi", HERE / "requirements.txt")
    with tempfile.TemporaryDirectory() as name:
        times = measured(*packaged(Path(name)))
    draw(times, ROOT / "docs" / "step.svg")
    put("abi growth", table(times))
    return 0


if __name__ == "__main__":
    sys.exit(main())
