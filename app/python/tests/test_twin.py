"""Scenes and twins: steps, rollouts, goals, states."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pyhysteron as ph
import pytest


def test_the_embedded_scene_is_the_robot_of_the_repository(scene):
    assert (scene.name, scene.n_tendons, scene.n_auxiliary) == ("tpu80", 4, 0)
    assert scene.tendon_names == ["p1", "p2", "p3", "p4"]
    assert scene.drives == ["stroke"] * 4
    assert len(scene.hash) == 64
    html = scene._repr_html_()
    assert "tpu80" in html and "p4" in html


def test_a_pulled_tendon_bends_the_robot_towards_it(twin):
    rest = twin.tip
    report = twin.step([1e-3, 0.0, -1e-3, 0.0])
    assert report.tip[0] > rest[0] + 1e-3
    np.testing.assert_array_equal(report.tip, twin.tip)
    np.testing.assert_array_equal(report.tensions, twin.tensions)
    assert report.tensions[0] > 1.0
    assert report.relative_residual < 1e-3 and report.outside == 0.0 and not report.is_outside
    # The stroke of a taut tendon is met within the tolerance of the scene.
    assert abs(twin.strokes[0] - 1e-3) <= report.stroke_error + 1e-12
    w, x, y, z = twin.tip_orientation
    assert w == pytest.approx(np.sqrt(1.0 - x * x - y * y - z * z)) and y > 0.01


def test_a_rollout_is_its_steps(twin, strokes):
    recording = twin.rollout(strokes, rate_hz=100.0)
    np.testing.assert_array_equal(recording["stroke_1_m"], strokes[:, 0])
    assert recording.rate_hz == pytest.approx(100.0)
    tip = np.column_stack([recording[f"tip_{axis}_m"] for axis in "xyz"])
    tensions = np.column_stack([recording[f"tension_{k}_n"] for k in range(1, 5)])
    other = ph.Twin(ph.Scene.embedded())
    for row, command in enumerate(strokes):
        report = other.step(command if row % 2 else list(command))
        np.testing.assert_array_equal(report.tip, tip[row])
        np.testing.assert_array_equal(report.tensions, tensions[row])
    # It ends where the steps end.
    np.testing.assert_array_equal(twin.tip, other.tip)


def test_reset_forgets(twin, strokes):
    first = twin.rollout(strokes)
    twin.reset()
    again = twin.rollout(strokes)
    assert first == again


def test_a_state_is_restored_from_memory_and_from_a_file(twin, strokes, tmp_path):
    twin.rollout(strokes[:20])
    state, tip = twin.state(), twin.tip
    twin.save_state(tmp_path / "a.state")
    ahead = twin.rollout(strokes[20:])
    twin.restore(state)
    np.testing.assert_array_equal(twin.tip, tip)
    assert twin.rollout(strokes[20:]) == ahead
    twin.load_state(tmp_path / "a.state")
    np.testing.assert_array_equal(twin.tip, tip)


def test_a_goal_is_reached_and_its_strokes_lead_there(twin):
    twin.step([1.5e-3, 0.0, -1.5e-3, 0.0])
    goal = twin.tip
    twin.reset()
    reached = twin.reach(goal, tolerance=1e-4)
    assert reached.is_reached and reached.tip_error <= 1e-4
    again = ph.Twin(ph.Scene.embedded())
    assert np.linalg.norm(again.step(reached.strokes).tip - goal) < 2e-4


def test_bad_strokes_are_refused_in_the_words_of_the_program(twin):
    with pytest.raises(ph.BadInput) as caught:
        twin.step([1e-3])
    assert (caught.value.place, caught.value.expected, caught.value.found) == ("strokes", "4 numbers", "1")
    with pytest.raises(ph.BadInput, match="-20 to 20 mm, the bounds of tendon p1, got 1000 mm"):
        twin.step([1.0, 0.0, 0.0, 0.0])
    with pytest.raises(ph.BadInput, match="strokes: expected an array n × 4, or 4 numbers, got shape 3 × 3"):
        twin.rollout(np.zeros((3, 3)))
    with pytest.raises(ph.BadInput, match="strokes: row 2: stroke_2_m: expected a finite number, got NaN"):
        twin.rollout(np.array([[0.0] * 4, [0.0, np.nan, 0.0, 0.0]]))
    with pytest.raises(TypeError):
        twin.step("abcd")
    # Nothing has moved.
    np.testing.assert_array_equal(twin.tip, ph.Twin(ph.Scene.embedded()).tip)


def test_a_reduced_body_that_is_not_there_is_bad_input(scene):
    with pytest.raises(ph.BadInput) as caught:
        ph.Twin(scene, reduced=Path("none.json"))
    assert "none.json" in caught.value.place


def test_other_threads_run_while_a_twin_moves(twin, strokes):
    counts, is_done = [0], threading.Event()

    def count() -> None:
        while not is_done.is_set():
            counts[0] += 1
            time.sleep(1e-3)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.perf_counter()
    twin.rollout(np.tile(strokes, (20, 1)))
    spent = time.perf_counter() - start
    is_done.set()
    counter.join()
    assert counts[0] > 100 * spent


def test_two_threads_take_turns_with_one_twin(twin, strokes):
    errors: list[BaseException] = []

    def run() -> None:
        try:
            for command in strokes:
                twin.step(command)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=run) for _ in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert not errors
