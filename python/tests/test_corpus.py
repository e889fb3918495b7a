"""A corpus of wrong routines by another hand: each is found, its cause is told, and every door says the same of it."""

import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys

import pytest

CORPUS = pathlib.Path(__file__).parent / "corpus"
sys.path.insert(0, str(CORPUS))

import connectors
import constraints
import expected
import frictions
import heldout

import pintle

FEW = {"states": 24, "near_singular_states": 6, "wide_states": 8, "histories": 6}
WORDS = [f"--{key.replace('_', '-')}={value}" for key, value in FEW.items()]
OFFERS = ("values", "rows", "second_derivatives", "rates", "accelerations", "nodal_forces", "geometric_stiffness")


def said(report):
    """Of each check its quantity, judge, verdict, and what is told of the cause."""
    found = []
    for check in report["subjects"][0]["checks"]:
        causes = (check.get("diagnosis") or {}).get("causes", [])
        sentences = [f"{cause['sentence']} [{cause['code']}]" for cause in causes]
        found.append([check["quantity"], check["against"], check["verdict"], *sentences])
    return found


def asked(name):
    case = heldout.CASES[name]
    springs = {"springs": case["springs"]} if "springs" in case else {}
    return pintle.check(case["routine"], case["of"], offers=case["offers"], **springs, **FEW)


@pytest.fixture(scope="module")
def reports():
    return {name: asked(name) for name in heldout.CASES}


@pytest.mark.parametrize("name", connectors.TYPES)
def test_right_formulas_raise_no_alarm(name):
    # Rows of constrained rotations are no moments, whose directions the manual prints; nor is a strain a displacement.
    kinds, *_, rotations = connectors.TYPES[name]
    is_printed = "C" in kinds[3:] or name in ("SLIPRING", "ACCELEROMETER", "ROTATION-ACCELEROMETER")
    offers = OFFERS[:2] if rotations == "drum" else OFFERS[:5] if is_printed else OFFERS
    # These formulas lose digits beside e3b = −e3a, as the check says.
    near = 0 if rotations == "projection" else FEW["near_singular_states"]
    report = pintle.check(connectors.right(name), name, offers=offers, **{**FEW, "near_singular_states": near})
    assert report.ok, report
    # A flow converter has ten numbers at a state.
    assert report.compared > (300 if name == "FLOW-CONVERTER" else 500), report.compared


@pytest.mark.parametrize("kind", ["BEAM", "LINK", "PIN", "REVOLUTE", "TIE", "UNIVERSAL"])
def test_right_constraints_raise_no_alarm(kind):
    report = pintle.check(constraints.routine(kind), f"MPC {kind}", offers=constraints.ALL, **FEW)
    assert report.ok, report


@pytest.mark.parametrize("kind", frictions.KINDS)
def test_right_frictions_raise_no_alarm(kind):
    offers = (*frictions.GRADIENTS, *frictions.TANGENT)
    report = pintle.check(frictions.routine(kind), f"FRICTION {kind}", offers=offers, **FEW)
    assert report.ok, report


def test_every_wrong_routine_is_found_and_its_cause_is_told(reports):
    assert len(heldout.CASES) == 148 and expected.CODES.keys() == heldout.CASES.keys()
    missed = [name for name, report in reports.items() if report.verdict in ("pass", "undecided")]
    assert not missed, missed
    unnamed = [name for name, report in reports.items() if not expected.CODES[name] & report.codes]
    told = {name: sorted(reports[name].codes) for name in unnamed}
    assert set(unnamed) == expected.UNNAMED, told
    assert len(unnamed) <= 0.1 * len(reports), told


def test_the_command_says_the_same_of_every_routine(reports):
    program = "import sys; from pintle._command import main; sys.exit(main())"

    def ran(name):
        case = heldout.CASES[name]
        more = [f"--springs={','.join(map(str, case['springs']))}"] if "springs" in case else []
        command = [sys.executable, "-c", program, "check", case["of"], "--python", f"heldout:{name}", *more, *WORDS]
        environment = {**os.environ, "CORPUS_OFFERS": ",".join(case["offers"])}
        done = subprocess.run([*command, "--timeout=120", "--format=json"], capture_output=True, text=True, cwd=CORPUS, env=environment)
        assert done.returncode == 1, (name, done.returncode, done.stderr)
        return name, json.loads(done.stdout)

    compared = 0
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, theirs in pool.map(ran, heldout.CASES):
            ours = json.loads(reports[name].to_json())
            assert said(ours) == said(theirs), name
            compared += sum(len(check) - 3 for check in said(ours))
    assert compared >= len(heldout.CASES), compared
