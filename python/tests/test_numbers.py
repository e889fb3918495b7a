"""Scenes and rows: against closed form, against the check, in every kind of array."""

import itertools
import json
import os
import pathlib
import pickle
import subprocess
import sys
import tracemalloc

import jax
import jax.numpy as jnp
import numpy
import pytest
import scipy.io
from hypothesis import given, settings

import pintle
import pintle.jax
from pintle import strategies

jax.config.update("jax_enable_x64", True)
QUICK = {"states": 30, "near_singular_states": 0, "wide_states": 5, "histories": 0}


def test_the_slider_of_the_crank_at_ninety_degrees():
    scene = pintle.Scene("gallery:slider_crank")
    slide = [one["element"] for one in scene.connectors].index("106")
    assert scene.connectors[slide] == {"element": "106", "type": "TRANSLATOR", "nodes": ["7", "6"]}
    numbers = scene.evaluate(outputs=("CU", "RES", "CV"))
    assert numbers["CU"].shape == (25, 6, 6) and numbers["jacobian"].shape == (25, 6, 6, 14)
    # A crank of 1 and a rod of 3 whose offset is nothing: the README shows the same number.
    assert abs(numbers["CU"][6, slide, 0] + 0.2343145751) < 1e-10
    assert numbers["time"][6] == 0.25
    assert list(numbers["jacobian"][6, slide, 0]) == [-1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]
    assert numpy.isnan(numbers["RES"][6, slide, 0]) and numbers["RES"][6, slide, 1] == 0
    assert scene.evaluate(order=2)["hessian"].shape == (25, 6, 6, 14, 14)
    assert "jacobian" not in scene.evaluate(order=0)


def test_a_pickled_scene_is_the_same_to_the_last_bit():
    scene = pintle.Scene("gallery:seat_belt")
    ours, theirs = (one.evaluate(order=2) for one in (scene, pickle.loads(pickle.dumps(scene))))
    assert ours.keys() == theirs.keys() and len(ours) == 6
    for name in ours:
        assert ours[name].tobytes() == theirs[name].tobytes(), name


@pytest.mark.parametrize("name", ["slider_crank", "seat_belt", "parallel_cranks", "revolute_mpc"])
def test_the_sparse_jacobian_is_that_of_the_command(name, tmp_path):
    scene = pintle.Scene(f"gallery:{name}")
    found = scene.jacobian()
    states = len(found.data)
    assert found.shape == (len(found.rows), len(found.columns)) and len(found.indices) == found.data.shape[1] > 10
    program = os.environ.get("PINTLE_PROGRAM") or str(pathlib.Path(sys.executable).parent / "pintle")
    compared = 0
    for k in {0, states // 2, states - 1}:
        path = tmp_path / f"{k}.mtx"
        words = [program, "eval", f"gallery:{name}", "--show", str(k), "--outputs", "RES", "--jacobian", path]
        subprocess.run(words, capture_output=True, check=True)
        expected, matrix = scipy.io.mmread(path).toarray(), found.matrix(k)
        assert matrix.shape == expected.shape and numpy.array_equal(matrix.toarray(), expected)
        named = [line[2:].strip().split(": ", 1)[1] for line in path.read_text().splitlines() if line.startswith(("% row ", "% column "))]
        assert named == found.rows + [f"{node} {number}" for node, number in found.columns]
        compared += matrix.nnz
    assert compared > 20, compared


def test_the_sparse_jacobian_of_arrays_goes_where_it_is_told():
    scene, arrays = pintle.Scene("gallery:slider_crank"), _crank(9)
    turned = [{"nodes": {n + 1: {"displacement": arrays["u"][k, n].tolist(), "rotation": arrays["rotation_vector"][k, n].tolist()} for n in range(7)}} for k in range(9)]
    found, listed = scene.jacobian(arrays), scene.jacobian(turned)
    assert numpy.array_equal(found.data, listed.data) and found.data.shape[0] == 9
    # A matrix is its own: what is done to one changes no other.
    before = found.matrix(4).toarray()
    found.matrix(3).eliminate_zeros()
    assert numpy.array_equal(found.matrix(4).toarray(), before)
    out = numpy.full(found.data.shape, numpy.nan)
    assert scene.jacobian(arrays, out=out).data is out and numpy.array_equal(out, found.data)
    with pytest.raises(ValueError, match="not .9, "):
        scene.jacobian(arrays, out=out[1:])
    # Rows as `evaluate` has them, where a row has no more than its own columns.
    rows, dofs = scene.evaluate(arrays, outputs=["RES"])["jacobian"], "123456"
    elements = {f"{one['type']} {one['element']}": (c, one["nodes"]) for c, one in enumerate(scene.connectors)}
    compared, dense = 0, found.matrix(5).toarray()
    for row, name in enumerate(found.rows):
        title, _, component = name.rpartition(" ")
        c, nodes = elements[title]
        k = ["u1", "u2", "u3", "ur1", "ur2", "ur3"].index(component)
        for column, (node, number) in enumerate(found.columns):
            ends = [end for end in (0, 1) if nodes[end] == node]
            whole = sum(rows[5, c, k, 7 * end + dofs.index(str(number))] for end in ends)
            assert abs(dense[row, column] - whole) < 1e-15, (name, node, number)
            compared += 1
    assert compared > 400, compared


def test_entries_beside_a_singular_point_are_a_warning():
    deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nLINK\n"
    with pytest.warns(RuntimeWarning, match="1 value needs care; the first: state 0, LINK 7"):
        pintle.Scene(deck).jacobian([{"nodes": {2: {"displacement": [-1.0, 0.0, 0.0]}}}])


def _crank(states=25):
    """The states of the slider-crank as arrays."""
    names = [str(n) for n in range(1, 8)]
    time = numpy.linspace(0.0, 1.0, states)
    u, turned = numpy.zeros((states, 7, 3)), numpy.zeros((states, 7, 3))
    u[:, 5, 0] = 0.1 * numpy.sin(time)
    turned[:, 1] = time[:, None] * [0.3, -7.0, 2.0]
    return {"node": numpy.array(names), "time": time, "u": u, "rotation_vector": turned}


def test_arrays_of_states_are_states(tmp_path):
    scene = pintle.Scene("gallery:slider_crank")
    arrays = _crank()
    nodes = lambda s: {
        n: {"displacement": arrays["u"][s, i], "rotation": arrays["rotation_vector"][s, i]} for i, n in enumerate(arrays["node"])
    }
    states = [{"time": t, "nodes": nodes(s)} for s, t in enumerate(arrays["time"])]
    numpy.savez(tmp_path / "run.npz", **arrays)
    strided = {name: numpy.asfortranarray(one) for name, one in arrays.items()}
    for outputs in (["CU", "RES", "TURNS"], ["CU", "CTF", "CEF"], ["CV", "CA"]):
        known = scene.evaluate(states, outputs)
        for form in (arrays, strided, numpy.load(tmp_path / "run.npz")):
            found = scene.evaluate(form, outputs)
            assert found.keys() == known.keys()
            for name in known:
                assert found[name].tobytes() == known[name].tobytes(), name
    # A walk of pintle eval gives the same to rounding.
    command = [os.path.join(os.path.dirname(sys.executable), "pintle"), "eval", "gallery:slider_crank", "--outputs", "CU", "--format", "json"]
    told = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    ours = scene.evaluate(outputs=["CU"])["CU"]
    compared = 0
    for s, state in enumerate(told["scenes"][0]["states"]):
        for c, connector in enumerate(state["connectors"]):
            for name, component in connector["components"].items():
                k = ["u1", "u2", "u3", "ur1", "ur2", "ur3"].index(name)
                assert abs(component["CU"] - ours[s, c, k]) < 1e-14
                compared += 1
    assert compared > 500


def test_arrays_are_written_where_they_are_wanted():
    scene = pintle.Scene("gallery:slider_crank")
    arrays = _crank(300)
    known = scene.evaluate(arrays, ["CU"])
    out = {"CU": numpy.full((300, 6, 6), 7.0), "jacobian": numpy.full((300, 6, 6, 14), 7.0)}
    found = scene.evaluate(arrays, ["CU"], out=out)
    assert found["CU"] is out["CU"] and found["jacobian"] is out["jacobian"]
    assert all(out[name].tobytes() == known[name].tobytes() for name in out)
    locked = {"CU": numpy.zeros((300, 6, 6))}
    locked["CU"].flags.writeable = False
    for wrong, says in (
        ({"CU": numpy.zeros((300, 6, 5))}, "out.*CU.*has shape"),
        ({"CU": numpy.zeros((300, 6, 6), numpy.float32)}, "no NumPy array of float64"),
        ({"CU": numpy.zeros((300, 6, 6), order="F")}, "in C order"),
        (locked, "cannot be written"),
        ({"CX": numpy.zeros(3)}, "not asked for"),
    ):
        with pytest.raises((ValueError, TypeError), match=says):
            scene.evaluate(arrays, ["CU"], out=wrong)


def test_arrays_that_cannot_be_are_refused_in_words():
    scene = pintle.Scene("gallery:slider_crank")
    nan, far, quaternion = _crank(), _crank(), _crank()
    nan["u"][3, 2, 1] = nan["u"][4, 2, 1] = numpy.nan
    far["rotation_vector"][0, 0] = 1e9
    del quaternion["rotation_vector"]
    quaternion["quaternion"] = numpy.zeros((25, 7, 4))
    for wrong, says in (
        ({**_crank(), "node": ["1"]}, "u has shape"),
        ({**_crank(), "node": [1, 2, 3, 4, 5, 6, 99]}, "no node 99"),
        ({**_crank(), "node": [1, 2, 3, 4, 5, 6, 6]}, "node 6 occurs twice"),
        ({**_crank(), "time": numpy.zeros(3)}, "states"),
        ({**_crank(), "v": numpy.zeros(3)}, "no array v of states"),
        ({"u": numpy.zeros((2, 1, 3))}, "no array node"),
        (nan, "u of node 3 at state 3 .*no finite number; so are 1 others"),
        (far, "a rotation of"),
        (quaternion, "a quaternion of norm 0"),
        ({**_crank(), "quaternion": numpy.zeros((25, 7, 4))}, "both rotation_vector and quaternion"),
        ({**_crank(), "u": numpy.zeros((25, 7, 3), numpy.float32)}, "dtype float32"),
        ({**_crank(), "u": numpy.zeros((25, 7, 3), numpy.float16)}, "dtype float16"),
        ({**_crank(), "u": numpy.full((25, 7, 3), "a")}, "numbers are needed"),
    ):
        with pytest.raises((ValueError, TypeError), match=says):
            scene.evaluate(wrong)
    none = scene.evaluate({"node": [], "time": numpy.zeros(0)}, ["CU"])
    assert none["CU"].shape == (0, 6, 6)


DECK = """*NODE
1, 0, 0, 0
2, 1, 0, 0
*ELEMENT, TYPE={element}, ELSET=E
1, 1, 2
*CONNECTOR SECTION, ELSET=E
{connection}
"""


@pytest.mark.parametrize(
    "element, connection, has, lacks",
    (
        ("CONN3D2", "JOIN", {"u": [1, 2, 3]}, "no rotational degrees of freedom"),
        ("CONN2D2", "WELD", {"u": [1, 2, 0], "rotation_vector": [0, 0, 1]}, "leaves the plane"),
    ),
)
def test_nodes_move_only_by_degrees_of_freedom_that_they_have(tmp_path, element, connection, has, lacks):
    deck = tmp_path / "deck.inp"
    deck.write_text(DECK.format(element=element, connection=connection))
    scene = pintle.Scene(deck)

    def moved(**numbers):
        zeros = {"u": 3, "rotation_vector": 3, "angular_velocity": 3, "acceleration": 3, "quaternion": 4}
        arrays = {name: numpy.zeros((4, 1, zeros[name])) for name in numbers}
        for name, of in numbers.items():
            arrays[name][2:, 0] = of
            if name == "quaternion":
                arrays[name][:2, 0] = [1, 0, 0, 0]
        return {"node": [2], **arrays}

    assert numpy.isfinite(scene.evaluate(moved(**has), ["CP"])["CP"]).any()
    assert numpy.isfinite(scene.evaluate(moved(quaternion=[1, 0, 0, 0]), ["CP"])["CP"]).any()
    wrong = [{"rotation_vector": [0, 1e-9, 0]}, {"angular_velocity": [1, 0, 0]}, {"quaternion": [0.6, 0.8, 0, 0]}]
    if lacks == "leaves the plane":
        wrong += [{"u": [0, 0, 1]}, {"acceleration": [0, 0, 1]}]
    for numbers in wrong:
        [name] = numbers
        with pytest.raises(ValueError, match=f"{name} of node 2 at state 2 .*{lacks}.*; so are 1 others"):
            scene.evaluate(moved(**numbers))
        with pytest.raises(ValueError, match=lacks):
            scene.jacobian(moved(**numbers))


def test_states_of_ones_own_and_what_is_wrong_with_them(tmp_path):
    scene = pintle.Scene("gallery:slider_crank")
    moved = [{"time": 0.5, "nodes": {6: {"displacement": numpy.array([0.1, 0, 0])}}}]
    assert scene.evaluate(moved)["CU"][0, 5, 0] == 0.1
    file = tmp_path / "run.csv"
    file.write_text("state,time,node,u1\n0,0.5,6,0.1\n")
    assert scene.evaluate(file)["CU"][0, 5, 0] == 0.1
    for states, says in (([{"nodes": {99: {}}}], "99"), (tmp_path / "none.csv", "none.csv: cannot be read")):
        with pytest.raises(ValueError, match=says):
            scene.evaluate(states)
    for options, says in (({"outputs": ["CUX"]}, "CUX"), ({"outputs": ["NF"]}, "eval --format json"), ({"order": 3}, "order is 3")):
        with pytest.raises(ValueError, match=says):
            scene.evaluate(**options)
    with pytest.raises(ValueError, match="gallery has no scene"):
        pintle.Scene("gallery:slider")


def test_an_audit_and_the_catalogue():
    report = pintle.audit("gallery:slider_crank", model_only=True)
    assert report.ok, report
    revolute = pintle.catalog()["REVOLUTE"]
    assert (revolute["available"], revolute["constrained"]) == (["ur1"], ["ur2", "ur3"])
    assert len(pintle.catalog()) > 25


@pytest.mark.parametrize("name", ["REVOLUTE", "TRANSLATOR", "CARTESIAN CARDAN", "HINGE", "AXIAL", "UJOINT"])
def test_rows_pass_the_check(name):
    def routine(state, connector):
        a, b, initial = state["a"], state["b"], connector["initial"]
        values, rows = pintle.rows(name, a["x"], a["triad"], b["x"], b["triad"])
        first = (initial[end][key][None] for end, key in (("a", "x"), ("a", "triad"), ("b", "x"), ("b", "triad")))
        free = [one is not None and one["kind"] == "free" for one in connector["components"]]
        values[:, free] -= pintle.rows(name, *first)[0][:, free]
        return values, rows

    report = pintle.check(routine, name, batch=True, convention={"turns": "principal"}, offers=["rows"], **QUICK)
    assert report.verdict == "pass" and report.compared > 300, report


def some(count):
    random = numpy.random.default_rng(7)
    triad = numpy.linalg.qr(random.normal(size=(2, count, 3, 3)))[0]
    triad *= numpy.linalg.det(triad)[..., None, None]
    return random.normal(size=(count, 3)), triad[0], random.normal(size=(count, 3)), triad[1]


def test_every_kind_of_array_gives_the_same():
    x_a, triad_a, x_b, triad_b = some(131)
    values, rows = pintle.rows("CARTESIAN CARDAN", x_a, triad_a, x_b, triad_b)
    assert numpy.isfinite(values).all() and rows.shape == (131, 6, 14)
    strided = [numpy.repeat(x, 2, axis=0)[::2] for x in (x_a, triad_a, x_b, triad_b)]
    fortran = [numpy.asfortranarray(x) for x in strided]
    for one in strided:
        one.flags.writeable = False
    for given in (strided, fortran):
        for ours, theirs in zip(pintle.rows("CARTESIAN CARDAN", *given), (values, rows)):
            assert ours.tobytes() == theirs.tobytes()
    out = numpy.zeros((131, 6)), numpy.zeros((131, 6, 14))
    assert pintle.rows("CARTESIAN CARDAN", x_a, triad_a, x_b, triad_b, out=out)[0] is out[0]
    assert out[1].tobytes() == rows.tobytes()
    assert pintle.rows("CARTESIAN CARDAN", *(x[:0] for x in strided))[1].shape == (0, 6, 14)
    for s in (0, 3, 130):
        alone = pintle.rows("CARTESIAN CARDAN", *(x[s : s + 1] for x in strided))
        assert alone[0].tobytes() == values[s].tobytes()


def turned(q):
    w, x, y, z = q.T
    return numpy.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    ).transpose(2, 0, 1)


@pytest.mark.parametrize("name", ["REVOLUTE", "CARTESIAN CARDAN", "ROTATION", "EULER", "SLIDE-PLANE"])
def test_rotations_and_columns_of_every_form(name):
    random = numpy.random.default_rng(5)
    n, compared = 70, 0
    phi = random.normal(size=(n, 3)) / 2
    angle = numpy.linalg.norm(phi, axis=1)[:, None]
    q = numpy.concatenate([numpy.cos(angle / 2), numpy.sin(angle / 2) / angle * phi], axis=1)
    _, still, first = (numpy.array(part) for part in pintle.initial(name))
    directions = (turned(q) @ first.T).transpose(0, 2, 1)
    x_a, x_b, still = random.normal(size=(1, 3)), random.normal(size=(n, 3)), still[None]
    values, rows = pintle.rows(name, x_a, still, x_b, directions)
    has = numpy.flatnonzero(numpy.isfinite(values[0]))
    m, twelve = len(has), numpy.r_[0:6, 7:13]
    expected = rows[:, has][:, :, twelve]
    indptr, indices = pintle.pattern(name)
    sparse = numpy.concatenate([expected[:, i, indices[indptr[i] : indptr[i + 1]]] for i in range(m)], axis=1)
    forms = {
        14: rows[:, has], 12: expected, 9: expected[:, :, 3:], "sparse": sparse, (11, 0): expected[:, :, [11, 0]],
    }
    for given in (directions, q, 3 * q, phi):
        for columns, wanted in forms.items():
            asked = list(columns) if isinstance(columns, tuple) else columns
            found = pintle.rows(name, x_a, still, x_b, given, columns=asked)
            numpy.testing.assert_allclose(found[0], values[:, has], rtol=0, atol=1e-12)
            numpy.testing.assert_allclose(found[1], wanted, rtol=1e-11, atol=1e-11)
            compared += found[1].size
    assert compared > 10_000
    assert numpy.count_nonzero(expected) <= sparse.size
    with pytest.raises(ValueError, match="columns are 14"):
        pintle.rows(name, x_a, still, x_b, q, columns=13)
    with pytest.raises(ValueError, match="none of the twelve"):
        pintle.rows(name, x_a, still, x_b, q, columns=[12])


@pytest.mark.parametrize("name", ["REVOLUTE", "CARTESIAN CARDAN", "ROTATION", "EULER", "SLIDE-PLANE", "LINK", "BUSHING"])
def test_products_with_second_derivatives_are_rates_of_rows(name):
    random = numpy.random.default_rng(11)
    n, h = 40, 1e-5
    x_a, triad_a, x_b, triad_b = some(n)
    v = random.normal(size=(4, n, 3))
    forces = random.normal(size=(n, 6))

    def rows(t):
        def moved(x, triad, velocity, spin):
            angle = t * numpy.linalg.norm(spin, axis=1)[:, None]
            q = numpy.concatenate([numpy.cos(angle / 2), t * numpy.sinc(angle / (2 * numpy.pi)) / 2 * spin], axis=1)
            return x + t * velocity, (turned(q) @ triad.transpose(0, 2, 1)).transpose(0, 2, 1)

        a, b = moved(x_a, triad_a, *v[:2]), moved(x_b, triad_b, *v[2:])
        return pintle.rows(name, *a, *b, columns=12)[1]

    rate = (rows(h) - rows(-h)) / (2 * h)
    whole = v.transpose(1, 0, 2).reshape(n, 12)
    has = numpy.flatnonzero(numpy.isfinite(pintle.rows(name, x_a, triad_a, x_b, triad_b)[0][0]))
    bias = pintle.bias(name, x_a, triad_a, x_b, triad_b, *v)
    assert numpy.isnan(numpy.delete(bias, has, axis=1)).all()
    size = 1 + numpy.abs(rate).max(axis=2)
    assert (numpy.abs(bias[:, has] - numpy.einsum("nmj,nj->nm", rate, whole)) < 1e-6 * size**2).all()
    stiffness = pintle.geometric_stiffness(name, x_a, triad_a, x_b, triad_b, forces)
    numpy.testing.assert_allclose(stiffness, stiffness.transpose(0, 2, 1), rtol=1e-12, atol=1e-12 * size.max() ** 2)
    quadratic = numpy.einsum("nij,ni,nj->n", stiffness, whole, whole)
    numpy.testing.assert_allclose(quadratic, (forces[:, has] * bias[:, has]).sum(axis=1), rtol=1e-10, atol=1e-10 * size.max() ** 2)
    along = pintle.geometric_stiffness(name, x_a, triad_a, x_b, triad_b, forces, along=v)
    product = numpy.einsum("nij,nj->ni", stiffness, whole)
    numpy.testing.assert_allclose(along, product, rtol=1e-12, atol=1e-12 * size.max() ** 2)
    with pytest.raises(ValueError, match="along has 3 arrays"):
        pintle.geometric_stiffness(name, x_a, triad_a, x_b, triad_b, forces, along=v[:3])
    alone = pintle.geometric_stiffness(name, x_a[:1], triad_a[:1], x_b, triad_b, forces[0])
    assert alone.shape == (n, 12, 12)
    with pytest.raises(ValueError, match="forces has shape"):
        pintle.geometric_stiffness(name, x_a, triad_a, x_b, triad_b, forces[:, :5])
    with pytest.raises(ValueError, match="v_b 39"):
        pintle.bias(name, x_a, triad_a, x_b, triad_b, v[0], v[1], v[2][1:], v[3])


@pytest.mark.parametrize("name", ["REVOLUTE", "CARTESIAN CARDAN", "ROTATION", "EULER", "SLIDE-PLANE", "BUSHING", "TRANSLATOR", "LINK"])
def test_chosen_components_are_those_of_all_bit_for_bit(name):
    n, compared = 21, 0
    x_a, triad_a, x_b, triad_b = given = some(n)
    random = numpy.random.default_rng(13)
    v, forces = random.normal(size=(4, n, 3)), random.normal(size=(n, 6))
    values, rows = pintle.rows(name, *given)
    bias = pintle.bias(name, *given, *v)
    has = [int(k) + 1 for k in numpy.flatnonzero(numpy.isfinite(values[0]))]
    indptr, indices = pintle.pattern(name)
    sparse = pintle.rows(name, *given, columns="sparse")[1]
    for count in range(1, len(has) + 1):
        for chosen in itertools.combinations(has, count):
            at = [k - 1 for k in chosen]
            places = [has.index(k) for k in chosen]
            ranges = [numpy.r_[indptr[i] : indptr[i + 1]] for i in places]
            stiffness = numpy.zeros((n, 6))
            stiffness[:, at] = forces[:, at]
            stiffness = pintle.geometric_stiffness(name, *given, stiffness)
            found_pattern = pintle.pattern(name, components=chosen)
            pairs = [
                (pintle.rows(name, *given, components=list(chosen))[0], values[:, at]),
                (pintle.rows(name, *given, components=list(chosen))[1], rows[:, at]),
                (pintle.rows(name, *given, components=chosen, columns=9)[1], rows[:, at][:, :, [3, 4, 5, 7, 8, 9, 10, 11, 12]]),
                (pintle.rows(name, *given, components=chosen, columns="sparse")[1], sparse[:, numpy.concatenate(ranges)]),
                (found_pattern[0], numpy.cumsum([0, *map(len, ranges)])),
                (found_pattern[1], numpy.concatenate([indices[of] for of in ranges])),
                (pintle.bias(name, *given, *v, components=chosen), bias[:, at]),
                # A zero times λ may be −0.
                (pintle.geometric_stiffness(name, *given, forces[:, at], components=chosen) + 0.0, stiffness + 0.0),
            ]
            for i, (ours, theirs) in enumerate(pairs):
                assert ours.shape == theirs.shape and ours.tobytes() == theirs.tobytes(), (chosen, i)
                compared += ours.size
    assert compared > 3000, compared


def test_components_that_there_are_not():
    given = some(3)
    there = r"; REVOLUTE has 4 \(ur1\), 5 \(ur2\), 6 \(ur3\)"
    for chosen, says in (
        ([1], r"components \[1\]: there is no 1" + there),
        ([4, 7], "there is no 7" + there),
        ([0], "there is no 0" + there),
        ([-1], "there is no -1" + there),
        ([], "none is chosen" + there),
        ([6, 4], "each comes once, in ascending order" + there),
        ([5, 5], "each comes once, in ascending order" + there),
    ):
        for call in (pintle.rows, pintle.bias, pintle.geometric_stiffness):
            more = {pintle.rows: (), pintle.bias: [numpy.zeros((1, 3))] * 4, pintle.geometric_stiffness: [numpy.zeros(3)]}[call]
            with pytest.raises(ValueError, match=says):
                call("REVOLUTE", *given, *more, components=chosen)
        with pytest.raises(ValueError, match=says):
            pintle.pattern("REVOLUTE", components=chosen)
    with pytest.raises(TypeError, match="'str' object"):
        pintle.rows("REVOLUTE", *given, components=["ur1"])
    with pytest.raises(ValueError, match=r"forces has shape \(6,\), not \(3, 2\) or \(2,\)"):
        pintle.geometric_stiffness("REVOLUTE", *given, numpy.zeros(6), components=[4, 5])
    # The others of a type with material flow.
    ours, theirs = pintle.rows("RETRACTOR", *given, components=[1, 2, 3]), pintle.rows("JOIN", *given, components=[1, 2, 3])
    assert ours[1].tobytes() == theirs[1].tobytes() and ours[1].shape == (3, 3, 14)


def test_products_are_written_where_they_are_wanted():
    n = 3000
    given, v = some(n), numpy.random.default_rng(17).normal(size=(4, n, 3))
    forces = numpy.linspace(-1.0, 1.0, 6)
    for name, shape in (("REVOLUTE", (n, 6)), ("CARTESIAN CARDAN", (n, 6))):
        known, matrices = pintle.bias(name, *given, *v), pintle.geometric_stiffness(name, *given, forces)
        for out in (numpy.full(shape, 7.0), numpy.full((2 * n, 6), 7.0)[::2], numpy.full(shape, 7.0, order="F")):
            assert pintle.bias(name, *given, *v, out=out) is out and out.tobytes() == known.tobytes()
        out = numpy.full((n, 12, 12), 7.0)
        assert pintle.geometric_stiffness(name, *given, forces, out=out) is out and out.tobytes() == matrices.tobytes()
    # Nothing of that size is made besides.
    few = numpy.empty((n, 6))
    for call, whole in (
        (lambda: pintle.bias("CARTESIAN CARDAN", *given, *v, out=few), few),
        (lambda: pintle.bias("CARTESIAN CARDAN", *given, *v, components=[1, 5], out=few.reshape(-1)[: 2 * n].reshape(n, 2)), few[: n // 3]),
        (lambda: pintle.geometric_stiffness("CARTESIAN CARDAN", *given, forces, out=out), out),
    ):
        tracemalloc.start()
        call()
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < whole.nbytes // 2, peak
    locked, half = numpy.zeros((n, 12, 12)), numpy.zeros((n, 12, 12), numpy.float32)
    locked.flags.writeable = False
    for wrong, error, says in (
        (half, TypeError, "out has dtype float32, and float64 is needed"),
        (locked, ValueError, "out cannot be written: out is read-only"),
        (numpy.zeros((n, 144)), ValueError, rf"out has shape \({n}, 144\), not \({n}, 12, 12\) in C order"),
        (numpy.zeros((n, 12, 12), order="F"), ValueError, "in C order"),
        ([0.0], TypeError, "out is no NumPy array"),
    ):
        with pytest.raises(error, match=says):
            pintle.geometric_stiffness("REVOLUTE", *given, forces, out=wrong)
    for wrong, more, says in (
        (numpy.zeros((n, 5)), {}, rf"out has shape \({n}, 5\), not \({n}, 6\)"),
        (numpy.zeros((n, 2), order="F"), {"components": [4, 6]}, rf"not \({n}, 2\) in C order"),
    ):
        with pytest.raises(ValueError, match=says):
            pintle.bias("REVOLUTE", *given, *v, **more, out=wrong)
    both = numpy.zeros((n, 6))
    with pytest.raises(ValueError, match="out cannot be written"):
        pintle.bias("CARTESIAN CARDAN", both[:, :3], *given[1:], *v, out=both)


def test_what_is_no_such_array():
    x_a, triad_a, x_b, triad_b = some(4)
    cases = [
        ((x_a.astype(numpy.float32), triad_a, x_b, triad_b), TypeError, r"x_a has dtype float32.*astype\(numpy.float64\)"),
        ((x_a, triad_a[:, :2], x_b, triad_b), ValueError, r"triad_a has shape \[4, 2, 3\], not \(n, 3, 3\) or \(n, 4\)"),
        ((x_a, triad_a, x_b[:3], triad_b), ValueError, "states: x_a 4, triad_a 4, x_b 3, triad_b 4"),
        (([[0, 0, 0]], triad_a, x_b, triad_b), TypeError, "x_a is no NumPy array"),
    ]
    for given, error, says in cases:
        with pytest.raises(error, match=says):
            pintle.rows("CARTESIAN", *given)
    with pytest.raises(ValueError, match=r"out\[0\] has shape \(3, 6\), not \(4, 6\)"):
        pintle.rows("CARTESIAN", x_a, triad_a, x_b, triad_b, out=(numpy.zeros((3, 6)), numpy.zeros((4, 6, 14))))
    still = numpy.zeros((4, 6))
    still.flags.writeable = False
    with pytest.raises(ValueError, match="out cannot be written"):
        pintle.rows("CARTESIAN", x_a, triad_a, x_b, triad_b, out=(still, numpy.zeros((4, 6, 14))))
    both = numpy.zeros((4, 6, 14))
    with pytest.raises(ValueError, match="cannot be written"):
        pintle.rows("CARTESIAN CARDAN", both[:, 0, :3], triad_a, x_b, triad_b, out=(numpy.zeros((4, 6)), both))
    with pytest.raises(ValueError, match="evaluate it by itself"):
        pintle.rows("SLIPRING", x_a, triad_a, x_b, triad_b)


def test_jax_differentiates_by_the_rows():
    x_a, triad_a, x_b, triad_b = some(5)
    values = pintle.jax.rows("CARTESIAN")
    assert values.components == ("u1", "u2", "u3")

    def traced(x_a, triad_a, x_b, triad_b):
        return triad_a @ (x_b - x_a)

    def turned(of, theta, s):
        skew = jnp.array([[0, -theta[2], theta[1]], [theta[2], 0, -theta[0]], [-theta[1], theta[0], 0]])
        return of(x_a[s], triad_a[s] @ jax.scipy.linalg.expm(skew).T, x_b[s], triad_b[s])

    compared = 0
    for s in range(5):
        for of in (jax.jacfwd, jax.jacrev):
            ours, theirs = (of(lambda theta, f=f: turned(f, theta, s))(jnp.zeros(3)) for f in (values, traced))
            assert jnp.abs(ours - theirs).max() < 1e-14
            compared += ours.size
    assert compared == 90
    together = jax.jit(jax.vmap(values))(x_a, triad_a, x_b, triad_b)
    assert jnp.abs(together - jax.vmap(traced)(x_a, triad_a, x_b, triad_b)).max() < 1e-14
    slope = jax.grad(lambda x: values(x_a[0], triad_a[0], x, triad_b[0])[0])(x_b[0])
    assert jnp.abs(slope - triad_a[0, 0]).max() < 1e-15
    with pytest.raises(TypeError, match="jax_enable_x64"):
        values(*(jnp.asarray(x[0], dtype=jnp.float32) for x in (x_a, triad_a, x_b, triad_b)))


@settings(max_examples=20, deadline=None)
@given(strategies.states("REVOLUTE", history=True))
def test_drawn_states_are_states(drawn):
    state, connector = drawn
    assert connector["type"] == "REVOLUTE"
    for end in "ab":
        triad = state[end]["triad"]
        assert numpy.abs(triad @ triad.T - numpy.eye(3)).max() < 1e-14
    assert "values" in state["previous"]


def test_other_threads_run_while_rust_computes():
    program = """
import threading, time, pintle
scene, turns, done = pintle.Scene("gallery:slider_crank"), [], threading.Event()
def turn():
    while not done.is_set():
        turns.append(1); time.sleep(0.005)
thread = threading.Thread(target=turn); thread.start()
pintle.audit(scene); before = len(turns); done.set(); thread.join()
print(before)
"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert int(ran.stdout) > 10, ran


def test_stubs_name_what_there_is():
    import ast
    import inspect

    compared = 0
    folder = pintle.__file__.rpartition("/")[0]
    for module, stub in ((pintle, "__init__"), (pintle.jax, "jax"), (strategies, "strategies")):
        for item in ast.parse(open(f"{folder}/{stub}.pyi").read()).body:
            if not isinstance(item, ast.FunctionDef):
                continue
            given = item.args
            every = (*given.posonlyargs, *given.args, given.vararg, *given.kwonlyargs)
            names = [one.arg for one in every if one is not None]
            assert names == list(inspect.signature(getattr(module, item.name)).parameters), item.name
            compared += 1
    assert compared == 15 and all(hasattr(pintle, name) for name in pintle.__all__)
