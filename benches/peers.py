"""Compare `lpv` with its peers in alternating runs, and write the tables and the plot of docs/benchmarks.md.

The first call creates a virtual environment in build/bench-venv, in which the script starts again.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from multiprocessing.connection import Connection
from pathlib import Path

from page import ROOT, in_environment, put

COMMAND = ROOT / "target" / "release" / "squid"
EXAMPLES = ROOT / "target" / "release" / "examples"
SQUID = ROOT / "tests" / "certificates" / "squid_surrogate.json"
CONSTANT = ROOT / "tests" / "certificates" / "constant_squid.json"
REMUS = ROOT / "tests" / "certificates" / "remus100_bounded_rate.json"
RATES = (0.125, 0.3125, 1.25)  # In units of theta per second.
PLAIN = (
    "hs01_brl_oscillator",
    "hs02_gamma_sqrt065",
    "hs04_active_suspension",
    *(f"compleib/compleib_{name}" for name in ("AC15", "HE4", "NN2", "REA1", "TG1")),
)
METHODS = ("hinfsyn", "HinfSynSlicot", "HinfSynLmi")
SIZES = ((4, 4), (8, 5), (12, 6), (16, 7), (20, 8), (24, 10))
PARTS = ("squid", "rate", "constant", "plain", "growth", "mu")
ROUNDS = 3
PAIRS = 15
ACCURACY = 1e-3  # Relative error within which a peer's gamma may be below the norm of its loop.
PATIENCE = 10.0  # Seconds after which a peer is considered to hang.


def ours(path: Path, *rate: str) -> dict:
    """Run `synthesise` on one plant; its time excludes the start of the process."""
    done = subprocess.run([EXAMPLES / "timed", path, *rate], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def answer(method: str, path: Path, to: Connection) -> None:
    """Send the result of a synthesis."""
    from hinf_peers import read, run

    to.send(run(method, read(path)[0]))


def in_python(method: str, path: Path) -> dict:
    """Run a synthesis, which may hang, in its own process, forked after the libraries are loaded."""
    import hinf_peers  # noqa: F401

    context = multiprocessing.get_context("fork")
    receive, send = context.Pipe(duplex=False)
    child = context.Process(target=answer, args=(method, path, send))
    child.start()
    send.close()
    try:
        return receive.recv() if receive.poll(PATIENCE) else {"failure": f"no answer in {PATIENCE:.0f} s"}
    except EOFError:
        return {"failure": "the process died"}
    finally:
        child.kill()
        child.join()


def with_wheel() -> None:
    """Build the wheel and install it with the peers."""
    subprocess.run([sys.executable, ROOT / "run.py", "wheels", "--platforms", "host"], check=True)
    wheel = next((ROOT / "build" / "wheels" / "host").glob("*.whl"))
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--force-reinstall"]
    subprocess.run([*pip, wheel], check=True)


def squid_rows() -> list[str]:
    """Return the table of Squid's inequalities."""
    import numpy as np
    from lpv_cvxpy import Plant, least_gamma, synthesise

    file = json.loads(SQUID.read_text(encoding="utf-8"))
    plant = Plant({key: np.array(value) for key, value in file["plant"].items()}, file["blocks"])
    parts: dict[str, list[tuple[float, float]]] = {"least gamma alone": [], "whole call": []}
    for _ in range(ROUNDS):
        mine = ours(SQUID)
        begin = time.perf_counter()
        least = least_gamma(plant)
        parts["least gamma alone"].append((mine["seconds_least_gamma"], time.perf_counter() - begin))
        begin = time.perf_counter()
        clearance = synthesise(plant)[1]
        parts["whole call"].append((mine["seconds"], time.perf_counter() - begin))
    rows = ["| Squid | lpv, s | cvxpy + Clarabel, s | cvxpy / lpv |", "|---|---|---|---|"]
    for name, pairs in parts.items():
        a, b = (statistics.median(column) for column in zip(*pairs, strict=True))
        ratio = statistics.median(b / a for a, b in pairs)
        rows.append(f"| {name} | {a:.3f} | {b:.3f} | {ratio:.2f} |")
    rows.append("")
    proved = f"proved by lpv: {mine['certified_gamma']:.6f}"
    rows.append(f"Least gamma: lpv {mine['gamma']:.6f}, cvxpy {least:.6f}; {proved}. ")
    rows.append(f"Clearance of the closed loop's inequality in cvxpy: {clearance:.1e}.")
    return rows


def child_time() -> float:
    """Return the CPU time (s) of the finished child processes."""
    times = os.times()
    return times.children_user + times.children_system


def rate_rows() -> list[str]:
    """Return the table of the inequalities for a bounded rate, in CPU time."""
    import numpy as np
    from lpv_cvxpy import Plant
    from rate_cvxpy import least_gamma

    rows = [
        "| plant | rate | lpv, s | cvxpy + Clarabel, s | cvxpy / lpv | least gamma, lpv | cvxpy |",
        "|---|---|---|---|---|---|---|",
    ]
    for path in (SQUID, REMUS):
        file = json.loads(path.read_text(encoding="utf-8"))
        plant = Plant({key: np.array(value) for key, value in file["plant"].items()}, file["blocks"])
        for rate in RATES:
            pairs = []
            for _ in range(ROUNDS):
                before = time.process_time(), child_time()
                mine = ours(path, str(rate))
                least = least_gamma(plant, rate)
                pairs.append((child_time() - before[1], time.process_time() - before[0]))
            a, b = (statistics.median(column) for column in zip(*pairs, strict=True))
            ratio = statistics.median(b / a for a, b in pairs)
            gammas = f"{mine['gamma']:.4f}", f"{least:.4f}"
            cells = [path.stem, f"{rate}", f"{a:.2f}", f"{b:.2f}", f"{ratio:.1f}", *gammas]
            rows.append("| " + " | ".join(cells) + " |")
    return rows


def constant_rows() -> list[str]:
    """Return the table of the inequality for constant parameters, in CPU time; once, because it takes minutes."""
    from constant_cvxpy import Filtered, least_gamma

    certificate = json.loads(CONSTANT.read_text(encoding="utf-8"))
    before = child_time()
    mine = ours(CONSTANT)
    a, begin = child_time() - before, time.process_time()
    least = least_gamma(Filtered.of(certificate))
    b = time.process_time() - begin
    return [
        "| plant | lpv, s | cvxpy + Clarabel, s | cvxpy / lpv | bound, lpv | least gamma, cvxpy |",
        "|---|---|---|---|---|---|",
        f"| {CONSTANT.stem} | {a:.0f} | {b:.0f} | {b / a:.0f} | {mine['gamma']:.4f} | {least:.4f} |",
    ]




def plain_row(name: str) -> str:
    """Return the row of one plain H-infinity plant; a gamma that the norm of its loop exceeds is set in bold."""
    path = ROOT / "tests" / "cases" / f"{name}.json"
    published = json.loads(path.read_text(encoding="utf-8"))["expected"]["gamma"]
    ratios: dict[str, list[float]] = {method: [] for method in METHODS}
    last: dict[str, dict] = {}
    for _ in range(ROUNDS):
        mine = in_python("squid", path)
        for method in METHODS:
            if "failure" in last.get(method, {}):
                continue  # Once is enough.
            last[method] = in_python(method, path)
            if "failure" not in last[method]:
                ratios[method].append(last[method]["seconds"] / mine["seconds"])
    if mine["norm"] > mine["gamma"]:
        raise SystemExit(f"{name}: {mine}")
    said = f"{mine['least']:.6g}; {mine['gamma']:.6g}; {mine['norm']:.6g}; {1e3 * mine['seconds']:.0f} ms"
    cells = [path.stem, f"{published:.6g}", said]
    for method in METHODS:
        found = last[method]
        if "failure" in found:
            cells.append(found["failure"])
            continue
        gammas = f"{found['gamma']:.6g}; {found['norm']:.6g}"
        wrong = found["norm"] > found["gamma"] * (1.0 + ACCURACY)
        cells.append((f"**{gammas}**" if wrong else gammas) + f"; {statistics.median(ratios[method]):.2f} x")
    return "| " + " | ".join(cells) + " |"


def wheel_row(name: str) -> str:
    """Return the row of one plant, synthesised with the wheel and with the command in turn."""
    from hinf_peers import read, run

    path = ROOT / "tests" / "cases" / f"{name}.json"
    plant, _ = read(path)
    run("squid", plant)  # The first call starts the threads.
    pairs = []
    for _ in range(PAIRS):
        mine = run("squid", plant)["seconds"]
        begin = time.perf_counter()
        subprocess.run([COMMAND, "lpv", "synth", path], stdout=subprocess.DEVNULL, check=True)
        pairs.append((mine, time.perf_counter() - begin))
    a, b = (statistics.median(column) for column in zip(*pairs, strict=True))
    ratio = statistics.median(a / b for a, b in pairs)
    return f"| {path.stem} | {1e3 * a:.0f} | {1e3 * b:.0f} | {ratio:.2f} |"


def growth_rows() -> list[str]:
    """Return the table of growth, and draw it."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "growth"
    from matplotlib import pyplot

    rows = ["| n | r | seconds | peak memory, MB | least gamma | proved |", "|---|---|---|---|---|---|"]
    found = []
    for n, r in SIZES:
        words = [EXAMPLES / "growth", str(n), str(r)]
        cells = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
        rows.append("| " + " | ".join(cells) + " |")
        found.append([float(cell) for cell in cells])
    figure, left = pyplot.subplots(figsize=(7, 4))
    right = left.twinx()
    left.semilogy([row[0] for row in found], [row[2] for row in found], "o-", color="tab:blue")
    right.semilogy([row[0] for row in found], [row[3] for row in found], "s--", color="tab:orange")
    left.set_xticks([n for n, _ in SIZES], [f"{n}\nr = {r}" for n, r in SIZES])
    left.set_xlabel("states n")
    left.set_ylabel("time of synthesis, s", color="tab:blue")
    right.set_ylabel("peak memory, MB", color="tab:orange")
    left.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(ROOT / "docs" / "growth.svg", metadata={"Date": None})
    return rows


def main() -> int:
    """Measure the parts named on the command line, or all."""
    in_environment(__file__, "bench", ROOT / "benches" / "requirements.txt")
    words = ["cargo", "build", "--release", "--workspace", "--examples"]
    subprocess.run(words, cwd=ROOT, check=True)
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")] or [*PARTS]
    if "plain" in wanted:  # First, because it forks, which the threads of the others prevent.
        with_wheel()
        head = "| plant | published | squid-lpv | " + " | ".join(METHODS) + " |"
        put("plain", [head, "|---" * 6 + "|", *(plain_row(name) for name in PLAIN)])
        subprocess.run(["cargo", "build", "--release", "--workspace", "--bin", "squid"], cwd=ROOT, check=True)
        head = "| plant | call in Python, ms | command, ms | ratio |"
        put("wheel", [head, "|---" * 4 + "|", *(wheel_row(name) for name in PLAIN)])
    if "growth" in wanted:
        put("growth", growth_rows())
    if "mu" in wanted:
        import mu_peers

        put("mu", mu_peers.rows(EXAMPLES / "mu_timed", ROOT / "tests" / "cases"))
        words = ["cargo", "run", "--release", "-q", "-p", "squid", "--example", "mu_problems", "--"]
        squid = ROOT / "vehicles" / "squid"
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [*words, squid, squid / "frozen", folder], cwd=ROOT, capture_output=True, text=True, check=True
            )
            problems = [Path(line) for line in done.stdout.splitlines()]
            put("mu sweeps", mu_peers.sweep_rows(EXAMPLES / "mu_timed", problems))
    if "squid" in wanted:
        put("squid", squid_rows())
    if "rate" in wanted:
        put("rate", rate_rows())
    sys.path.append(str(ROOT / "tests" / "python" / "support"))
    if "constant" in wanted:
        put("constant", constant_rows())
    return 0


if __name__ == "__main__":
    sys.exit(main())
