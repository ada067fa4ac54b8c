"""Verbs as functions, and the program in the wheel."""

from __future__ import annotations

import dataclasses
import inspect
import json
import logging
import math
import os
import pickle
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pyhysteron as ph
import pytest
from pyhysteron import outcomes
from pyhysteron._outcome import read


def write_strokes(path, strokes):
    channels = {f"stroke_{k + 1}_m": strokes[:, k] for k in range(4)}
    ph.Recording.from_arrays(channels, rate_hz=100.0).write(path)


def test_simulate_writes_the_bytes_of_the_program_and_the_rows_of_a_rollout(
    scene, twin, strokes, tmp_path, run_program, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    write_strokes("strokes.parquet", strokes)
    outcome = ph.simulate(scene.path, strokes="strokes.parquet", out="tip.parquet")
    made = (tmp_path / "tip.parquet").read_bytes()
    (tmp_path / "tip.parquet").unlink()
    words = ["simulate", scene.path, "--strokes", "strokes.parquet", "--out", "tip.parquet"]
    told = run_program(*words, "--json")
    assert told.returncode == 0, told.stderr
    assert (tmp_path / "tip.parquet").read_bytes() == made
    # The outcome is the same but for the time that it took.
    told = read(outcomes.SimulateOutcome, json.loads(told.stdout))
    timeless = [
        dataclasses.replace(one, steps_per_s=0.0, run=dataclasses.replace(one.run, wall_s=0.0))
        for one in (outcome, told)
    ]
    assert timeless[0] == timeless[1]
    assert outcome.run.samples == 50 and isinstance(outcome.run.tendons[0], outcomes.TendonSummary)
    written = ph.Recording.read("tip.parquet")
    rolled = twin.rollout(ph.Recording.read("strokes.parquet"))
    assert written.keys() == rolled.keys()
    for name in written:
        np.testing.assert_array_equal(written[name], rolled[name])


def test_an_outcome_is_typed_and_reads_back(scene, tmp_path):
    summary = ph.check(scene.path)
    assert isinstance(summary, outcomes.SceneSummary)
    assert read(outcomes.CheckOutcome, json.loads(json.dumps(summary.to_dict()))) == summary
    path = ph.target("circle:30", out=tmp_path / "circle.parquet")
    assert path.length_m == pytest.approx(math.pi * 30e-3, rel=1e-3)
    scores = ph.evaluate(tmp_path / "circle.parquet", target="circle:30")
    assert "<table>" in scores._repr_html_()
    arm = ph.arm.info("scara")
    assert arm.robot == "scara" and arm.joints[0].name


def test_the_verb_run_of_studies_runs(tmp_path):
    with pytest.raises(ph.BadInput) as caught:
        ph.study.run(tmp_path / "none.toml")
    assert caught.value.found == "nothing there"


def test_numbers_that_are_not_finite_read_back():
    part = {"name": "p", "share_at_lower_bound": "NaN", "stroke_max_m": "Infinity", "stroke_min_m": "-Infinity"}
    summary = read(outcomes.TendonSummary, part | {"tension_max_n": 1})
    assert math.isnan(summary.share_at_lower_bound) and summary.stroke_max_m == math.inf
    assert summary.stroke_min_m == -math.inf and isinstance(summary.tension_max_n, float)
    assert read(outcomes.Polish, {"levenberg-marquardt": {"batch": 3}}) == {"levenberg-marquardt": {"batch": 3}}


def test_functions_have_the_signatures_of_the_program():
    parameters = inspect.signature(ph.simulate).parameters
    assert list(parameters)[:3] == ["scene", "strokes", "out"]
    assert parameters["scene"].kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
    assert parameters["strokes"].kind is inspect.Parameter.KEYWORD_ONLY
    assert "Recording with the strokes to follow" in (ph.simulate.__doc__ or "")
    for module in (ph, ph.arm, ph.arm.fit, ph.arm.identify, ph.rig, ph.study):
        for name in module.__all__:
            assert getattr(module, name).__doc__ or not callable(getattr(module, name)), name


def test_errors_are_those_of_the_program(scene, tmp_path, run_program, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ph.BadInput) as caught:
        ph.simulate(scene.path, strokes="none.csv", out="tip.parquet")
    told = run_program("simulate", scene.path, "--strokes", "none.csv", "--out", "tip.parquet")
    assert told.returncode == 2 and told.stderr.strip() == f"error: {caught.value}"
    assert caught.value.place == "none.csv" and caught.value.found == "nothing there"
    with pytest.raises(ph.BadInput) as caught:
        ph.simulate(scene.path, strokes="none.csv", out="tip.parquet", png=True)
    assert "--figures" in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.found == caught.value.found
    with pytest.raises(TypeError):
        ph.simulate(scene.path, out="tip.parquet")
    assert issubclass(ph.BadInput, ph.Error) and issubclass(ph.Failed, ph.Error)


def test_a_verb_is_quiet_unless_asked(tmp_path, capfd):
    ph.target("circle:30", out=tmp_path / "a.parquet")
    assert capfd.readouterr() == ("", "")
    ph.target("circle:30", out=tmp_path / "b.parquet", verbose=True)
    assert str(tmp_path / "b.parquet") in capfd.readouterr().out


def test_warnings_go_to_the_log(scene, strokes, tmp_path, caplog):
    write_strokes(tmp_path / "strokes.parquet", 2.5 * strokes)
    with caplog.at_level(logging.INFO, logger="pyhysteron"):
        ph.simulate(scene.path, strokes=tmp_path / "strokes.parquet", out=tmp_path / "tip.parquet")
    levels = {record.levelno for record in caplog.records if record.name == "pyhysteron"}
    assert logging.INFO in levels and logging.WARNING in levels


def test_progress_is_drawn_by_tqdm(twin, strokes, capfd):
    pytest.importorskip("tqdm")
    twin.rollout(np.tile(strokes, (20, 1)), progress=True)
    assert "1000/1000" in capfd.readouterr().err


INTERRUPTED = """
    import sys, numpy as np, pyhysteron as ph
    twin = ph.Twin(ph.Scene.embedded())
    turn = np.linspace(0.0, 2e3, 2_000_000)
    strokes = np.zeros((len(turn), 4))
    strokes[:, 0] = 2e-3 * np.sin(turn)
    strokes[:, 2] = -strokes[:, 0]
    print("begun", flush=True)
    try:
        twin.rollout(strokes)
    except KeyboardInterrupt as stopped:
        assert isinstance(stopped.__cause__, ph.Cancelled), stopped.__cause__
        assert "interrupted" in str(stopped.__cause__)
        # The twin goes on from where it was.
        twin.step([0.0] * 4)
        sys.exit(42)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_ends_a_rollout_as_python_users_expect():
    words = [sys.executable, "-c", textwrap.dedent(INTERRUPTED)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(1.0)
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 42, errors
    assert time.monotonic() - start < 2.0


def test_the_program_is_in_the_wheel(tmp_path):
    words = [sys.executable, "-m", "pyhysteron"]

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*words, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)

    told = run("--version")
    assert told.returncode == 0 and told.stdout == f"hysteron {ph.__version__}\n"
    assert run("none").returncode == 2
    assert run("check", "none.toml").returncode == 2
    made = run("target", "circle:30", "--out", "circle.parquet")
    assert made.returncode == 0 and (tmp_path / "circle.parquet").exists(), made.stderr
    script = os.path.join(os.path.dirname(sys.executable), "pyhysteron")
    if os.path.exists(script):
        told = subprocess.run([script, "--version"], capture_output=True, text=True, check=False)
        assert told.returncode == 0 and told.stdout.startswith("hysteron ")


def test_a_rig_moves_with_its_watchdog(tmp_path):
    outcome = ph.record(rig="virtual:mild", plan="quick", out=tmp_path / "rec")
    assert outcome.command.startswith("hysteron record --rig virtual:mild")
    assert list((tmp_path / "rec").glob("*.parquet"))
