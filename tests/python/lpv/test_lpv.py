"""`squid lpv`: synthesis for general plants in a file, its three outcomes, and wrong files."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import Run, kinds, masked, messages, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

CASE = ROOT / "tests" / "cases" / "lpv05_one_param_lossless.json"


@pytest.fixture
def case() -> dict:
    """Return a problem that may be modified."""
    return copy.deepcopy(json.loads(CASE.read_text(encoding="utf-8")))


def synth(run_squid: Run, path: Path, value: dict | str, *options: str) -> tuple[int, dict, str]:
    """Run `squid lpv synth --json` on a problem; return exit code, report and standard error."""
    path.write_text(value if isinstance(value, str) else json.dumps(value), encoding="utf-8")
    done = run_squid("lpv", "synth", path, "--json", *options)
    report = json.loads(done.stdout) if done.stdout else {}
    return done.returncode, report, done.stderr


def test_files_and_check(run_squid: Run, tmp_path: Path) -> None:
    """Controller and certificate are written, and the certificate is accepted."""
    done = run_squid("lpv", "synth", CASE, "--out", tmp_path)
    assert done.returncode == 0 and "PROVED" in done.stdout
    assert {path.name for path in tmp_path.glob("[!.]*")} == {
        "report.json",
        "controller.json",
        "certificate.json",
    }
    assert run_squid("lpv", "check", CASE, tmp_path / "certificate.json").returncode == 0
    assert run_squid("verify", tmp_path / "certificate.json").returncode == 0


def test_check_answers_with_one_object(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Proved, not proved and a wrong file are distinguished, with gamma or a reason."""
    done = run_squid("lpv", "synth", CASE, "--json", "--out", tmp_path)
    gamma = json.loads(done.stdout)["certified_gamma"]
    path, reasons = tmp_path / "certificate.json", []

    def check(problem: Path) -> tuple[int, str, str]:
        done = run_squid("lpv", "check", problem, path, "--json")
        verdict = json.loads(done.stdout)
        reasons.append(named(verdict["reason"], TMP=tmp_path))
        return done.returncode, verdict["status"], verdict["key"]

    done = run_squid("lpv", "check", CASE, path, "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout) == {
        "status": "proved",
        "gamma": gamma,
        "reason": None,
        "warnings": [],
    }
    assert check(CASE.with_name("lpv01_lpvtools_lft_tutorial.json")) == (1, "not_proved", "wrong_plant")
    assert check(tmp_path / "none.json") == (1, "error", "not_found")
    certificate = json.loads(path.read_text(encoding="utf-8"))
    both = {key: [*certificate[key], 0] for key in ("blocks", "controller_blocks")}
    path.write_text(json.dumps(certificate | both), encoding="utf-8")
    assert check(CASE) == (1, "error", "certificate")
    assert reasons == snapshot
    claim(certificate, "gain")["gamma"] = 0.9 * gamma
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert check(CASE) == (1, "not_proved", "unproved") and "pivot" in reasons[-1]


def test_back_off_is_told(run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion) -> None:
    """The report states the gamma at which the controller was built, and its distance from the least."""
    _, report, _ = synth(run_squid, tmp_path / "p.json", case, "--back-off", "0.25")
    assert report["back_off"] == pytest.approx(0.25, abs=1e-6) and report["findings"] == []
    assert report["gamma_design"] == pytest.approx(1.25 * report["gamma"], rel=1e-6)
    assert masked(run_squid("lpv", "synth", CASE, "--back-off", "0.25").stdout) == snapshot


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["lpv", "synth"], "usage"),
        (["lpv", "synth", CASE, "--back-off", "-1"], "argument"),
        (["lpv", "synth", CASE, "--gamma-limit", "-1"], "argument"),
        (["lpv", "synth", CASE, "--back-off", "x"], "usage"),
        (["lpv", "check", CASE], "usage"),
        (["show", "vehicles/squid", "--speed", "nan"], "argument"),
        (["fly"], "usage"),
    ],
)
def test_wrong_usage_is_not_infeasible(
    run_squid: Run, words: list, key: str, snapshot: SnapshotAssertion
) -> None:
    """A wrong command line ends with 64, because 2 is the code of a proof that there is no controller."""
    done = run_squid(*words)
    assert done.returncode == 64 and not done.stdout
    assert messages(done) == snapshot
    assert json.loads(run_squid(*words, "--json").stdout)["key"] == key


def test_help_is_no_wrong_usage(run_squid: Run) -> None:
    """Requested help goes to standard output, and explains the exit codes; no words at all are wrong usage."""
    done = run_squid("lpv", "synth", "--help")
    assert done.returncode == 0 and " 64: " in done.stdout
    done = run_squid()
    assert done.returncode == 64 and "Usage" in done.stderr and not done.stdout


def refused(code: int, report: dict, error: str) -> tuple[int | None, str]:
    """Check that a file was refused with one sentence, the same in the object; return line and key of the mistake."""
    assert (code, report["status"], report["key"]) == (1, "error", "problem")
    assert len(error.strip().splitlines()) == 1 and report["file"].endswith(".json")
    assert report["reason"] == error.removeprefix("squid: ").strip()
    (mistake,) = report["mistakes"]
    return mistake["line"], mistake["key"]


def test_units_do_not_change_the_answer(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """Other units of states, time or channels give the same gamma."""
    plain = synth(run_squid, tmp_path / "plain.json", case)[1]
    p = case["data"]["P"]
    states, speed, channel = [1e3, 1e-2, 5.0], 40.0, [1e2, 1e-3]
    p["A"] = [[v * speed * states[i] / states[j] for j, v in enumerate(row)] for i, row in enumerate(p["A"])]
    for key in ("B1", "B2", "Bt"):
        p[key] = [[v * speed * states[i] for v in row] for i, row in enumerate(p[key])]
    for key in ("C1", "C2", "Ct"):
        p[key] = [[v / states[j] for j, v in enumerate(row)] for row in p[key]]
    p["Bt"] = [[v * channel[j] for j, v in enumerate(row)] for row in p["Bt"]]
    p["Ct"] = [[v / channel[i] for v in row] for i, row in enumerate(p["Ct"])]
    scaled = synth(run_squid, tmp_path / "scaled.json", case)[1]
    assert scaled["status"] == "feasible"
    assert scaled["gamma"] == pytest.approx(plain["gamma"], rel=1e-5)
    assert scaled["gamma_symmetric"] == pytest.approx(plain["gamma_symmetric"], rel=1e-5)


def test_mode_that_cannot_be_stabilised(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """An unstable mode that is not controllable is named."""
    case["data"]["P"]["A"][2] = [0.0, 0.0, 0.5]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.5000" in report["reason"] and masked(report["reason"]) == snapshot
    assert report["gamma"] is None and report["certified_gamma"] is None


def test_mode_that_cannot_be_seen(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """An unstable mode that is not observable is named."""
    p = case["data"]["P"]
    p["A"][2] = [0.0, 0.0, 0.25]
    p["B2"][2] = [1.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.2500" in report["reason"] and masked(report["reason"]) == snapshot


def test_parameter_that_no_controller_tames(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """An unstable part driven by the parameter only is out of reach of any controller: provably infeasible."""
    p = case["data"]["P"]
    # The third state gets the pole -0.5 + theta, out of reach of the control.
    p["Bt"][2] = [1.0, 0.0]
    p["Ct"][0] = [0.0, 0.0, 1.0]
    p["Bt"][0] = p["Bt"][1] = [0.0, 0.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible"), report
    assert masked(report["reason"]) == snapshot


def test_gamma_above_the_limit(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """The report states how far, and on which path, the limit is missed."""
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--gamma-limit", "1.5")
    assert (code, report["status"]) == (2, "infeasible")
    assert "1.5000" in report["reason"] and masked(report["reason"]) == snapshot
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5)


def test_controllers_that_are_too_fast(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """A limit that no computed controller meets is neither a proof of infeasibility nor a numerical failure."""
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--fastest-mode", "0.001")
    assert (code, report["status"]) == (4, "too_fast")
    assert masked(report["reason"]) == snapshot
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5) and report["certified_gamma"] is None
    assert report["findings"] == []


def test_limit_on_the_fastest_mode_holds_after_reduction(run_squid: Run, tmp_path: Path) -> None:
    """If none meets the limit there is no controller; a controller that meets it also does after reduction."""
    problem = ROOT / "tests" / "cases" / "compleib" / "compleib_AC15.json"
    text = problem.read_text(encoding="utf-8")
    code, report, _ = synth(
        run_squid, tmp_path / "p.json", text, "--fastest-mode", "3", "--out", str(tmp_path)
    )
    assert (code, report["status"]) == (4, "too_fast")
    assert not (tmp_path / "controller.json").exists()
    limit = ["--fastest-mode", "6", "--out", str(tmp_path)]
    for more in ([], ["--reduce"]):
        code, report, _ = synth(run_squid, tmp_path / "p.json", text, *limit, *more)
        assert (code, report["status"]) == (0, "feasible")
        a = np.array(json.loads((tmp_path / "controller.json").read_text(encoding="utf-8"))["A"])
        assert report["controller_states"] == len(a) <= 4
        assert np.max(np.abs(np.linalg.eigvals(a))) <= 6.0


def zeros(rows: list[list[float]]) -> list[list[float]]:
    """Return a zero matrix of the same shape."""
    return [[0.0] * len(row) for row in rows]


def test_finds_what_has_no_price(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """A control without weight and a measurement without noise are reported, whatever the outcome."""
    p = case["data"]["P"]
    p["D12"], p["D21"] = zeros(p["D12"]), zeros(p["D21"])
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (0, "feasible")
    assert report["findings"] == snapshot
    shown = run_squid("lpv", "synth", tmp_path / "p.json").stdout
    assert all(f"  note: {found['why']}\n" in shown for found in report["findings"])


ASKED_BACK_OFF = 0.1
PROOF_ROUNDING = 1e-3


@pytest.mark.parametrize(
    "path", sorted((CASE.parent / "singular").glob("*.json")), ids=lambda path: path.stem
)
def test_singular_problem(run_squid: Run, tmp_path: Path, path: Path) -> None:
    """A controller near the least gamma for unweighted controls, with the regularisation of its design."""
    case = json.loads(path.read_text(encoding="utf-8"))
    expected, plant = case["expected"], case["data"].get("P", case["data"])
    done = run_squid("lpv", "synth", path, "--json", "--out", tmp_path)
    report = json.loads(done.stdout)
    assert (done.returncode, report["status"]) == (0, "feasible")
    assert report["gamma"] == pytest.approx(expected["gamma"], rel=expected["rtol"])
    assert report["gamma_lower"] is None or report["gamma_lower"] <= report["gamma"]
    most = 1 + ASKED_BACK_OFF + PROOF_ROUNDING
    assert report["gamma"] <= report["certified_gamma"] <= most * report["gamma"]
    for why in (found["why"] for found in report["findings"] if found["kind"] == "regularised"):
        assert "u1 (weight)" in why and ("y1 (noise)" in why or np.any(plant["D21"][0]))
    assert run_squid("lpv", "check", path, tmp_path / "certificate.json").returncode == 0


def test_singular_problem_without_a_least_gamma(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Without weights the gain of this plant can be made arbitrarily small, which is reported."""
    problem = json.loads((CASE.parent / "compleib" / "compleib_DIS1.json").read_text(encoding="utf-8"))
    problem["data"]["D12"] = zeros(problem["data"]["D12"])
    code, report, _ = synth(run_squid, tmp_path / "p.json", problem)
    assert (code, report["status"]) == (0, "feasible")
    assert report["gamma"] < 1e-6 * report["certified_gamma"] < 1e-6 and report["back_off"] is None
    assert "regularised" in kinds(report) and kinds(report)[-1] == "gamma_is_zero"
    assert report["findings"][-1]["why"] == snapshot


def test_what_was_added_is_told_to_people(run_squid: Run, snapshot: SnapshotAssertion) -> None:
    """The text names what was added besides the proof."""
    done = run_squid("lpv", "synth", CASE.parent / "singular" / "five_states_one_control.json")
    assert done.returncode == 0 and masked(done.stdout) == snapshot


def test_findings_accompany_any_outcome(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """The text has the findings on the problem with any outcome."""
    p = case["data"]["P"]
    p["D12"] = zeros(p["D12"])
    path = tmp_path / "p.json"
    for code, options in ((4, ["--fastest-mode", "0.001"]), (0, [])):
        found, report, _ = synth(run_squid, path, case, *options)
        shown = run_squid("lpv", "synth", path, *options)
        assert (found, shown.returncode) == (code, code)
        first = report["findings"][0]
        assert first["kind"] == "unweighted_control" and f"  note: {first['why']}\n" in shown.stdout


@pytest.mark.parametrize(
    ("spoil", "line", "key"),
    [
        (lambda c: c["data"]["P"].update(E=[[1, 0, 0], [0, 1, 0], [0, 0, 0]]), None, "E"),
        (lambda c: c["data"]["P"]["D12"][1].__setitem__(0, None), 1, "data.P.D12[1][0]"),
        (lambda c: c["data"]["P"]["D12"][1].__setitem__(0, float("inf")), 1, "data.P.D12[1][0]"),
        (lambda c: c["data"]["P"]["C1"][0].__setitem__(0, 10**400), 1, "data.P.C1[0][0]"),
        (lambda c: c["data"]["P"].update(D22=[[0.5, 0.5]]), None, "D22"),
        (lambda c: c["data"]["P"].pop("B2"), None, "B2"),
        (lambda c: c["data"]["P"]["A"][0].pop(), 1, "data.P.A"),
        (lambda c: c["data"]["P"].update(C1="x"), 1, "data.P.C1"),
        (lambda c: c["data"].update(blocks=[3]), None, "Bt"),
        (lambda c: c["data"].update(blocks=[-1]), None, "blocks"),
        (lambda c: c["data"]["P"]["A"][0].__setitem__(1, "1"), 1, "data.P.A[0][1]"),
        (lambda c: c["data"]["P"]["A"][0].__setitem__(1, 1e200), 1, "data.P.A[0][1]"),
        (lambda c: c["data"]["P"].update(C1=[], D11=[], D12=[], D1t=[]), None, "C1"),
        (lambda c: c["data"]["P"]["B1"].pop(), None, "B1"),
    ],
)
def test_wrong_file(
    run_squid: Run,
    tmp_path: Path,
    case: dict,
    spoil: Callable[[dict], object],
    line: int | None,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """A wrong file, such as that of a weight that is not proper, is refused with one sentence and no report."""
    spoil(case)
    code, report, error = synth(run_squid, tmp_path / "p.json", case)
    assert refused(code, report, error) == (line, key)
    assert named(error, TMP=tmp_path) == snapshot


def test_plant_of_a_descriptor_with_the_identity(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """E = I and D22 = 0 have no effect."""
    case["data"]["P"].update(E=[[1, 0, 0], [0, 1, 0], [0, 0, 1]], D22=[[0.0]])
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert code == 0 and report["gamma"] == pytest.approx(2.0354532, rel=1e-5)


def frozen(p: dict, order: tuple[str, ...], theta: float) -> np.ndarray:
    """Close the parameter: [[A, B..], [C, D..]] from the matrices named row by row, with channels second."""
    size = round(len(order) ** 0.5)
    rows = [
        [np.array(p[key], dtype=float) for key in order[i : i + size]] for i in range(0, len(order), size)
    ]
    whole, n, r = np.block(rows), len(rows[0][0]), len(rows[1][1])
    keep = [i for i in range(whole.shape[0]) if not n <= i < n + r]
    columns = [j for j in range(whole.shape[1]) if not n <= j < n + r]
    channels = slice(n, n + r)
    closing = np.linalg.solve(
        np.eye(r) - theta * whole[channels, channels], theta * whole[channels][:, columns]
    )
    return whole[np.ix_(keep, columns)] + whole[keep][:, channels] @ closing


def lft(p: np.ndarray, k: np.ndarray, n: int, nk: int, u: int, y: int) -> tuple[np.ndarray, ...]:
    """Return A, B, C, D of the lower LFT of plant [A B1 B2; C1 D11 D12; C2 D21 D22] and controller [A B; C D]."""
    top, bottom = p[:-y], p[-y:]
    w = p.shape[1] - n - u
    ak, bk, ck, dk = k[:nk, :nk], k[:nk, nk:], k[nk:, :nk], k[nk:, nk:]
    algebraic = np.block([[np.eye(u), -dk], [-bottom[:, n + w :], np.eye(y)]])
    given = np.block(
        [[np.zeros((u, n)), ck, np.zeros((u, w))], [bottom[:, :n], np.zeros((y, nk)), bottom[:, n : n + w]]]
    )
    control, measured = np.split(np.linalg.solve(algebraic, given), [u])
    own = np.hstack([top[:, :n], np.zeros((len(top), nk)), top[:, n : n + w]]) + top[:, n + w :] @ control
    law = np.hstack([np.zeros((nk, n)), ak, np.zeros((nk, w))]) + bk @ measured
    state, out = np.vstack([own[:n], law]), own[n:]
    return state[:, : n + nk], state[:, n + nk :], out[:, : n + nk], out[:, n + nk :]


PLANT_ORDER = (
    *("A", "Bt", "B1", "B2"),
    *("Ct", "Dtt", "Dt1", "Dt2"),
    *("C1", "D1t", "D11", "D12"),
    *("C2", "D2t", "D21", "D22"),
)
CONTROLLER_ORDER = ("A", "Bt", "By", "Ct", "Dtt", "Dty", "Cu", "Dut", "Duy")


def test_direct_path(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """With feedthrough from u to y gamma stays, and the written controller keeps its bound in the complete loop."""
    p = case["data"]["P"]
    p["D22"] = [[-1.5]]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--out", str(tmp_path))
    assert (code, report["status"]) == (0, "feasible")
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5) and report["findings"] == []
    k = json.loads((tmp_path / "controller.json").read_text(encoding="utf-8"))
    n, nk = len(p["A"]), len(k["A"])
    for theta in np.linspace(-1.0, 1.0, 9):
        loop = lft(frozen(p, PLANT_ORDER, theta), frozen(k, CONTROLLER_ORDER, theta), n, nk, 1, 1)
        assert np.max(np.linalg.eigvals(loop[0]).real) < 0.0
        for omega in np.logspace(-3, 4, 200):
            inner = np.linalg.solve(1j * omega * np.eye(n + nk) - loop[0], loop[1])
            gain = np.linalg.norm(loop[2] @ inner + loop[3], 2)
            assert gain < report["certified_gamma"]
    certificate = tmp_path / "certificate.json"
    assert run_squid("lpv", "check", tmp_path / "p.json", certificate).returncode == 0
    assert run_squid("verify", certificate).returncode == 0
    for other in ([[0.0]], [[-1.25]]):
        p["D22"] = other
        (tmp_path / "other.json").write_text(json.dumps(case), encoding="utf-8")
        done = run_squid("lpv", "check", tmp_path / "other.json", certificate, "--json")
        found = json.loads(done.stdout)
        assert (done.returncode, found["key"]) == (1, "wrong_plant") and "D22" in found["reason"]


def test_direct_path_that_leaves_the_loop_open(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """If I - Duy D22 is singular nothing is proved, and the reason is named."""
    case["data"]["P"]["D22"] = [[0.5]]
    assert synth(run_squid, tmp_path / "p.json", case, "--out", str(tmp_path))[0] == 0
    path = tmp_path / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    certificate["controller"]["Duy"] = [[2.0]]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("lpv", "check", tmp_path / "p.json", path)
    assert done.returncode == 1 and messages(done) == snapshot


def test_text_that_is_no_problem(
    run_squid: Run, tmp_path: Path, case: dict, snapshot: SnapshotAssertion
) -> None:
    """Text that is not JSON, and a duplicate key, which is ambiguous, are refused with line and column."""
    twice = json.dumps(case).replace('"A":', '"A": [[1.0]], "A":', 1)
    errors = []
    for text, key in (('{"data": [}', "data[0]"), (twice, "data.P")):
        code, report, error = synth(run_squid, tmp_path / "p.json", text)
        assert refused(code, report, error) == (1, key)
        errors.append(named(error, TMP=tmp_path))
    assert errors == snapshot


def test_file_that_is_not_there(run_squid: Run, tmp_path: Path) -> None:
    """A missing file also gives one JSON object."""
    done = run_squid("lpv", "synth", tmp_path / "p.json", "--json")
    assert (done.returncode, json.loads(done.stdout)["key"]) == (1, "not_found")


def test_plant_without_states(run_squid: Run, tmp_path: Path) -> None:
    """The sizes follow from the direct feedthrough; the file is valid."""
    data = {"A": [], "B1": [], "B2": [], "C1": [[]], "C2": [[]], "D11": [[1]], "D12": [[1]], "D21": [[1]]}
    _, report, error = synth(run_squid, tmp_path / "p.json", {"data": data})
    assert report["status"] != "error" and error == ""
