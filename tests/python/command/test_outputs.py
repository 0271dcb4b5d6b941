"""Output of `squid`: written completely or not at all, never lost silently; and reports on a design without a proof."""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import stat
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import UNBROKEN, Run, masked, messages, named, refusal
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

SQUID = ROOT / "vehicles" / "squid"
CASE = ROOT / "tests" / "cases" / "lpv05_one_param_lossless.json"
MU = ROOT / "tests" / "cases" / "mu04_packard_doyle_gap.json"
FULL = Path("/dev/full")
full_device = pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")


@pytest.fixture(scope="module")
def designed(run_squid: Run, quick_vehicle: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a design of the quick vehicle and its flights."""
    folder = tmp_path_factory.mktemp("designed")
    for verb in ("design", "simulate"):
        assert run_squid(verb, quick_vehicle, "--out", folder).returncode == 0
    return folder


@pytest.fixture
def copied_design(designed: Path, tmp_path: Path) -> Path:
    """Return a copy of that folder that a test may modify."""
    return Path(shutil.copytree(designed, tmp_path / "out"))


def contents(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder, including temporary ones, except the lock."""
    paths = (path for path in folder.iterdir() if path.is_file() and path.name != ".squid-lock")
    return {path.name: path.read_bytes() for path in paths}


def unproved_vehicle(folder: Path) -> Path:
    """Return a copy of Squid whose design remains without a proof.

    A first-order fit from 0.1 m/s on deviates from the true linearisations by more than any bound of the paper's loop
    covers.
    """
    vehicle = Path(shutil.copytree(SQUID, folder))
    path = vehicle / "design.toml"
    text = (vehicle / "paper.toml").read_text(encoding="utf-8")
    for old, new in (("\nspeed_min = 0.5", "\nspeed_min = 0.1"), ("\norder = 2", "\norder = 1")):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text.partition("\n[uncertainty]\n")[0], encoding="utf-8")
    return vehicle


def test_a_design_that_is_not_proved_is_no_success(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The files are written, the exit code is 1, and all output about the design starts with the warning."""
    vehicle, out = unproved_vehicle(tmp_path / "vehicle"), tmp_path / "out"
    done = run_squid("design", vehicle, "--no-advise", "--out", out, "--json")
    assert done.returncode == 1
    assert masked(messages(done, TMP=tmp_path)) == snapshot
    assert json.loads((out / "design.json").read_text("utf-8"))["certified"] is False
    for words in (["simulate"], ["report"], ["show"], ["show", "--speed", "1"]):
        done = run_squid(words[0], vehicle, *words[1:], "--out", out)
        assert done.returncode == 0, done.stderr
        warning = done.stdout.splitlines()[0]
        found = json.loads(run_squid(words[0], vehicle, *words[1:], "--out", out, "--json").stdout)
        first = found["warnings"][0]
        assert first["kind"] == "not_proved" and warning == f"WARNING: {first['why']}", words
        if words[0] != "report":
            assert found["proved"] is False and first["why"].endswith(found["not_proved_because"]), words
    assert masked(named(warning, TMP=tmp_path)) == snapshot
    page = (out / "report.html").read_text("utf-8")
    assert 0 < page.index("NOT PROVED: ") < page.index("<nav>")


@pytest.mark.parametrize(
    ("verb", "spoilt"),
    [("simulate", "removed"), ("show", "removed"), ("show", "gamma"), ("simulate", "gamma")],
)
def test_a_certificate_that_does_not_prove_is_told_first(
    run_squid: Run,
    quick_vehicle: Path,
    copied_design: Path,
    verb: str,
    spoilt: str,
    snapshot: SnapshotAssertion,
) -> None:
    certificate = copied_design / "certificate.json"
    if spoilt == "removed":
        certificate.unlink()
    else:
        values = json.loads(certificate.read_text("utf-8"))
        values["claims"][0]["gain"]["gamma"] *= 0.9
        certificate.write_text(json.dumps(values), encoding="utf-8")
    done = run_squid(verb, quick_vehicle, "--out", copied_design)
    assert masked(named(done.stdout.splitlines()[0], OUT=copied_design)) == snapshot
    found = json.loads(run_squid(verb, quick_vehicle, "--out", copied_design, "--json").stdout)
    assert found["warnings"][0]["kind"] == "not_proved"


def test_a_proved_design_is_not_called_unproved(run_squid: Run, quick_vehicle: Path, designed: Path) -> None:
    done = run_squid("show", quick_vehicle, "--out", designed)
    assert done.returncode == 0 and "NOT PROVED" not in done.stdout
    for verb in ("show", "simulate"):
        found = json.loads(run_squid(verb, quick_vehicle, "--out", designed, "--json").stdout)
        assert found["proved"] is True and "not_proved_because" not in found, verb


@pytest.mark.parametrize("verb", ["show", "simulate", "report", "package", "export", "campaign"])
def test_a_design_of_another_version_must_be_made_again(
    run_squid: Run, quick_vehicle: Path, copied_design: Path, verb: str
) -> None:
    """Of every verb that reads a stored design; `squid design` replaces it."""
    path = copied_design / "controller.json"
    values = json.loads(path.read_text("utf-8"))
    values["saturation"] = values.pop("anti_windup", [])
    path.write_text(json.dumps(values), encoding="utf-8")
    before = contents(copied_design)
    done = run_squid(verb, quick_vehicle, "--out", copied_design, "--json")
    assert refusal(done, "other_format")["reason"].startswith(str(path))
    assert contents(copied_design) == before
    if verb == "show":
        assert run_squid("design", quick_vehicle, "--no-advise", "--out", copied_design).returncode == 0
        assert run_squid("show", quick_vehicle, "--out", copied_design).returncode == 0


def test_show_prints_the_controller_that_is_stored(
    run_squid: Run, quick_vehicle: Path, copied_design: Path
) -> None:
    """A stored controller with modes twice as fast as designed: its poles are shown, and that it is not proved."""
    path = copied_design / "controller.json"
    values = json.loads(path.read_text("utf-8"))
    values["lft"]["A"] = (2.0 * np.array(values["lft"]["A"])).tolist()
    path.write_text(json.dumps(values), encoding="utf-8")
    done = run_squid("show", quick_vehicle, "--controller", "--out", copied_design)
    assert done.returncode == 0, done.stderr
    assert str(copied_design) in done.stdout
    middle = np.array(values["lft"]["A"])
    slowest = min(np.linalg.eigvals(middle), key=abs)
    assert f"{slowest.real:.5f}" in done.stdout.split("(rho = +0)")[1].split("(rho = +1)")[0]


@pytest.mark.parametrize("words", [[], ["--controller"], ["--speed", "1"], ["--uncertainty"]])
def test_show_of_a_folder_without_a_design(run_squid: Run, tmp_path: Path, words: list[str]) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        assert run_squid("show", SQUID, *words, "--out", folder).stdout == ""
        done = run_squid("show", SQUID, *words, "--out", folder, "--json")
        assert str(folder) in refusal(done, "not_designed")["reason"]
    assert not list(tmp_path.iterdir())


def on_full_device(command: list[str | Path]) -> subprocess.CompletedProcess:
    """Run a command whose standard output cannot be written."""
    with FULL.open("w") as full:
        return subprocess.run(command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False)


@pytest.fixture(scope="module")
def lost(squid_command: Path) -> str:
    """Return what the command says if its standard output cannot be written."""
    return on_full_device([squid_command, "--version"]).stderr


@full_device
def test_the_sentence_on_lost_words(lost: str, snapshot: SnapshotAssertion) -> None:
    assert lost == snapshot


@full_device
@pytest.mark.parametrize(
    "words",
    [
        ["--help"],
        ["show", SQUID, "--speed", "1"],
        ["design", "VEHICLE", "--out", "OUT"],
        ["simulate", "VEHICLE", "--out", "OUT"],
        ["verify", "OUT/certificate.json"],
        ["plot", "OUT/flight.csv"],
        ["lpv", "synth", CASE, "--json"],
        ["lpv", "synth", CASE],
        ["lpv", "mu", MU],
    ],
    ids=lambda words: " ".join(map(str, words[:2])),
)
def test_words_that_are_lost_are_told(
    squid_command: Path, quick_vehicle: Path, copied_design: Path, words: list[str | Path], lost: str
) -> None:
    """Standard output on a full device: one sentence, that of `--version`, and exit code 1."""
    places = {"OUT": str(copied_design), "VEHICLE": str(quick_vehicle)}
    command = [squid_command, *(re.sub("OUT|VEHICLE", lambda m: places[m[0]], str(word)) for word in words)]
    done = on_full_device(command)
    assert (done.returncode, done.stderr) == (1, lost)


@full_device
def test_standard_error_that_is_full_is_no_panic(squid_command: Path) -> None:
    with FULL.open("w") as full:
        done = subprocess.run([squid_command, "show", "nowhere"], cwd=ROOT, stderr=full, check=False)
    assert done.returncode == 1


@pytest.mark.parametrize("words", [["--help"], ["show", SQUID], ["lpv", "synth", CASE, "--json"]])
def test_a_reader_that_goes_away_is_no_failure(squid_command: Path, words: list) -> None:
    command = [squid_command, *map(str, words)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert (process.stderr.read(), process.wait(timeout=120)) == (b"", 0)


@full_device
def test_a_plot_on_a_full_device(
    run_squid: Run, designed: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A device is written to, not replaced by a file."""
    device = tmp_path / "full"
    device.symlink_to(FULL)
    done = run_squid("plot", designed / "flight.csv", "--out", device, "--json")
    refusal(done, "unwritable")
    assert messages(done, TMP=tmp_path) == snapshot
    assert device.is_symlink() and stat.S_ISCHR(device.stat().st_mode)


def test_a_plot_into_a_pipe(squid_command: Path, designed: Path, tmp_path: Path) -> None:
    pipe, copy = tmp_path / "pipe", tmp_path / "copy.svg"
    os.mkfifo(pipe)
    with copy.open("wb") as file, subprocess.Popen(["cat", pipe], stdout=file) as reader:
        words = [squid_command, "plot", designed / "flight.csv", "--out", pipe]
        done = subprocess.run(words, cwd=ROOT, capture_output=True, check=False)
        if not stat.S_ISFIFO(pipe.lstat().st_mode):
            reader.kill()
    assert done.returncode == 0 and stat.S_ISFIFO(pipe.lstat().st_mode)
    text = copy.read_text("utf-8")
    assert text.startswith("<svg") and text.rstrip().endswith("</svg>")


def limited(squid_command: Path, size: int, *words: str | Path) -> subprocess.CompletedProcess:
    """Run `squid` with a limit on the size of files (bytes), which simulates a full disk."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    command = [squid_command, *map(str, words)]
    return subprocess.run(
        command,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "COLUMNS": UNBROKEN},
        preexec_fn=limit,
        restore_signals=False,
    )


def test_a_full_disk_leaves_the_earlier_design_whole(
    squid_command: Path, quick_vehicle: Path, copied_design: Path
) -> None:
    """The largest file does not fit: none is written, and none is left over."""
    before = contents(copied_design)
    names = ("plant.json", "certificate.json", "controller.json", "design.json")
    room = max(len(before[name]) for name in names) - 100
    for out in (copied_design, copied_design / "new"):
        done = limited(squid_command, room, "design", quick_vehicle, "--out", out, "--json")
        refusal(done, "unwritable")
        assert len(done.stderr.splitlines()) == 1
    assert contents(copied_design) == before and not (copied_design / "new").exists()


def test_a_full_disk_leaves_earlier_flights_and_syntheses_whole(
    squid_command: Path, run_squid: Run, quick_vehicle: Path, copied_design: Path, tmp_path: Path
) -> None:
    before = contents(copied_design)
    (copied_design / "steps.svg").write_text("earlier", encoding="utf-8")
    room = len(before["flight.csv"]) - 1000
    assert len(before["flight.svg"]) < room
    done = limited(squid_command, room, "simulate", quick_vehicle, "--out", copied_design, "--json")
    refusal(done, "unwritable")
    assert contents(copied_design) == before | {"steps.svg": b"earlier"}
    assert run_squid("lpv", "synth", CASE, "--out", tmp_path / "lpv").returncode == 0
    before = contents(tmp_path / "lpv")
    room = len(before["certificate.json"]) - 100
    assert min(map(len, before.values())) < room
    words = ["lpv", "synth", CASE, "--back-off", "0.3", "--out", tmp_path / "lpv", "--json"]
    done = limited(squid_command, room, *words)
    assert "certificate.json" in refusal(done, "unwritable")["reason"]
    assert contents(tmp_path / "lpv") == before


@pytest.mark.parametrize(
    "words", [["design", SQUID, "--robust"], ["simulate", SQUID], ["report", SQUID], ["lpv", "synth", CASE]]
)
def test_an_output_that_cannot_be_is_told_before_the_work(
    run_squid: Run, tmp_path: Path, words: list[str | Path]
) -> None:
    """No stage runs if the output cannot be written."""
    file = tmp_path / "file"
    file.write_text("mine", encoding="utf-8")
    for out in (file, file / "deeper" / "still"):
        done = run_squid(*words, "--out", out)
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.startswith(f"squid: {file}: ") and len(done.stderr.splitlines()) == 1
    assert file.read_text("utf-8") == "mine"


def test_missing_binaries_are_told_before_the_work(
    run_squid: Run, quick_vehicle: Path, copied_design: Path, tmp_path: Path
) -> None:
    """Missing binaries are reported before the proof, which is the first stage, and before the report."""
    words = ["package", quick_vehicle, "--out", copied_design, "--binaries", tmp_path]
    assert run_squid(*words).stdout == ""
    assert str(tmp_path) in refusal(run_squid(*words, "--json"), "no_binary")["reason"]
    assert not list(copied_design.glob("*.fmu"))


def test_a_design_is_the_same_on_any_number_of_threads(
    monkeypatch: pytest.MonkeyPatch, run_squid: Run, quick_vehicle: Path, tmp_path: Path
) -> None:
    """Every file is the same to the last bit: no sum is formed in an order that depends on the machine."""
    found = []
    for threads in ("1", "2", "4"):
        monkeypatch.setenv("RAYON_NUM_THREADS", threads)
        out = tmp_path / threads
        assert run_squid("design", quick_vehicle, "--no-advise", "--out", out).returncode == 0
        found.append(contents(out))
    assert len(found[0]) > 3
    assert found[0] == found[1] == found[2]
