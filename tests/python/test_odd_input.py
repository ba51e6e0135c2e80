"""Input that nobody would write is answered in words: some of the trials of scripts/fuzz, and what Python can do to a case."""

import copy
import subprocess
import sys

import fuzz
import pytest


@pytest.mark.parametrize("kind", fuzz.KINDS)
def test_random_changes_are_answered_in_words(program, tmp_path, kind):
    trials = fuzz.Trials(str(program), tmp_path, seed=20)
    for _ in range(3 if kind == "calls" else 25):
        getattr(trials, kind)()
    assert not trials.failures, "\n".join(trials.failures)


def test_the_program_lists_with_little_memory(program):
    done = subprocess.run(f"ulimit -v 200000; {program} list", shell=True, capture_output=True, timeout=20)
    assert done.returncode == 0, done.stderr


mp = pytest.importorskip("matpoint")
np = pytest.importorskip("numpy")
pytest.importorskip("matpoint._core")


ball = pytest.importorskip("fuzz_calls").ball


def test_numbers_of_every_kind_of_numpy_are_numbers():
    for kind in (np.longdouble, np.float16, np.float32, np.float64, np.int8, np.uint16, np.int64):
        case = ball(gravity=(0, kind(-9) if kind is not np.uint16 else kind(9)))
        assert case.resolved()["gravity"][1] in (-9, 9)
    assert ball(gravity=np.array([0, -9.81], dtype=np.longdouble)).resolved()["gravity"][1] == pytest.approx(-9.81)


def endless():
    items = []
    items.append(items)
    return items


@pytest.mark.parametrize(
    "changes",
    [
        {"title": "\ud800"},
        {"title": {"\udfff": 1}},
        {"gravity": endless()},
        {"gravity": (0, np.clongdouble(1j))},
        {"gravity": (0, 10**400)},
        {"gravity": (0, object())},
        {"gravity": np.zeros((2, 2))},
        {"gravity": np.array(["a", "b"])},
        {"gravity": (0, np.datetime64("2020-01-01"))},
        {"grid": {"upper": (1, 1), "cells": (np.longdouble("nan"), 1)}},
        {"body": [{"name": "\ud800"}]},
        {"title": b"bytes"},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_odd_values_are_input_errors(changes):
    for act in (lambda: ball(**changes).check(), lambda: ball(**changes).build(), lambda: copy.copy(ball(**changes)).resolved()):
        with pytest.raises(mp.InputError) as caught:
            act()
        assert 10 < len(str(caught.value)) < 2000


def test_names_and_paths_with_half_a_character_are_input_errors(tmp_path):
    with pytest.raises(mp.InputError):
        mp.Case("\ud800").build()
    simulation = ball().build()
    for act in (
        lambda: simulation.save("\ud800.h5"),
        lambda: mp.load("\ud800.h5"),
        lambda: simulation.run(output="\ud800"),
        lambda: mp.Case.from_toml("\ud800"),
    ):
        with pytest.raises(mp.InputError):
            act()


def test_an_interpreter_that_ends_while_a_run_goes_on_in_a_thread_ends_in_peace(tmp_path):
    script = """
import pathlib, threading, time
import matpoint as mp
case = mp.Case("ball", grid=mp.Grid(upper=(1, 1), cells=(20, 20)), time=mp.Time(end=1e9),
    body=mp.Body(name="ball", region=mp.Disk(center=(0.5, 0.5), radius=0.2), layout=mp.PerCell(count=4),
        material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3)))
simulation = case.build()
threading.Thread(target=lambda: simulation.run(output="r"), daemon=True).start()
while not pathlib.Path("r/ball.vtkhdf").exists():
    time.sleep(0.01)
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "terminate" not in done.stderr, done.stderr
    assert 'status = "interrupted"' in (tmp_path / "r/manifest.toml").read_text()
