"""Time a step of the controller through the C ABI, against pythonfmu and hand-written C with the same law.

Run `python3 run.py fly` first, which builds the command and the binaries. Writes a table to docs/benchmarks.md.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from page import ROOT, full_order, in_environment, put, squid

if TYPE_CHECKING:
    import numpy as np

HERE = ROOT / "benches" / "abi"
SIGNALS = ("pitch", "speed", "pitch_rate")
INPUTS = (*SIGNALS, "pitch_reference", "speed_reference")
MORE = ("heading", "heading_rate", "heading_reference")
"""Inputs of the axis of heading, where there is one."""
COUNT, SLOW_COUNT = 20_000, 2_000
COMPARED = 500
"""Steps before the commands are compared; the loop is open, so that later all of them are at their limits."""
TURNS = 9
AGREEMENT = 1e-9


def law_of(design: dict) -> dict[str, np.ndarray]:
    """Return the matrices of one tick, by the trapezoidal rule, and the tables around them.

    With a = Ts/2 and M = (I - a A)^-1: A_d = M (I + a A), B_d = M B, C_d = Ts C M, D_d = D + a C M B, for the inputs
    [wt, y] and the outputs [zt, u] of the LFT.
    """
    import numpy as np

    lft = {name: np.array(value, dtype=float) for name, value in design["lft"].items() if name != "blocks"}
    ts = design["sample_time"]
    (n, r), p = lft["Bt"].shape, lft["By"].shape[1]
    # A list without rows does not state their width.
    lft |= {"Ct": lft["Ct"].reshape(r, n), "Dtt": lft["Dtt"].reshape(r, r), "Dty": lft["Dty"].reshape(r, p)}
    b, c = np.hstack([lft["Bt"], lft["By"]]), np.vstack([lft["Ct"], lft["Cu"]])
    d = np.block([[lft["Dtt"], lft["Dty"]], [lft["Dut"], lft["Duy"]]])
    m = np.linalg.inv(np.eye(n) - ts / 2 * lft["A"])
    a, cd, d = m @ (np.eye(n) + ts / 2 * lft["A"]), ts * c @ m, d + ts / 2 * c @ m @ b
    b = m @ b
    law = {"A": a, "Bt": b[:, :r], "By": b[:, r:], "Ct": cd[:r], "Cu": cd[r:]}
    law |= {"Dtt": d[:r, :r], "Dty": d[:r, r:], "Dut": d[r:, :r], "Duy": d[r:, r:]}
    law |= {"SPEED": design["trim"]["speed"], "FORWARD": design["trim"]["forward_speed"]}
    law |= {"PITCH": design["trim"]["signals"]["pitch"], "TRIM": np.array(design["trim"]["actuators"]).T}
    law |= parts_of_y(design["controller_inputs"])
    law |= {"FILTER": -np.expm1(-design["reference_filter"] * ts) if "reference_filter" in design else 1.0}
    law |= {"ACTUATOR": [[one["scale"], one["minimum"], one["maximum"]] for one in design["actuators"]]}
    law |= {"CENTRE": design["scheduling"]["centre"], "HALF": design["scheduling"]["half_range"]}
    return {name: np.array(value, dtype=float) for name, value in law.items()}


def parts_of_y(inputs: list[dict]) -> dict[str, list]:
    """Return the coefficients of references, measurements and trim, in the order of SIGNALS, in y, and its scales."""
    parts = {"error": (1.0, -1.0, 0.0), "reference": (1.0, 0.0, -1.0), "measurement": (0.0, 1.0, -1.0)}
    names = ("OF_REFERENCE", "OF_MEASURED", "OF_LEVEL")
    found = {
        name: [[parts[one["kind"]][i] * (one["signal"] == signal) for signal in SIGNALS] for one in inputs]
        for i, name in enumerate(names)
    }
    return found | {"SCALE": [one["scale"] for one in inputs]}


def y_in_c(law: dict[str, np.ndarray]) -> str:
    """Return the macro that writes y as differences, as a programmer would."""
    lines = []
    for row, scale in enumerate(law["SCALE"].tolist()):
        # References of pitch and speed follow the measurements in `in`; the pitch rate has none.
        terms = [f"in[{i}]" for i in range(3) if law["OF_MEASURED"][row, i] > 0]
        terms += [f"in[{i + 3}]" for i in range(3) if law["OF_REFERENCE"][row, i] > 0]
        terms += [f"- in[{i}]" for i in range(3) if law["OF_MEASURED"][row, i] < 0]
        terms += [f"- level[{i}]" for i in range(3) if law["OF_LEVEL"][row, i] < 0]
        lines.append(f"({' '.join(terms)}) / {scale!r}")
    return f"#define Y(in, level) {{{', '.join(lines)}}}"


def constant(name: str, value: np.ndarray) -> str:
    """Return a constant of C."""

    def literal(value: float | list) -> str:
        return "{" + ", ".join(map(literal, value)) + "}" if isinstance(value, list) else repr(value)

    shape = "".join(f"[{size}]" for size in value.shape)
    return f"static const double {name}{shape} = {literal(value.tolist())};"


def header(law: dict[str, np.ndarray]) -> str:
    """Return the law as constants of C."""
    sizes = {"N": law["A"], "R": law["Dtt"], "M": law["Cu"], "ROWS": law["SPEED"], "P": law["SCALE"]}
    lines = [f"enum {{ {', '.join(f'{name} = {len(value)}' for name, value in sizes.items())} }};"]
    lines += [constant(name, value) for name, value in law.items() if not name.startswith("OF_")]
    lines.append(y_in_c(law))
    return "\n".join(lines) + "\n"


class Peer:
    """A binary and the value references of its variables."""

    def __init__(
        self, name: str, library: Path, guid: str, resources: str, variables: dict[str, int], count: int
    ):
        self.name, self.count = name, count
        given = (*INPUTS, *(name for name in MORE if name in variables))
        outputs = [vr for variable, vr in variables.items() if variable not in given]
        inputs = [variables[variable] for variable in given]
        self.tail = [",".join(map(str, inputs)), ",".join(map(str, outputs))]
        self.head = [library, guid, resources]

    def measure(self, driver: Path, step: float, count: int, rounds: int) -> tuple[float, list[float]]:
        """Return nanoseconds per step and the final outputs."""
        words = [driver, *self.head, repr(step), count, rounds, *self.tail]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"{self.name}: {done.stderr}")
        taken, *values = map(float, done.stdout.split("\n")[-2].split())
        return taken, values


def from_fmu(name: str, fmu: Path, folder: Path, outputs: list[str], count: int) -> Peer:
    """Unpack an FMU and return it as a peer."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    references = {v.get("name"): int(v.get("valueReference")) for v in root.iter("ScalarVariable")}
    identifier = root.find("CoSimulation").get("modelIdentifier")
    library = folder / "binaries" / "linux64" / f"{identifier}.so"
    variables = {name: references[name] for name in (*INPUTS, *MORE, *outputs) if name in references}
    return Peer(name, library, root.get("guid"), (folder / "resources").as_uri(), variables, count)


def by_hand(law: dict[str, np.ndarray], actuators: list[str], folder: Path) -> Peer:
    """Compile the C law for its sizes and return it as a peer."""
    (folder / "law.h").write_text(header(law), encoding="utf-8")
    floor = folder / "floor.so"
    words = ["cc", "-O3", "-shared", "-fPIC", f"-I{folder}", "-o", floor, HERE / "floor.c"]
    subprocess.run([str(word) for word in words], check=True)
    variables = {name: index for index, name in enumerate((*INPUTS, *actuators))}
    return Peer("C by hand", floor, "-", "-", variables, COUNT)


def compiled_driver(folder: Path) -> Path:
    """Compile the driver and return its path."""
    driver = folder / "driver"
    subprocess.run(["cc", "-O2", "-o", str(driver), str(HERE / "driver.c"), "-ldl", "-lm"], check=True)
    return driver


def peers(design: dict, fmu: Path, folder: Path) -> list[Peer]:
    """Return the controller, hand-written C, and pythonfmu."""
    law = law_of(design)
    actuators = [one["name"] for one in design["actuators"]]
    (folder / "law.json").write_text(json.dumps({n: v.tolist() for n, v in law.items()}), encoding="utf-8")
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", HERE / "peer.py", "-d", folder]
    subprocess.run([*build, folder / "law.json"], check=True, stdout=subprocess.DEVNULL)
    commands = [f"command{index}" for index in range(len(actuators))]
    return [
        from_fmu("squid's controller", fmu, folder / "controller", actuators, COUNT),
        by_hand(law, actuators, folder),
        from_fmu("pythonfmu, NumPy", folder / "Peer.fmu", folder / "pythonfmu", commands, SLOW_COUNT),
    ]


def check_agreement(peers: Sequence[Peer], driver: Path, step: float) -> float:
    """Return the largest difference from the commands of the first peer; raise an error above `AGREEMENT`."""
    first, *others = (peer.measure(driver, step, COMPARED, 1)[1] for peer in peers)
    scale = max(max(map(abs, first)), 1.0)
    worst = max(abs(a - b) / scale for end in others for a, b in zip(first, end, strict=True))
    if worst > AGREEMENT:
        raise SystemExit(f"the laws differ by {worst:.1e} after {COMPARED} steps")
    return worst


def rows(design: dict, fmu: Path) -> list[str]:
    """Check that all compute the same commands, measure them in turn, and return the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        driver = compiled_driver(folder)
        found = peers(design, fmu, folder)
        # The binary of pythonfmu needs an interpreter in the process, and is not linked with one.
        interpreter = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("INSTSONAME")
        os.environ |= {
            "LD_PRELOAD": str(interpreter),
            "PYTHONHOME": sys.base_prefix,
            "PYTHONPATH": sysconfig.get_path("purelib"),
        }
        step = design["sample_time"]
        worst = check_agreement(found, driver, step)
        turns = [[p.measure(driver, step, p.count, 5)[0] for p in found] for _ in range(TURNS)]
    lines = ["| | ns a step (set + step + get) | over squid |", "|---|---|---|"]
    for index, peer in enumerate(found):
        ratio = statistics.median(turn[index] / turn[0] for turn in turns)
        lines.append(f"| {peer.name} | {statistics.median(t[index] for t in turns):.0f} | {ratio:.3g} |")
    over = statistics.median(turn[0] / turn[1] for turn in turns)
    lines += [
        "",
        f"squid's controller takes {over:.2f} times C by hand. "
        f"The commands after {COMPARED} steps agree to {worst:.0e}.",
    ]
    return lines


def packaged(folder: Path) -> tuple[dict, Path]:
    """Return the design under comparison, and its controller's FMU; the hand-written law has no anti-windup."""
    vehicle, out = full_order(folder, anti_windup=False)
    squid("package", vehicle, "--out", out)
    fmu = out / "squid_controller.fmu"
    with zipfile.ZipFile(fmu) as archive:
        return json.loads(archive.read("resources/controller.json")), fmu


def main() -> int:
    """Measure, and write the table."""
    in_environment(__file__, "abi", HERE / "requirements.txt")
    with tempfile.TemporaryDirectory() as name:
        put("abi", rows(*packaged(Path(name))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
