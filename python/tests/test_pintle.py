"""The package: routines judged as by the command, scenes evaluated as by the command."""

import doctest
import io
import json
import pathlib
import pickle
import shutil
import subprocess
import sys

import numpy as np
import pytest

import pintle

pytest_plugins = ["pytester"]


def cartesian(state, connector):
    """u_i = e_i · (x_b − x_a), less its initial value; e_i are carried by a."""
    a, b, initial = state["a"], state["b"], connector["initial"]
    d = b["x"] - a["x"]
    values, rows = [None] * 6, [None] * 6
    for i, e in enumerate(a["triad"]):
        values[i] = e @ d - initial["a"]["triad"][i] @ initial["b"]["x"]
        rows[i] = [*-e, *np.cross(e, d), 0, *e, 0, 0, 0, 0]
    return values, rows


def without_arm(state, connector):
    values, rows = cartesian(state, connector)
    for row in rows[:3]:
        row[3:6] = 0, 0, 0
    return values, rows


def test_a_right_routine_passes():
    report = pintle.check(cartesian, "CARTESIAN")
    assert report.ok and report and report.verdict == "pass" and report.worst is None
    report.assert_ok()
    assert "no mismatch" in repr(report) and "<html" in report.to_html()


def test_a_wrong_entry_is_named_with_its_cause():
    report = pintle.check(without_arm, "CARTESIAN")
    assert not report.ok and report.verdict == "wrong"
    assert report.worst["entry"].startswith("∂u") and report.worst["units"] > 1e9
    assert "diagnosis::geometric-term-missing" in report.codes
    with pytest.raises(AssertionError, match="geometric term missing"):
        report.assert_ok()


def test_the_command_says_the_same(tmp_path):
    (tmp_path / "mine.py").write_text("import sys\nsys.path.insert(0, %r)\nfrom test_pintle import *\n" % str(pathlib.Path(__file__).parent))
    words = [sys.executable, "-c", "import pintle; pintle.main()", "check", "CARTESIAN"]
    done = subprocess.run([*words, "--python", "mine:without_arm", "--format", "json"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    told = json.loads(done.stdout)["subjects"][0]
    mine = json.loads(pintle.check(without_arm, "CARTESIAN").to_json())["subjects"][0]
    assert len(mine["checks"]) == len(told["checks"]) > 2
    for one, other in zip(mine["checks"], told["checks"]):
        assert (one["verdict"], one["compared"]) == (other["verdict"], other["compared"])


def test_conventions_and_offers():
    def degrees(state, connector):
        values, rows = cartesian(state, connector)
        for row in rows[:3]:
            row[3:6] = [x * np.pi / 180 for x in row[3:6]]
        return values, rows

    assert not pintle.check(degrees, "CARTESIAN").ok
    assert pintle.check(degrees, "CARTESIAN", convention={"column_angles": "deg"}).ok
    rates = lambda state, connector, want: {"values": cartesian(state, connector)[0]}
    assert pintle.check(rates, "CARTESIAN", offers=["values"]).verdict in ("pass", "undecided")
    with pytest.raises(ValueError, match="rowz"):
        pintle.check(cartesian, "CARTESIAN", offers=["rowz"])
    with pytest.raises(ValueError, match="REVOLUTE"):
        pintle.check(cartesian, "REVOLUT")


def test_an_exception_is_the_routines_own():
    def broken(state, connector):
        return [state["a"]["nothing"]], []

    with pytest.raises(KeyError, match="nothing"):
        pintle.check(broken, "CARTESIAN")


def test_jax_routines():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)

    def lengths(q, a, x, initial):
        d = x + q[7:10] - q[:3]
        turned = jax.scipy.linalg.expm(jax.numpy.array([[0, -q[5], q[4]], [q[5], 0, -q[3]], [-q[4], q[3], 0]])) @ a.T
        return turned.T @ d - initial

    jacobian = jax.jit(jax.jacfwd(lengths))

    def routine(state, connector):
        first = connector["initial"]
        given = state["a"]["triad"], state["b"]["x"] - state["a"]["x"], first["a"]["triad"] @ first["b"]["x"]
        still = np.zeros(14)
        return [*lengths(still, *given), None, None, None], [*jacobian(still, *given), None, None, None]

    assert pintle.check(routine, "CARTESIAN", states=20, near_singular_states=0, wide_states=5, histories=4).ok


def test_the_plugin_fails_readably(pytester):
    pytester.makepyfile(
        """
        from test_pintle import cartesian, without_arm
        def test_right(pintle_check):
            assert pintle_check(cartesian, "CARTESIAN").ok
        def test_wrong(pintle_check):
            pintle_check(without_arm, "CARTESIAN")
        """
    )
    pytester.syspathinsert(str(pathlib.Path(__file__).parent))
    result = pytester.runpytest("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*geometric term missing*"])


def test_scenes_give_what_the_command_prints():
    scene = pickle.loads(pickle.dumps(pintle.Scene("gallery:slider_crank")))
    names = [number for number, _, _ in scene.connectors]
    found = scene.evaluate(outputs=["CU", "RES"], order=2)
    assert found["jacobian"].shape == (25, len(names), 6, 14) and found["hessian"].shape[-2:] == (14, 14)
    words = [sys.executable, "-c", "import pintle; pintle.main()", "eval", "gallery:slider_crank", "--outputs", "CU,RES", "--format", "csv"]
    table = np.genfromtxt(io.StringIO(subprocess.run(words, capture_output=True, text=True, check=True).stdout), delimiter=",", names=True, dtype=None, encoding="utf-8")
    components = ["u1", "u2", "u3", "ur1", "ur2", "ur3"]
    compared = 0
    for line in table:
        if line["kind"] != "connector" or str(line["label"]) not in names:
            continue
        at = int(line["state"]), names.index(str(line["label"])), components.index(line["component"])
        for name in ("CU", "RES"):
            if not np.isnan(line[name]):
                assert found[name][at] == line[name]
                compared += 1
    assert compared >= 150
    assert pintle.catalog()["REVOLUTE"][3:] == ["available", "constrained", "constrained"]
    assert pintle.audit(scene).ok
    with pytest.raises(ValueError, match="no_such"):
        pintle.Scene("no_such.inp")


def test_the_page_shows_what_python_prints():
    page = pathlib.Path(__file__).parents[2] / "docs/how-to/python.md"
    failed, tried = doctest.testfile(str(page), module_relative=False, optionflags=doctest.ELLIPSIS)
    assert failed == 0 and tried >= 8


def test_the_command_loads_libraries_by_this_python(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no cc")
    words = [sys.executable, "-c", "import pintle; pintle.main()", "check"]
    header = subprocess.run([*words, "--header"], capture_output=True, text=True, check=True).stdout
    (tmp_path / "pintle_element.h").write_text(header)
    source = pathlib.Path(__file__).parents[2] / "examples/elements/cartesian.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-I.", "-o", "it.so", str(source)], cwd=tmp_path, check=True)
    done = subprocess.run([*words, "CARTESIAN", "--library", "./it.so"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "no mismatch" in done.stdout, done.stderr
