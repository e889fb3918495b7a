"""Proofs that the formulas which the program differentiates are the printed ones, in SymPy.

`pintle export TYPE --as sympy` gives the formulas as traced from the program's kinematics; scripts/proof/proof_formulas.py has them as the
manual's pages print them, typed independently. For every connection type the difference is shown to vanish: values, first and second
derivatives, friction; in the directions of a, and at the nodes. scripts/proof/proof_identities.py proves what the pages say in two ways,
and by how much a printed formula that a decision sets aside differs from what the program uses; scripts/proof/proof_reported.py that the
printed one is reported beside it.

*Proved* means that the reduced numerator of the difference is the zero polynomial on each branch met (scripts/proof/proof_algebra.py).
Where that cannot be had the difference is zero to 50 digits at random states, and the table says so.

Each comparison is repeated with the exported formula negated and doubled, and must refuse both; exported programs with one sign or
one factor changed must be refused as well.

Usage (needs cargo, and SymPy of scripts/requirements.txt; a minute):
  python3 scripts/proof/prove.py           the table of proofs
  python3 scripts/proof/prove.py --check   for the test command: only what is not proved, and the count; the longest second derivatives
                                     are sampled
"""

import argparse
import ast
import concurrent.futures
import itertools
import re
import sys
import time
from dataclasses import dataclass

import mpmath
import proof_export
import proof_identities
import proof_reported
import sympy
from proof_algebra import Evaluation, Number, Ring
from proof_formulas import ASSEMBLED, BASIC, FRICTION, NOTHING, TYPES, printed
from proof_export import symbols_of
from proof_regions import D, NODE_ANGLES, PSI_A, PSI_B, Q, Draw, Region, about, product, regions_for, relative_state

MUTANTS = {
    "REVOLUTE": ("values", "jacobian"), "EULER": ("values",), "RADIAL-THRUST": ("jacobian",), "SLIPRING": ("values", "jacobian"),
    "PROJECTION CARTESIAN": ("values",),
}
"""Types whose exported programs are changed for the self-test, sign by sign, and the functions in which."""

LONG = {"PROJECTION CARTESIAN", "ALIGN", "PROJECTION FLEXION-TORSION"}
"""Types whose second derivatives take minutes to prove; `--check` samples them."""

SAMPLES = 6
"""States at which each formula is compared."""

PROVED, SAMPLED, REPORTED, DIFFERS = "proved symbolically", "by 50-digit sampling", "reported to rounding", "DIFFERS"
REFUSED = "refused"


@dataclass
class Line:
    """One row of the table."""

    subject: str
    verdict: str
    detail: str
    source: str

    def __str__(self):
        detail = f" ({self.detail})" if self.detail else ""
        return f"{self.subject:<44} {self.verdict}{detail}  [{self.source}]"


@dataclass
class Judgement:
    """What the comparisons of one formula found."""

    cases: int = 0
    exact: int = 0
    states: int = 0
    branches: int = 0
    differs: str = ""
    reason: str = ""
    perturbed: int = 0

    def compare(self, left, right, period=None, is_exact=True):
        """Takes note of one pair of numbers, equal but for whole periods; where not `is_exact` only to 50 digits."""
        self.cases += 1
        for number in (left, right):
            if number.fraction is not None:
                apart = number.fraction.value() - number.value
                if abs(apart) > mpmath.mpf(10) ** -40 * (1 + abs(number.value)):
                    raise AssertionError(f"the algebra and the sample disagree by {mpmath.nstr(apart)}")
        found = equal(left, right, period)
        if found is None:
            self.differs = self.differs or f"by {mpmath.nstr(left.value - right.value, 5)}"
        elif found:
            self.exact += 1
        elif is_exact:
            self.reason = self.reason or left.reason or right.reason or "the difference does not reduce to zero"
        if found is not None:
            for wrong in perturbations(left):
                if equal(wrong, right, period) is not None:
                    raise AssertionError("a perturbed formula was not refused")
                self.perturbed += 1

    def at_state(self, is_exact):
        """Takes note of one more state, the first of its branch where it is exact."""
        self.states += 1
        self.branches += is_exact

    def add(self, other):
        """Takes over what was found elsewhere."""
        self.cases += other.cases
        self.exact += other.exact
        self.states += other.states
        self.perturbed += other.perturbed
        self.differs = self.differs or other.differs
        self.reason = self.reason or other.reason

    def line(self, subject, source):
        if self.differs:
            return Line(subject, DIFFERS, self.differs, source)
        if not self.cases:
            return Line(subject, DIFFERS, "nothing was compared", source)
        if self.exact and not self.reason:
            return Line(subject, PROVED, "" if self.branches < 2 else f"{self.branches} branches", source)
        return Line(subject, SAMPLED, f"{self.states} states: {self.reason}", source)


def equal(left, right, period=None):
    """True where the difference is the zero polynomial, False where it is only zero to 50 digits, None where it is neither."""
    difference = left - right
    if period:
        turns = int(mpmath.nint(difference.value / mpmath.pi))
        if turns:
            pi = left.fraction.ring.named("pi") * left.fraction.ring.constant(turns) if left.fraction is not None else None
            difference = difference - Number(turns * mpmath.pi, pi, left.reason)
    if not difference.is_near_zero(max(abs(left.value), abs(right.value))):
        return None
    return difference.fraction is not None and difference.fraction.is_zero()


def perturbations(number):
    """The number with its sign changed, and doubled; of zero a number next to it."""
    if number.is_near_zero(0):
        return [number + Number(mpmath.mpf(10) ** -30, None)]
    return [-number, number + number]


def along_variations(expression):
    """The derivatives along δ1 … δ3, ρ1 … ρ3 (Q → exp(ρ^) Q), Ψ_a, Ψ_b."""
    found = [expression.diff(x) for x in D]
    by_entry = expression.jacobian(list(Q)) if hasattr(expression, "jacobian") else sympy.Matrix([expression]).jacobian(list(Q))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # e_i^ Q: row j is −row k of Q, row k is row j.
        found.append(sum(by_entry[3 * k + c] * Q[j, c] - by_entry[3 * j + c] * Q[k, c] for c in range(3)))
    return found + [expression.diff(PSI_A), expression.diff(PSI_B)]


def second_variations(slopes):
    """The derivatives of eight first derivatives, the mean of both orders where they are two turns."""
    ordered = [along_variations(slope) for slope in slopes]
    return [[(ordered[i][j] + ordered[j][i]) / 2 for j in range(8)] for i in range(8)]


def row_of(row, state):
    """The printed force on b, moment on b, and forces on the flows."""
    force = row.force(state) if row.force else NOTHING
    moment = row.moment(state) if row.moment else NOTHING
    return [*force, *moment, *(row.flow(state) if row.flow else (0, 0))]


def state_of(name, region):
    return relative_state(0 if name.endswith("_constraint") else sympy.Integer(region.turns))


class Comparison:
    """The functions of one basic type against the printed ones."""

    def __init__(self, type_name, export, samples=SAMPLES, is_exact=True, is_quick=False):
        self.type_name, self.export, self.samples, self.is_exact, self.is_quick = type_name, export, samples, is_exact, is_quick

    def functions(self):
        expected, found = set(printed(self.type_name)), set(self.export.names)
        if expected != found:
            raise AssertionError(f"{self.type_name}: exported {sorted(found)}, printed {sorted(expected)}")
        return sorted(expected)

    def lines(self):
        for name in self.functions():
            yield from self.of(name)

    def of(self, name):
        formula = printed(self.type_name)[name]
        value, row = self.export.value(name), self.export.row(name)
        judgements = [Judgement() for _ in formula.forms]
        slopes, rows = Judgement(), [Judgement() for _ in formula.rows]
        seen = set()
        for region in regions_for(self.type_name, name, Draw(f"{self.type_name} {name}"), self.samples):
            state = state_of(name, region)
            slope_row = along_variations(formula.forms[0].value(state)) if formula.forms else []
            evaluation, is_exact = evaluation_of(region, [*([value] if formula.forms else []), *row], seen, self.is_exact)
            exported_row = [evaluation.of(entry) for entry in row]
            for form, judgement in zip(formula.forms, judgements, strict=True):
                judgement.at_state(is_exact)
                judgement.compare(evaluation.of(value), evaluation.of(form.value(state)), form.modulo, is_exact)
            slopes.at_state(is_exact)
            for entry, slope in zip(exported_row, slope_row):
                slopes.compare(entry, evaluation.of(slope), None, is_exact)
            for printed_row, judgement in zip(formula.rows, rows, strict=True):
                judgement.at_state(is_exact)
                for entry, other in zip(exported_row, row_of(printed_row, state), strict=True):
                    judgement.compare(entry, evaluation.of(other), None, is_exact)
        if formula.forms and self.is_exact:
            yield self.second(name, formula.forms[0])
        subject = f"{self.type_name} {name}"
        for form, judgement in zip(formula.forms, judgements, strict=True):
            yield judgement.line(f"{subject} value", form.source), judgement
        if formula.forms:
            yield slopes.line(f"{subject} derivatives", formula.forms[0].source), slopes
        for printed_row, judgement in zip(formula.rows, rows, strict=True):
            yield judgement.line(f"{subject} row", printed_row.source), judgement


    def second(self, name, form):
        """The second derivatives: proved on the first branch, or sampled."""
        judgement = Judgement()
        is_sampled = self.is_quick and self.type_name in LONG
        exported = self.export.second(name)
        for region in regions_for(self.type_name, name, Draw(f"second {self.type_name} {name}"), 3 if is_sampled else 1):
            region.is_exact = not is_sampled
            evaluation = region.evaluation()
            judgement.at_state(not is_sampled)
            wanted = second_variations(along_variations(form.value(state_of(name, region))))
            for i in range(8):
                for j in range(i, 8):
                    judgement.compare(evaluation.of(exported[i][j]), evaluation.of(wanted[i][j]))
                    if exported[i][j] != exported[j][i]:
                        raise AssertionError(f"{self.type_name} {name}: the second derivatives are not symmetric")
        if is_sampled:
            judgement.reason = "proved without --check"
        return judgement.line(f"{self.type_name} {name} second derivatives", form.source), judgement


def evaluation_of(region, expressions, seen, is_exact=True):
    """An exact evaluation on the first state of each branch, on the others one of values only."""
    region.is_exact = False
    sampled = region.evaluation()
    for expression in expressions:
        sampled.of(expression)
    branch = (region.kind, frozenset(sampled.branches))
    if branch in seen or not is_exact:
        return sampled, False
    seen.add(branch)
    region.is_exact = True
    return region.evaluation(), True


class Friction:
    """The criteria of one type's predefined friction against the printed ones."""

    def __init__(self, type_name, export):
        self.type_name, self.export = type_name, export

    def lines(self):
        forms = FRICTION[self.type_name]
        criteria = sorted({form.criterion for form in forms})
        if criteria != list(range(1, self.export.frictions + 1)):
            raise AssertionError(f"{self.type_name}: {self.export.frictions} criteria exported, {criteria} printed")
        for form in forms:
            yield from self.of(form)

    def of(self, form):
        point, gradient, inputs = self.export.friction(form.criterion)
        forces, parameters = form.variables(inputs)
        names = {str(symbol): symbol for group in inputs.values() for symbol in group}
        potential, contact = form.potential(forces, parameters), form.contact(forces, parameters)
        internal = parameters[form.internal] if form.internal else 0
        normal = sympy.Abs(contact + internal)
        limit = form.limit(forces, parameters) if form.limit else parameters["mu"] * normal
        criterion = potential - limit
        wanted = [potential, contact, normal, criterion]
        by = inputs["tension"] + inputs["wrap"] if "tension" in inputs else inputs["f"]
        slopes = [criterion.diff(force) for force in by]
        judgements = [Judgement(), Judgement()]
        seen = set()
        draw = Draw(f"{self.type_name} {form.criterion}")
        for _ in range(2 * SAMPLES):
            region = friction_region(draw, names)
            evaluation, is_exact = evaluation_of(region, [*point, *gradient], seen)
            for pairs, judgement in zip(((point, wanted), (gradient, slopes)), judgements, strict=True):
                judgement.at_state(is_exact)
                for exported, other in zip(*pairs, strict=True):
                    judgement.compare(evaluation.of(exported), evaluation.of(other), None, is_exact)
        subject = f"{self.type_name} friction {form.criterion}"
        yield judgements[0].line(f"{subject} P, F_C, F_N, Φ", form.source), judgements[0]
        yield judgements[1].line(f"{subject} gradient of Φ", form.source), judgements[1]


def friction_region(draw, names):
    """Forces of either sign, positive parameters, angles of a cross."""
    values, angles = {}, {}
    for name in names:
        if name.startswith("angles"):
            angles[name] = draw.between(-1.4, 1.4)
        elif name.startswith("f") or name.endswith("_int"):
            values[name] = draw.between(-3, 3)
        else:
            values[name] = draw.between(0.2, 3)
    ring = Ring(values, angles)
    numbers = {symbol: ring.named(name) for name, symbol in names.items()}
    return Region("friction", ring, numbers, [])


def assembled(type_name, export, halves):
    """Every function and row of an assembled type is that of one of its halves, and nothing is missing."""
    judgement = Judgement(states=1)
    expected = {}
    for half in halves:
        expected |= {name: half for name in half.names}
    if set(expected) != set(export.names):
        return Line(f"{type_name} functions", DIFFERS, f"{sorted(export.names)}", "assembled"), judgement
    for name, half in expected.items():
        pairs = zip([export.value(name), *export.row(name)], [half.value(name), *half.row(name)], strict=True)
        for mine, other in pairs:
            judgement.cases += 1
            if mine == other:
                judgement.exact += 1
            else:
                judgement.differs = judgement.differs or name
            if mine == other + 1 or (mine != 0 and mine == -other):
                raise AssertionError("a perturbed formula was not refused")
            judgement.perturbed += 1
    first, second = ASSEMBLED[type_name]
    return judgement.line(f"{type_name} = {first} + {second}", f"{type_name}, Description"), judgement


def claims():
    for claim in proof_identities.claims():
        judgement = Judgement(states=1)
        for evaluation, left, right in claim.cases:
            judgement.compare(evaluation.of(left), evaluation.of(right))
        yield judgement.line(claim.name, claim.source), judgement


def matrix_times(a, b):
    return [[a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] for j in range(len(b[0]))] for i in range(3)]


def nodal_inputs(region):
    """The inputs of a nodal program at a region with an orientation of a: A, B = A Q, x_b − x_a = A d; all as fractions."""
    ring = region.ring
    turn = [ring.named(name) for name in NODE_ANGLES]
    a = product(about(ring, 0, turn[0]), about(ring, 1, turn[1]), about(ring, 2, turn[2]))
    q = [[region.numbers[Q[i, j]] for j in range(3)] for i in range(3)]
    separation = matrix_times(a, [[region.numbers[x]] for x in D])
    nodal = dict(region.numbers)
    for group, matrix in (("A", a), ("B", matrix_times(a, q))):
        nodal |= dict(zip(proof_export.symbols_of(group), itertools.chain(*matrix)))
    reference, moved = symbols_of("X"), symbols_of("U_a")
    nodal |= {symbol: ring.named(str(symbol)) for symbol in (*reference, *moved)}
    for i, symbol in enumerate(symbols_of("U_b")):
        nodal[symbol] = separation[i][0] - nodal[reference[i]] + nodal[moved[i]]
    return nodal, a, [entry[0] for entry in separation]


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def nodal_rows(type_name, relative, nodal, known):
    """The exported nodal rows against −g, g × D − h, ∂Ψ_a, g, h, ∂Ψ_b of the relative ones, which are proved, in global components.

    `known` has what was found of the same formulas in another type.
    """
    judgement = Judgement()
    for name in relative.names:
        same = (relative.value(name), *relative.row(name), nodal.value(name), *nodal.row(name))
        if same in known:
            judgement.add(known[same])
            continue
        known[same] = Judgement()
        draw = Draw(f"nodal {type_name} {name}")
        for region in regions_for(type_name, name, draw, 1, at_nodes=True):
            inputs, a, separation = nodal_inputs(region)
            evaluation = region.evaluation()
            row = [evaluation.of(entry) for entry in relative.row(name)]
            if any(entry.fraction is None for entry in row):
                raise AssertionError(f"{type_name} {name}: the relative row is not exact")
            row = [entry.fraction for entry in row]
            g, h = ([entry[0] for entry in matrix_times(a, [[part] for part in parts])] for parts in (row[:3], row[3:6]))
            arm = [x - y for x, y in zip(cross(g, separation), h, strict=True)]
            wanted = [-x for x in g] + arm + [row[6]] + g + h + [row[7]]
            at_nodes = Evaluation(region.ring, inputs, region.angles)
            known[same].states += 1
            for exported, other in zip(nodal.row(name), wanted, strict=True):
                known[same].compare(at_nodes.of(exported), Number(other.value(), other))
            known[same].compare(at_nodes.of(nodal.value(name)), evaluation.of(relative.value(name)))
        judgement.add(known[same])
    return judgement.line(f"{type_name} nodal values and rows", "variations of d and Q (D-29)"), judgement


class Changed(ast.NodeTransformer):
    """Changes the n-th place of a function: a sign dropped, a sum for a difference or the reverse, a factor 2 in a quotient."""

    def __init__(self, n):
        self.left = n

    def is_hit(self):
        self.left -= 1
        return self.left == -1

    def visit_UnaryOp(self, node):
        self.generic_visit(node)
        return node.operand if isinstance(node.op, ast.USub) and self.is_hit() else node

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if isinstance(node.op, (ast.Add, ast.Sub)) and self.is_hit():
            node.op = ast.Add() if isinstance(node.op, ast.Sub) else ast.Sub()
        elif isinstance(node.op, ast.Div) and self.is_hit():
            node.left = ast.BinOp(ast.Constant(2), ast.Mult(), node.left)
        return node


def changed(text, function):
    """Every program that differs from `text` in one place of `function`."""
    for n in itertools.count():
        tree, change = ast.parse(text), Changed(n)
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and node.name == function:
                change.visit(node)
        if change.left >= 0:
            return
        yield ast.unparse(ast.fix_missing_locations(tree))


def beside(path):
    """That `pintle eval` reports the printed moment beside the exact one where they are not the same."""
    for type_name, formula, errors, apart in proof_reported.reported(path):
        subject, source = f"{type_name} PM beside CTM", formula
        if max(errors) > proof_reported.ROUNDING:
            yield Line(subject, DIFFERS, f"misses the moment on b by {mpmath.nstr(max(errors), 3)}", source)
        elif apart < proof_reported.APART:
            yield Line(subject, DIFFERS, "PM and CTM are the same at the state: nothing is tested", source)
        else:
            yield Line(subject, REPORTED, f"{apart:.3g} apart; both give the moment on b", source)


def is_same(type_name, one, other):
    """Whether two programs agree to 50 digits at a state."""
    for name in one.names:
        region = regions_for(type_name, name, Draw("same"), 1)[0]
        region.is_exact = False
        evaluation = region.evaluation()
        pairs = zip([one.value(name), *one.row(name)], [other.value(name), *other.row(name)], strict=True)
        if any(equal(evaluation.of(x), evaluation.of(y)) is None for x, y in pairs):
            return False
    return True


def self_test(exports):
    """Programs that differ in one sign or one factor are refused."""
    refused = 0
    for type_name, functions in MUTANTS.items():
        for function in functions:
            for place, text in enumerate(changed(exports[type_name].text, function)):
                export = proof_export.Export(text)
                if is_same(type_name, exports[type_name], export):
                    continue  # a sign of what is zero
                lines = Comparison(type_name, export, samples=2, is_exact=False).lines()
                if all(line.verdict != DIFFERS for line, _ in lines):
                    raise AssertionError(f"self-test: {type_name} with place {place} of {function} changed was not refused")
                refused += 1
    right = exports["TRANSLATOR"].text
    wrong = re.sub(r"\b2 \* reciprocal\(L\)", "4 * reciprocal(L)", right, count=1)
    found = Friction("TRANSLATOR", proof_export.Export(wrong)).lines()
    if wrong == right or all(line.verdict != DIFFERS for line, _ in found):
        raise AssertionError("self-test: TRANSLATOR with 4/L for 2/L was not refused")
    if refused < 20:
        raise AssertionError(f"self-test: only {refused} changed programs")
    return refused + 1


class Programs(dict):
    """Exported programs by type and variables, each asked for once."""

    def __init__(self, path):
        super().__init__()
        self.path = path

    def __missing__(self, key):
        type_name, variables = key if isinstance(key, tuple) else (key, "relative")
        self[key] = proof_export.Export.of(self.path, type_name, variables)
        return self[key]


PARTS = {
    "claims": lambda programs: claims(),
    "beside": lambda programs: ((line, Judgement()) for line in beside(programs.path)),
    "self-test": lambda programs: [(Line("changed programs", REFUSED, "", ""), Judgement(perturbed=self_test(programs)))],
    "assembled": lambda programs: (
        assembled(type_name, programs[type_name], [programs[half] for half in halves]) for type_name, halves in ASSEMBLED.items()
    ),
    "friction": lambda programs: itertools.chain(*(Friction(type_name, programs[type_name]).lines() for type_name in FRICTION)),
    "nodal": lambda programs: nodal_lines(programs),
}
"""What is proved of several types together."""


def nodal_lines(programs):
    known = {}
    return [nodal_rows(type_name, programs[type_name], programs[type_name, "nodal"], known) for type_name in BASIC]


def lines_of(path, part, is_quick):
    """The lines of a part, or of a basic type, with the judgements behind them."""
    programs = Programs(path)
    if part in PARTS:
        return list(PARTS[part](programs))
    return list(Comparison(part, programs[part], is_quick=is_quick).lines())


def proofs(path, is_quick):
    """Every line of the table, in order, from two processes."""
    parts = [*(part for part in PARTS if part != "self-test"), *BASIC, "self-test"]
    with concurrent.futures.ProcessPoolExecutor(max_workers=2) as pool:
        futures = {part: pool.submit(lines_of, path, part, is_quick) for part in sorted(parts, key=lambda part: part not in (*LONG, "nodal"))}
        for part in parts:
            yield from futures[part].result()


def check_coverage(path):
    """Every type of the catalogue is printed, and friction where it has any."""
    if proof_export.listed(path) != set(TYPES):
        raise SystemExit(f"prove.py: the catalogue and the printed formulas differ in {proof_export.listed(path) ^ set(TYPES)}")
    for type_name in TYPES:
        if (proof_export.Export.of(path, type_name).frictions > 0) != (type_name in FRICTION):
            raise SystemExit(f"prove.py: {type_name}: friction is printed or exported, not both")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="print only what is not proved, and the count")
    arguments = parser.parse_args()
    start = time.time()
    path = proof_export.program()
    check_coverage(path)
    counts, perturbed = dict.fromkeys((PROVED, SAMPLED, REPORTED, REFUSED, DIFFERS), 0), 0
    for line, judgement in proofs(path, arguments.check):
        if line.verdict == REFUSED:
            counts[REFUSED] += judgement.perturbed
            continue
        counts[line.verdict] += 1
        perturbed += judgement.perturbed
        if not arguments.check or line.verdict in (SAMPLED, DIFFERS):
            print(line, flush=True)
    print(
        f"{counts[PROVED]} proved symbolically, {counts[SAMPLED]} by 50-digit sampling, {counts[REPORTED]} reported to rounding, "
        f"{counts[DIFFERS]} differ; {perturbed} perturbed formulas and {counts[REFUSED]} changed programs refused; {time.time() - start:.0f} s"
    )
    return 1 if counts[DIFFERS] or not counts[PROVED] or not counts[REFUSED] else 0


if __name__ == "__main__":
    sys.exit(main())
