"""Published optima, found by the command line: a table of found against expected, with times."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
CASES = ROOT / "tests" / "cases"
# Below an infimum there is nothing but rounding, in the answer and in the digits that were published.
BELOW = 2e-5


def problems() -> list[Path]:
    """Return the cases that `squid lpv synth` reads."""
    kinds = ("hinfsyn", "lpvsyn-lft")
    paths = sorted(CASES.rglob("*.json"))
    return [path for path in paths if json.loads(path.read_text(encoding="utf-8"))["kind"] in kinds]


def expected(case: dict) -> dict[str, float]:
    """Return the gammas that a case expects, by the key of the report that must meet them."""
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
    """Print the rows of one case, and say whether all its gammas are met and its controller is proved."""
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


def main(command: Path) -> int:
    """Print the table, and return 0 if every case is met."""
    print(
        f"{'case':<42} {'found':>12} {'expected':>12} {'relative':>9} {'tolerance':>9} {'proved':>12} {'s':>7}"
    )
    results = [check(command, path) for path in problems()]
    print(f"{sum(results)} of {len(results)} cases met, each with a controller whose bound is proved")
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
