"""`squid lpv`: synthesis for general plants in a file, its three outcomes, and wrong files."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import Run
from fly.stages import ROOT

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
    """Controller and certificate are written, and the certificate is accepted for this plant only."""
    done = run_squid("lpv", "synth", CASE, "--out", tmp_path)
    assert done.returncode == 0 and "PROVED" in done.stdout
    assert {path.name for path in tmp_path.glob("[!.]*")} == {
        "report.json",
        "controller.json",
        "certificate.json",
    }
    assert run_squid("lpv", "check", CASE, tmp_path / "certificate.json").returncode == 0
    assert run_squid("verify", tmp_path / "certificate.json").returncode == 0
    other = CASE.with_name("lpv01_lpvtools_lft_tutorial.json")
    done = run_squid("lpv", "check", other, tmp_path / "certificate.json")
    assert done.returncode == 1 and "does not belong to this plant" in done.stderr


def test_check_answers_with_one_object(run_squid: Run, tmp_path: Path) -> None:
    """Proved, not proved and a wrong file are distinguished, with gamma or a reason."""
    done = run_squid("lpv", "synth", CASE, "--json", "--out", tmp_path)
    gamma = json.loads(done.stdout)["certified_gamma"]
    path = tmp_path / "certificate.json"

    def check(problem: Path) -> tuple[int, dict]:
        done = run_squid("lpv", "check", problem, path, "--json")
        return done.returncode, json.loads(done.stdout)

    assert check(CASE) == (0, {"status": "proved", "gamma": gamma, "reason": None})
    code, verdict = check(CASE.with_name("lpv01_lpvtools_lft_tutorial.json"))
    assert (code, verdict["status"]) == (1, "not_proved")
    assert "does not belong to this plant" in verdict["reason"]
    code, verdict = check(tmp_path / "none.json")
    assert (code, verdict["status"]) == (1, "error") and "none.json" in verdict["reason"]
    certificate = json.loads(path.read_text(encoding="utf-8"))
    claim(certificate, "gain")["gamma"] = 0.9 * gamma
    path.write_text(json.dumps(certificate), encoding="utf-8")
    code, verdict = check(CASE)
    assert (code, verdict["status"]) == (1, "not_proved") and "pivot" in verdict["reason"]
    both = {key: [*certificate[key], 0] for key in ("blocks", "controller_blocks")}
    path.write_text(json.dumps(certificate | both), encoding="utf-8")
    code, verdict = check(CASE)
    assert (code, verdict["status"]) == (1, "error") and "certificate.json: blocks[1]" in verdict["reason"]


def test_back_off_is_told(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """The report states the gamma at which the controller was built, and its distance from the least."""
    _, report, _ = synth(run_squid, tmp_path / "p.json", case, "--back-off", "0.25")
    assert report["back_off"] == pytest.approx(0.25, abs=1e-6) and report["remarks"] == []
    assert report["gamma_design"] == pytest.approx(1.25 * report["gamma"], rel=1e-6)
    done = run_squid("lpv", "synth", CASE, "--back-off", "0.25")
    assert "25.0 % above it" in done.stdout and "remark" not in done.stdout


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["lpv", "synth"], "required"),
        (["lpv", "synth", CASE, "--back-off", "-1"], "--back-off is -1; it must be from 0.001 to 1"),
        (["lpv", "synth", CASE, "--gamma-limit", "-1"], "--gamma-limit is -1; it must be above 0"),
        (["lpv", "synth", CASE, "--back-off", "x"], "invalid value"),
        (["lpv", "check", CASE], "required"),
        (["show", "vehicles/squid", "--speed", "nan"], "--speed is NaN"),
        (["fly"], "unrecognized subcommand"),
        ([], "Usage"),
    ],
)
def test_wrong_usage_is_not_infeasible(run_squid: Run, words: list, found: str) -> None:
    """A wrong command line ends with 64, because 2 is the code of a proof that there is no controller."""
    done = run_squid(*words)
    assert done.returncode == 64 and found in done.stderr and not done.stdout


def test_help_is_no_wrong_usage(run_squid: Run) -> None:
    """Requested help goes to standard output, and explains the exit codes."""
    done = run_squid("lpv", "synth", "--help")
    assert done.returncode == 0 and "64: the command line is wrong" in done.stdout


def assert_refused(code: int, report: dict, error: str, words: str) -> None:
    """Check that a file was refused with one sentence that names it, on standard error and as an object."""
    assert code == 1 and len(error.strip().splitlines()) == 1
    assert words in error and "p.json" in error
    assert report == {"status": "error", "reason": error.removeprefix("squid: ").strip()}


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


def test_mode_that_cannot_be_stabilised(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable mode that is not controllable is named."""
    case["data"]["P"]["A"][2] = [0.0, 0.0, 0.5]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.5000" in report["reason"] and "not reached by any control input" in report["reason"]
    assert report["gamma"] is None and report["certified_gamma"] is None


def test_mode_that_cannot_be_seen(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable mode that is not observable is named."""
    p = case["data"]["P"]
    p["A"][2] = [0.0, 0.0, 0.25]
    p["B2"][2] = [1.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.2500" in report["reason"] and "not seen in any measurement" in report["reason"]


def test_parameter_that_no_controller_tames(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable part driven by the parameter only is out of reach of any controller: provably infeasible."""
    p = case["data"]["P"]
    # The third state gets the pole -0.5 + theta, out of reach of the control.
    p["Bt"][2] = [1.0, 0.0]
    p["Ct"][0] = [0.0, 0.0, 1.0]
    p["Bt"][0] = p["Bt"][1] = [0.0, 0.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible"), report
    assert "every trajectory of them; another kind of controller may exist" in report["reason"]


def test_gamma_above_the_limit(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """The report states how far, and on which path, the limit is missed."""
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--gamma-limit", "1.5")
    assert (code, report["status"]) == (2, "infeasible")
    assert "above the limit 1.5000" in report["reason"] and "path from w" in report["reason"]
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5)


def test_controllers_that_are_too_fast(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """A limit that no computed controller meets is neither a proof of infeasibility nor a numerical failure."""
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--fastest-mode", "0.001")
    assert (code, report["status"]) == (4, "too_fast")
    assert "times as fast as the limit allows" in report["reason"]
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5) and report["certified_gamma"] is None
    assert report["remarks"] == []


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


def test_remarks_on_what_has_no_price(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """A control without weight and a measurement without noise are reported, whatever the outcome."""
    p = case["data"]["P"]
    p["D12"], p["D21"] = zeros(p["D12"]), zeros(p["D21"])
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (0, "feasible")
    weight, noise = report["remarks"]
    assert "give u1 a weight (column 1 of D12)" in weight
    assert "add noise to y1 (row 1 of D21)" in noise
    shown = run_squid("lpv", "synth", tmp_path / "p.json").stdout
    assert all(f"  remark: {remark}\n" in shown for remark in (weight, noise))


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
    added = [remark for remark in report["remarks"] if "designed for the plant with" in remark]
    most = 1 + ASKED_BACK_OFF + PROOF_ROUNDING
    assert report["gamma"] <= report["certified_gamma"] <= most * report["gamma"]
    for remark in added:
        assert "u1 (weight)" in remark and "plant as given" in remark
        assert "of it in y1 (noise)" in remark or np.any(plant["D21"][0])
    assert run_squid("lpv", "check", path, tmp_path / "certificate.json").returncode == 0


def test_singular_problem_without_a_least_gamma(run_squid: Run, tmp_path: Path) -> None:
    """Without weights the gain of this plant can be made arbitrarily small, which is reported."""
    problem = json.loads((CASE.parent / "compleib" / "compleib_DIS1.json").read_text(encoding="utf-8"))
    problem["data"]["D12"] = zeros(problem["data"]["D12"])
    code, report, _ = synth(run_squid, tmp_path / "p.json", problem)
    assert (code, report["status"]) == (0, "feasible")
    assert report["gamma"] < 1e-6 * report["certified_gamma"] < 1e-6 and report["back_off"] is None
    assert any("the computed least gamma is zero up to rounding" in remark for remark in report["remarks"])
    assert any("designed for the plant with an output" in remark for remark in report["remarks"])


def test_what_was_added_is_told_to_people(run_squid: Run) -> None:
    """The text has the remark in addition to the proof."""
    done = run_squid("lpv", "synth", CASE.parent / "singular" / "five_states_one_control.json")
    assert done.returncode == 0 and "PROVED" in done.stdout
    assert "remark: the controller was designed for the plant with" in done.stdout


def test_remarks_stand_beside_any_outcome(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """The text has remarks on the problem in addition to any outcome."""
    p = case["data"]["P"]
    p["D12"] = zeros(p["D12"])
    path = tmp_path / "p.json"
    path.write_text(json.dumps(case), encoding="utf-8")
    done = run_squid("lpv", "synth", path, "--fastest-mode", "0.001")
    assert done.returncode == 4
    assert "remark: no performance output weighs u1" in done.stdout
    done = run_squid("lpv", "synth", path)
    assert done.returncode == 0 and "remark: no performance output weighs u1" in done.stdout


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (
            lambda c: c["data"]["P"].update(E=[[1, 0, 0], [0, 1, 0], [0, 0, 0]]),
            "'E' is 0 in row 3, column 3; it must be the identity",
        ),
        (
            lambda c: c["data"]["P"]["D12"][1].__setitem__(0, None),
            "'data.P.D12[1][0]': found null, must be a finite number",
        ),
        (lambda c: c["data"]["P"]["D12"][1].__setitem__(0, float("inf")), "not proper"),
        (lambda c: c["data"]["P"]["C1"][0].__setitem__(0, 10**400), "numbers must be finite"),
    ],
)
def test_weight_that_is_not_proper(run_squid: Run, tmp_path: Path, case: dict, spoil, words: str) -> None:
    """A state-space equivalent of an improper weight is refused with one sentence."""
    spoil(case)
    code, report, error = synth(run_squid, tmp_path / "p.json", case)
    assert_refused(code, report, error, words)


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
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5) and report["remarks"] == []
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
        done = run_squid("lpv", "check", tmp_path / "other.json", certificate)
        assert done.returncode == 1 and "does not belong to this plant: matrix D22" in done.stderr


def test_direct_path_that_leaves_the_loop_open(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """If I - Duy D22 is singular nothing is proved, and the reason is named."""
    case["data"]["P"]["D22"] = [[0.5]]
    assert synth(run_squid, tmp_path / "p.json", case, "--out", str(tmp_path))[0] == 0
    path = tmp_path / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    certificate["controller"]["Duy"] = [[2.0]]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("lpv", "check", tmp_path / "p.json", path)
    assert (
        done.returncode == 1 and "not well posed" in done.stderr and "I - Duy D22 is singular" in done.stderr
    )


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (
            lambda c: c["data"]["P"].update(D22=[[0.5, 0.5]]),
            "'D22' is 1 x 2; with the other matrices it must be 1 x 1",
        ),
        (lambda c: c["data"]["P"].pop("B2"), "'B2' is missing"),
        (lambda c: c["data"]["P"]["A"][0].pop(), "'data.P.A': rows of different lengths; the first has"),
        (
            lambda c: c["data"]["P"].update(C1="x"),
            "'data.P.C1': invalid type: string \"x\", expected a list",
        ),
        (lambda c: c["data"].update(blocks=[3]), "must be"),
        (lambda c: c["data"].update(blocks=[-1]), "'blocks' has the number -1 in place 1"),
        (
            lambda c: c["data"]["P"]["A"][0].__setitem__(1, "1"),
            "'data.P.A[0][1]': invalid type: string \"1\", expected a number",
        ),
        (
            lambda c: c["data"]["P"]["A"][0].__setitem__(1, 1e200),
            "'data.P.A[0][1]': found 1e200, must be at most 1e100",
        ),
        (lambda c: c["data"]["P"].update(C1=[], D11=[], D12=[], D1t=[]), "needs a performance channel"),
        (lambda c: c["data"]["P"]["B1"].pop(), "B1"),
    ],
)
def test_wrong_file(run_squid: Run, tmp_path: Path, case: dict, spoil, words: str) -> None:
    """A wrong file is refused with one sentence and no report."""
    spoil(case)
    code, report, error = synth(run_squid, tmp_path / "p.json", case)
    assert_refused(code, report, error, words)


def test_not_json(run_squid: Run, tmp_path: Path) -> None:
    """Text that is not JSON is refused with file, line and column."""
    code, report, error = synth(run_squid, tmp_path / "p.json", '{"data": [}')
    assert_refused(code, report, error, "p.json:1: this is not JSON: expected value (column 11)")


def test_key_that_stands_twice(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """A duplicate key is ambiguous; certificates are treated likewise."""
    text = json.dumps(case).replace('"A":', '"A": [[1.0]], "A":', 1)
    code, report, error = synth(run_squid, tmp_path / "p.json", text)
    assert_refused(code, report, error, "'data.P': duplicate field `A`")


def test_file_that_is_not_there(run_squid: Run, tmp_path: Path) -> None:
    """A missing file also gives one JSON object."""
    done = run_squid("lpv", "synth", tmp_path / "p.json", "--json")
    assert_refused(done.returncode, json.loads(done.stdout), done.stderr, "there is no such file")


def test_plant_without_states(run_squid: Run, tmp_path: Path) -> None:
    """The sizes follow from the direct feedthrough; the file is valid."""
    data = {"A": [], "B1": [], "B2": [], "C1": [[]], "C2": [[]], "D11": [[1]], "D12": [[1]], "D21": [[1]]}
    _, report, error = synth(run_squid, tmp_path / "p.json", {"data": data})
    assert report["status"] != "error" and error == ""
