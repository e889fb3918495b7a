"""Predefined frictions by formulas of their own, right unless `wrong` names a mistake: criterion, gradients, forces, tangent."""

import jets as j
import numpy
from jets import dot, magnitude, norm

NAMES = {"f1": 0, "f2": 1, "f3": 2, "u1": 0, "u2": 1, "u3": 2, "m1": 3, "m2": 4, "m3": 5, "ur1": 3, "ur2": 4, "ur3": 5}


def over(x, length):
    return x / length if length else 0.0 * x


def parts(kind, f, friction, wrong):
    """P of the tractions, F_C of what presses, F_C^int, and the radius of each sliding component."""
    p = dict(friction["parameters"])
    if wrong == "lengths exchanged":
        names = [name for name in p if "int" not in name][:2]
        p[names[0]], p[names[1]] = p[names[1]], p[names[0]]
    number = lambda name: float(p.get(name) or 0.0)
    size = (lambda v: sum((magnitude(x) for x in v), 0.0)) if wrong == "sum" else norm
    inner = next((float(x or 0.0) for name, x in p.items() if "int" in name), 0.0)
    two = 1.0 if wrong == "one bearing" else 2.0
    radii = {}
    if kind == "SLIDE-PLANE":
        found, radii = (size(f[1:3]), magnitude(f[0])), {1: 1, 2: 1}
    elif kind == "SLOT":
        found, radii = (magnitude(f[0]), size(f[1:3])), {0: 1}
    elif kind == "TRANSLATOR":
        bend = over(two * size(f[4:6]), number("L"))
        pressing = over(magnitude(f[3]), number("R_r")) + size(f[1:3]) + bend
        found, radii = (magnitude(f[0]), pressing), {0: 1}
    elif kind == "CYLINDRICAL":
        radius = number("R")
        across = f[3] if wrong == "no radius" else f[3] / radius
        found, radii = (size([f[0], across]), size(f[1:3]) + over(two * size(f[4:6]), number("L"))), {0: 1, 3: radius}
    elif kind == "HINGE":
        radial = size(f[1:3]) + over(two * size(f[4:6]), number("L_s"))
        found, radii = (magnitude(f[3]), number("R_a") * magnitude(f[0]) + number("R_p") * radial), {3: 1}
    else:
        found, radii = (size(f[1:3]), magnitude(f[0]) + over(size(f[4:6]), number("R"))), {1: 1, 2: 1}
    return (*found, inner, radii)


def criterion(kind, f, friction, wrong):
    p, contact, inner, _ = parts(kind, f, friction, wrong)
    normal = magnitude(contact + (0.0 if wrong == "no internal" else inner))
    if wrong == "internal outside":
        normal = magnitude(contact) + abs(inner) * 2
    mu = float(friction["coefficient"])
    limit = normal * (mu * mu if wrong == "coefficient twice" else mu)
    if wrong == "normal halved":
        limit = limit * 0.5
    most = friction.get("maximum")
    if most is not None and j.value(limit) > most:
        limit = 0.0 * limit + float(most)
    return [p, contact, normal, p - limit], limit


def answered(kind, wrong, state, friction):
    f = j.variables(numpy.array(state["forces"], dtype=float))
    found, _ = criterion(kind, f, friction, wrong)
    given = {"criterion": [x.v for x in found], "gradients": [x.g for x in found]}
    increment, previous = state["increment"], state["previous"]
    y = j.variables(numpy.concatenate([increment["displacement"], increment["pressing"]]).astype(float))
    pressing, moved = y[6:], y[:6]
    _, contact, inner, radii = parts(kind, pressing, friction, wrong)
    (_, _, normal, _), limit = criterion(kind, pressing, friction, wrong)
    stiffness = previous.get("stick_stiffness") or friction.get("stick_stiffness") or 0.0
    old = previous["forces"]
    trial = {k: (0.0 if wrong == "no history" else float(old[k])) + moved[k] * (float(stiffness) * radius * radius) for k, radius in radii.items()}
    size = norm([trial[k] / radius for k, radius in radii.items()])
    slips = size.v > limit.v
    slip = (size - limit) / float(stiffness) if slips else 0.0 * limit
    share = limit / size if slips else 1.0 + 0.0 * limit
    if wrong == "no return":
        share, slip = 1.0 + 0.0 * limit, 0.0 * limit
    forces = [trial[k] * share if k in trial else 0.0 * limit for k in range(6)]
    if wrong == "each":
        clip = lambda x, r: x if abs(x.v) <= limit.v * r else limit * r if x.v > 0 else -(limit * r)
        forces = [clip(trial[k], radii[k]) if k in trial else 0.0 * limit for k in range(6)]
    total = (0.0 if wrong == "slip not summed" else float(previous["accumulated_slip"])) + slip
    if wrong == "slip is all" and slips:
        slip = norm([moved[k] * radius for k, radius in radii.items()])
        total = float(previous["accumulated_slip"]) + slip
    given["friction_forces"] = [*(x.v for x in forces), slip.v, normal.v, limit.v, total.v]
    tangent = [x.g.copy() for x in forces]
    if wrong == "elastic":
        tangent = [trial[k].g.copy() if k in trial else 0 * x.g for k, x in enumerate(forces)]
    if wrong == "fixed normal":
        for row in tangent:
            row[6:] = 0
    if wrong == "radial" and slips:
        # The limit over the size of the trial times the stick stiffness: the direction is taken as fixed in size only.
        for k in trial:
            tangent[k][:6] = share.v * trial[k].g[:6]
    if wrong == "no force along" and slips:
        for k in trial:
            tangent[k][:6] = 0
    given["friction_tangent"] = tangent
    return given


def routine(kind, wrong="", change=None):
    def asked(state, friction):
        given = answered(kind, wrong, state, friction)
        if change is not None:
            change(given, state)
        return given

    return asked


def absolute(given, state):
    """|x| is not differentiated: slopes of size, without the sign."""
    given["gradients"] = [numpy.abs(row) for row in given["gradients"]]


def of_contact(given, state):
    """The gradient of F_N by what presses is left out of that of Φ."""
    given["gradients"][3] = given["gradients"][0]


def phi_reversed(given, state):
    given["criterion"][3] = -given["criterion"][3]


CRITERION = ("criterion",)
GRADIENTS = ("criterion", "gradients")
FORCES = ("friction_forces",)
TANGENT = ("friction_forces", "friction_tangent")
KINDS = ("SLIDE-PLANE", "SLOT", "TRANSLATOR", "CYLINDRICAL", "HINGE", "PLANAR")

CASES = [
    (name, f"FRICTION {kind}", words, routine(kind, *wrong), offers)
    for name, kind, words, wrong, offers in [
        ("friction_hinge_radii", "HINGE", "the first two lengths exchanged", ("lengths exchanged",), CRITERION),
        ("friction_translator_lengths", "TRANSLATOR", "R_r and L exchanged", ("lengths exchanged",), CRITERION),
        ("friction_translator_bearing", "TRANSLATOR", "the bending moment over L, not twice", ("one bearing",), CRITERION),
        ("friction_cylindrical_sum", "CYLINDRICAL", "sums of magnitudes for norms", ("sum",), CRITERION),
        ("friction_cylindrical_radius", "CYLINDRICAL", "the moment is not divided by the radius", ("no radius",), CRITERION),
        ("friction_slot_internal", "SLOT", "the internal force is forgotten", ("no internal",), CRITERION),
        ("friction_plane_coefficient", "SLIDE-PLANE", "the coefficient is multiplied twice", ("coefficient twice",), CRITERION),
        ("friction_planar_half", "PLANAR", "half of the limit", ("normal halved",), CRITERION),
        ("friction_slot_phi", "SLOT", "the criterion has the opposite sign", ("", phi_reversed), CRITERION),
        ("friction_planar_gradient", "PLANAR", "slopes of magnitudes without their sign", ("", absolute), GRADIENTS),
        ("friction_slot_contact", "SLOT", "the slope of the limit by what presses is missing", ("", of_contact), GRADIENTS),
        ("friction_plane_no_return", "SLIDE-PLANE", "no return: stick where it slips", ("no return",), FORCES),
        ("friction_plane_each", "SLIDE-PLANE", "each component is returned alone: a box for the circle", ("each",), FORCES),
        ("friction_hinge_no_history", "HINGE", "the force before is forgotten", ("no history",), FORCES),
        ("friction_slot_slip", "SLOT", "the slip is not added up", ("slip not summed",), FORCES),
        ("friction_translator_slip", "TRANSLATOR", "all of the motion counts as slip, the elastic part too", ("slip is all",), FORCES),
        ("friction_plane_elastic", "SLIDE-PLANE", "the elastic tangent in slip", ("elastic",), TANGENT),
        ("friction_cylindrical_normal", "CYLINDRICAL", "the unsymmetric part is missing: derivatives by what presses", ("fixed normal",), TANGENT),
        ("friction_plane_secant", "SLIDE-PLANE", "the secant: the share times the elastic tangent", ("radial",), TANGENT),
        ("friction_planar_zero", "PLANAR", "no stiffness at all in slip", ("no force along",), TANGENT),
    ]
]
