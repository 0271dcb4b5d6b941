"""Time a tick of the C source of `squid export`, against hand-written C with the same law, in one run.

Run `python3 run.py fly` first, which builds the command. Writes a table to docs/benchmarks.md.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from abi_peers import constant
from abi_peers import law_of as matrices_of
from page import ROOT, full_order, in_environment, put, squid

HERE = ROOT / "benches" / "embedded"
COUNT, ROUNDS = 20_000, 101
AGREEMENT = 1e-9
"""Of the range of an actuator."""


def law_of(design: dict) -> str:
    """Return the law as constants of C, in the coordinates of the Schur form of Dtt."""
    import numpy as np
    from scipy.linalg import schur

    law = matrices_of(design)
    t, q = schur(law["Dtt"])
    ts, n = design["sample_time"], len(law["A"])
    m = np.linalg.inv(np.eye(n) - ts / 2 * np.array(design["lft"]["A"]))
    tables = {
        "T": t,
        "INTO": np.hstack([q.T @ law["Ct"], q.T @ law["Dty"]]),
        "OUT": np.hstack([law["Cu"], law["Duy"], law["Dut"] @ q]),
        "UP": np.hstack([law["A"], law["By"], law["Bt"] @ q]),
        # The state of this law is that of the design divided by Ts.
        "E": m @ np.array(design["anti_windup"]),
        "TRIM": law["TRIM"].T,
        **{name: law[name] for name in ("SPEED", "FORWARD", "PITCH", "ACTUATOR", "FILTER", "CENTRE", "HALF")},
    }
    sizes = {"N": n, "R": len(t), "M": len(law["Cu"]), "P": len(law["SCALE"]), "ROWS": len(law["SPEED"])}
    lines = [f"enum {{ {', '.join(f'{name} = {size}' for name, size in sizes.items())} }};"]
    lines += [constant(name, value) for name, value in tables.items()]
    return "\n".join([*lines, y_of(design["controller_inputs"]), commands_of(design["actuators"])]) + "\n"


def y_of(inputs: list[dict]) -> str:
    """Return the macro that computes y."""
    level = {"pitch": "(level_pitch)", "speed": "(level_speed)"}
    lines = []
    for index, one in enumerate(inputs):
        name = one["signal"] + ("_reference" if one["kind"] == "reference" else "")
        below = f" - {level[one['signal']]}" if one["signal"] in level else ""
        lines.append(f"(y)[{index}] = ((in)->{name}{below}) / {one['scale']!r};")
    return f"#define Y(y, in, level_pitch, level_speed) do {{ {' '.join(lines)} }} while (0)"


def commands_of(actuators: list[dict]) -> str:
    """Return the macro that lists the commands."""
    return f"#define COMMANDS(out) {{{', '.join('(out).' + one['name'] for one in actuators)}}}"


def rows(folder: Path) -> list[str]:
    """Check that both compute the same commands, measure them in turn, and return the table."""
    from fly import platforms

    vehicle, design_folder = full_order(folder, anti_windup=True)
    squid("export", vehicle, "--out", design_folder, "--to", folder)
    design = json.loads((folder / "controller.json").read_text(encoding="utf-8"))
    (folder / "law.h").write_text(law_of(design), encoding="utf-8")
    lines = ["| compiler | C by hand, ns a tick | squid export, ns a tick | ratio |", "|---|---|---|---|"]
    clang = [platforms.tools().python, "-m", "ziglang", "cc", "-fno-sanitize=all"]
    compilers = {"gcc -O2": ["gcc", "-O2"], "gcc -O3": ["gcc", "-O3"], "clang -O2": [*clang, "-O2"]}
    for name, compiler in compilers.items():
        program = folder / "by_hand"
        files = [HERE / "by_hand.c", folder / "squid.c"]
        flags = ["-std=c99", "-ffp-contract=off", "-Wno-unknown-pragmas", f"-I{folder}", "-o", program]
        subprocess.run([*map(str, [*compiler, *flags, *files, "-lm"])], check=True)
        said = subprocess.run([program, str(COUNT), str(ROUNDS)], check=True, capture_output=True, text=True).stdout
        hand, source, ratio, difference = map(float, said.split())
        if difference > AGREEMENT * max(one["maximum"] for one in design["actuators"]):
            raise SystemExit(f"the laws differ by {difference:.1e}")
        lines.append(f"| {name} | {hand:.0f} | {source:.0f} | {ratio:.2f} |")
    return lines


def main() -> int:
    """Measure, and write the table."""
    in_environment(__file__)
    with tempfile.TemporaryDirectory() as name:
        put("embedded", rows(Path(name)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
