"""Published optima and those of the command: a table of found and expected values, with times."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
CASES = ROOT / "tests" / "cases"
# Only rounding can be below an infimum, in the answer and in the published digits.
BELOW = 2e-5


def problems() -> list[Path]:
    """Return the cases for `squid lpv synth` with a published optimum."""
    kinds = ("hinfsyn", "lpvsyn-lft")
    cases = {path: json.loads(path.read_text(encoding="utf-8")) for path in sorted(CASES.rglob("*.json"))}
    return [path for path, case in cases.items() if case["kind"] in kinds and "expected" in case]


def expected(case: dict) -> dict[str, float]:
    """Return the expected gammas of a case, by the key of the report."""
    answers = case["expected"]
    names = {
        "gamma": ("gamma", "gamma_opt", "gamma_opt_S_and_T"),
        "gamma_symmetric": ("gamma_opt_S_only",),
    }
    found = {key: answers[name] for key, all_names in names.items() for name in all_names if name in answers}
    if isinstance(answers.get("gamma_S_T"), list):
        found = {"gamma": answers["gamma_S_T"][0], "gamma_symmetric": answers["gamma_S_only"][0]}
    return found


def solve(command: Path, path: Path) -> dict:
    """Run the command on one case and return its report."""
    words = [str(command), "lpv", "synth", str(path), "--json"]
    return json.loads(subprocess.run(words, capture_output=True, text=True, check=False).stdout)


def check(command: Path, path: Path) -> bool:
    """Print the rows of one case; return True if all its gammas agree and its controller is proved."""
    case = json.loads(path.read_text(encoding="utf-8"))
    begin = time.monotonic()
    report = solve(command, path)
    seconds = time.monotonic() - begin
    met = report["status"] == "feasible" and report["certified_gamma"] is not None
    rtol = case["expected"]["rtol"]
    for key, wanted in expected(case).items():
        found = report[key] if report[key] is not None else float("nan")
        off = found / wanted - 1.0
        good = -BELOW <= off <= rtol
        met = met and good
        verdict = "" if good else "  MISSED"
        name = path.stem + (" (S alone)" if key == "gamma_symmetric" else "")
        print(
            f"{name:<42} {found:12.6f} {wanted:12.6f} {off:+9.1e} {rtol:9.0e} "
            f"{report['certified_gamma'] or float('nan'):12.6f} {seconds:7.2f}{verdict}",
            flush=True,
        )
    return met


def bounded(command: Path, path: Path) -> bool:
    """Print the row of a sampled loop; return True if its bounds are within the published ones."""
    case = json.loads(path.read_text(encoding="utf-8"))
    words = [str(command), "lpv", "sampled", str(path), "--json"]
    found = json.loads(subprocess.run(words, capture_output=True, text=True, check=False).stdout)
    published, rounding = case["expected"], case["expected"]["rtol"]
    lower, upper = (float("nan") if found[key] is None else found[key] for key in ("lower", "upper"))
    met = published["lower"] - rounding <= lower <= upper <= published["upper"] + rounding
    print(
        f"{path.stem:<42} {lower:.6f} to {upper:.6f}, published {published['lower']} to {published['upper']}"
        f"{'' if met else '  MISSED'}",
        flush=True,
    )
    return met


def sampled() -> list[Path]:
    """Return the cases for `squid lpv sampled`."""
    return sorted(CASES.glob("sd*.json"))


def main(command: Path) -> int:
    """Print the table, and return 0 if every case passes."""
    print(
        f"{'case':<42} {'found':>12} {'expected':>12} {'relative':>9} {'tolerance':>9} {'proved':>12} {'s':>7}"
    )
    results = [check(command, path) for path in problems()]
    print(f"{sum(results)} of {len(results)} cases met, each with a controller whose bound is proved")
    results += [bounded(command, path) for path in sampled()]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
