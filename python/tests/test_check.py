"""Checks of callables: verdicts, causes, exceptions, batches, JAX."""

import json
import os
import re
import subprocess
import sys
import traceback

import jax
import jax.numpy as jnp
import numpy
import pytest
import routines

import pintle

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "corpus"))
import connectors

jax.config.update("jax_enable_x64", True)
QUICK = {"states": 30, "near_singular_states": 5, "wide_states": 5, "histories": 5}


def test_a_right_routine_passes(pintle_check):
    report = pintle_check(routines.cartesian, "CARTESIAN", **QUICK)
    assert report.ok and report.verdict == "pass" and report.worst is None and report.cause == []
    assert report.compared > 1000, report.compared


def test_a_wrong_one_is_named_with_its_cause():
    report = pintle.check(routines.without_arm, "CARTESIAN", **QUICK)
    assert not report.ok and not report and report.verdict == "wrong"
    assert "θa" in report.worst.entry and report.worst.got == 0.0 and report.worst.units > 1e6
    assert report.codes == {"diagnosis::geometric-term-missing"}
    assert any("lever" in sentence for sentence in report.cause)
    with pytest.raises(AssertionError, match="✗"):
        report.assert_ok()
    assert json.loads(report.to_json())["mismatches"] == 1
    assert report.to_html().lstrip().startswith("<!") and "<iframe" in report._repr_html_()
    assert report.repeat in repr(report)
    again = eval(report.repeat, {"pintle": pintle, "routines": routines})
    assert again.to_json() == report.to_json()


def test_the_command_says_the_same():
    words = ["--states", "30", "--near-singular-states", "5", "--wide-states", "5", "--histories", "5", "--format", "json"]
    program = "import sys; from pintle._command import main; sys.exit(main())"
    command = [sys.executable, "-c", program, "check", "CARTESIAN", "--python", "routines:without_arm", *words]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=routines.__file__.rpartition("/")[0])
    assert ran.returncode == 1, ran.stderr
    report = pintle.check(routines.without_arm, "CARTESIAN", **QUICK)
    ours, theirs = json.loads(report.to_json()), json.loads(ran.stdout)
    assert (ours["mismatches"], ours["compared"]) == (theirs["mismatches"], theirs["compared"])
    checks = [[check.get("diagnosis") for check in one["subjects"][0]["checks"]] for one in (ours, theirs)]
    assert checks[0] == checks[1] and any(checks[0])


def test_an_exception_keeps_its_traceback():
    def fails(state, connector):
        raise KeyError("mine")

    with pytest.raises(pintle.RoutineError, match="KeyError") as caught:
        pintle.check(fails, "CARTESIAN")
    assert isinstance(caught.value.__cause__, KeyError)
    assert traceback.extract_tb(caught.value.__cause__.__traceback__)[-1].name == "fails"


def test_ctrl_c_passes_through():
    def stopped(state, connector):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pintle.check(stopped, "CARTESIAN")


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (lambda state, connector: ([1.0], [None] * 6), "has 1 items, not 6"),
        (lambda state, connector: ([numpy.random.random(), *[None] * 5], [None] * 6), "gave another answer"),
    ],
)
def test_misbehaviour_is_said_in_words(answer, says):
    with pytest.raises(ValueError, match=says):
        pintle.check(answer, "AXIAL", **QUICK)


def test_what_there_is_not():
    with pytest.raises(ValueError, match="REVOLUTE"):
        pintle.check(routines.cartesian, "REVOLUT")
    with pytest.raises(ValueError, match="there are values, rows"):
        pintle.check(routines.cartesian, "CARTESIAN", offers=["row"])


def test_a_convention_is_undone():
    def in_degrees(state, connector):
        values, rows = routines.cartesian(state, connector)
        return [None if v is None else -v for v in values], rows

    assert not pintle.check(in_degrees, "CARTESIAN", **QUICK).ok
    convention = {"factors": [-1.0] * 3 + [1.0] * 3}
    report = pintle.check(in_degrees, "CARTESIAN", convention=convention, offers=["values"], **QUICK)
    assert report.ok, report


def test_own_states_are_asked_alone(tmp_path):
    states = tmp_path / "run.csv"
    states.write_text("state,node,u1,ur1,ur3\n1,1,0,0.1,0\n1,2,0.2,0,0.1\n2,1,0,0.2,0\n2,2,0.4,0,0.3\n")
    asked = []

    def counted(state, connector):
        asked.append(float(state["b"]["u"][0]))
        return routines.without_arm(state, connector)

    report = pintle.check(counted, "CARTESIAN", offers=["rows"], at=states)
    assert report.codes == {"diagnosis::geometric-term-missing"} and "run.csv" in report.repeat
    assert set(asked) == {0.2, 0.4} and report.compared == 2 * 3 * 14, (asked, report.compared)
    with pytest.raises(ValueError, match="forces that are drawn"):
        pintle.check(counted, "FRICTION HINGE", offers=["criterion"], at=states)


def test_batches_give_the_same_numbers():
    report = pintle.check(routines.stacked, "CARTESIAN", batch=True, **QUICK)
    assert report.ok, report
    one = pintle.check(routines.cartesian, "CARTESIAN", **QUICK)
    assert report.compared == one.compared > 1000
    wrong = pintle.check(lambda s, c: routines.stacked(s, c, sign=-1.0), "CARTESIAN", batch=True, **QUICK)
    assert wrong.verdict == "wrong" and "θa" in wrong.worst.entry


def test_single_precision_is_refused():
    def single(state, connector):
        return tuple(x.astype(numpy.float32) for x in routines.stacked(state, connector))

    with pytest.raises(pintle.RoutineError, match="float32.*convert to float64"):
        pintle.check(single, "CARTESIAN", batch=True)


def test_a_jitted_function_is_mapped():
    calls = []

    def one(state, connector):
        calls.append(state["a"]["x"].shape)
        a, b, initial = state["a"], state["b"], connector["initial"]
        d, nan = b["x"] - a["x"], jnp.full(3, jnp.nan)
        e = a["triad"]
        values = jnp.concatenate([e @ d - initial["a"]["triad"] @ (initial["b"]["x"] - initial["a"]["x"]), nan])
        zero = jnp.zeros((3, 1))
        rows = jnp.concatenate([-e, jnp.cross(e, d[None]), zero, e, jnp.zeros((3, 3)), zero], axis=1)
        return values, jnp.concatenate([rows, jnp.full((3, 14), jnp.nan)])

    report = pintle.check(jax.jit(one), "CARTESIAN", **QUICK)
    assert report.ok and report.compared > 1000, report
    assert calls == [(3,)], calls


def test_the_plugin_shows_matrix_cause_and_repeat(tmp_path):
    file = tmp_path / "test_mine.py"
    file.write_text("import routines\ndef test_row(pintle_check): pintle_check(routines.without_arm, 'CARTESIAN', states=20)\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)]
    folder = routines.__file__.rpartition("/")[0]
    ran = subprocess.run(command, capture_output=True, text=True, env={"PYTHONPATH": folder, "PATH": ""}, cwd=tmp_path)
    assert ran.returncode == 1, ran.stdout
    simplest = "simplest state at which it is wrong: a: u = (0, 0, 0), φ = (0, 0, 0); b: u = (0, 0, 0), φ = (0, 0, 0)"
    for part in ("✗   ✗   ✗", "geometric term missing", simplest, "repeat: pintle.check(routines.without_arm, 'CARTESIAN', states=20)"):
        assert part in ran.stdout, ran.stdout


def test_nothing_starts_at_import():
    program = "import pintle, os; print(len(os.listdir('/proc/self/task')))"
    if not sys.platform.startswith("linux"):
        pytest.skip("threads are counted in /proc")
    count = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env={"OPENBLAS_NUM_THREADS": "1"})
    assert count.stdout == "1\n", count


def test_the_simplest_state_is_one_at_which_it_is_wrong():
    def bent(state, connector):
        given = connectors.right("CARTESIAN")(state, connector)
        if abs(given["values"][1]) > 0.1:
            given["values"][1] *= 1.001
        return given

    report = pintle.check(bent, "CARTESIAN", states=40)
    assert not report.ok
    # One displacement of one node, and no rotation.
    digits = [float(digit) for digit in re.findall(r"[-0-9.]+", report.worst.simplest)]
    assert len(digits) == 12 and sum(digit != 0 for digit in digits) == 1, report.worst.simplest
    assert report.worst.simplest.count("φ = (0, 0, 0)") == 2, report.worst.simplest


@pytest.mark.parametrize("of", ["EULER", "ROTATION"])
def test_another_sheet_that_is_no_farther_is_not_wrong(of):
    # At the default's 250 states: at some of them two sheets are about as far from the state before.
    report = pintle.check(connectors.right(of), of)
    assert report.ok, report
