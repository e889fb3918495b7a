# /// script
# requires-python = ">=3.10"
# dependencies = ["mpmath==1.3.0"]
# ///
"""Closed-form states of the scenes in decks/, written to decks/<name>.states.csv.

    python scripts/gallery_states.py            write the files
    python scripts/gallery_states.py --check    compare them with the committed ones

Every number is computed with 60 digits from the coordinates that the deck gives as doubles, and rounded once.
Rates are the exact time derivatives; the script checks them against numerical differentiation at 60 digits.

hinge_pendulum, 25 states, t = k/8 for k = 0..24, three turns about z through the origin:
    phi(t) = 2 pi t + sin(2 pi t)/4;  nodes 2 and 3 turn by (0, 0, phi);  x3 = (cos phi, sin phi, 0) |X3|.

slider_crank, 25 states, t = k/24, one turn at constant rate theta = 2 pi t, crank r = |X3 - X2|, rod l = |X5 - X4|:
    sin psi = -(r/l) sin theta, cos psi > 0 (angle of the rod);
    x3 = x4 = r (cos theta, sin theta, 0);  x5 = x6 = (r cos theta + l cos psi, 0, 0).
    Nodes 2, 3 turn by theta, 4 and 5 by psi, 6 does not turn.  r = 0.2, l = 0.6: u1 of node 6 at 90 degrees
    is sqrt(0.32) - 0.8 = -0.23431.

seat_belt, 11 states, t = k/10, pull p = 0.1 t of node 30 in x, no friction.  Drum: beta = 50 per length, spring
    5 per radian, belt stiffness 1e5 per unit strain, both segments of length 1 at first.
    The drum turns by theta = beta Psi_10 (RETRACTOR), its spring gives the tension T = 5 beta theta = 1e5 (lambda - 1),
    so lambda = 1 + Psi_10/8; equal tensions give
    lambda (1 + Psi_10 - Psi_20) = 1 and lambda (1 + Psi_20) = 1 + p (Psi_30 = 0), whose sum is
    Psi_10^2/8 + (5/4) Psi_10 = p:  Psi_10 = sqrt(25 + 8 p) - 5,  Psi_20 = (1 + p)/lambda - 1.
    At p = 0.1: Psi_10 = 0.07937, theta = 3.9685, T = 992.1.

revolute_mpc, 33 states, t = k/16 for k = 0..32.  The master (20) moves by (t/2, sin(2 pi t)/3, (1 - cos(2 pi t))/4)
    and turns by chi = (3/2) pi t about m = (1, 2, 2)/3 (one and a half turns); the joint angle
    phi(t) = 29/10 pi t + sin(pi t)/2 makes 2.9 turns.  Dependent node (10): C_S = C_M C(phi a0), a0 = (2, 1, 2)/3, given as
    a quaternion; omega_S = omega_M + phi' a, alpha_S = alpha_M + phi'' a + phi' omega_M x a, a = C_M a0.
    Degree of freedom 6 of node 30 is phi.

parallel_cranks, 25 states, t = k/24, both cranks turn about z by phi(t) = 6.283185307 t, the motion of the step, from upright:
    x of a tip = the foot of its crank + r (-sin phi, cos phi, 0), r = 0.5; the coupler between the tips does not turn,
    so both its nodes move by r (-sin phi, cos phi - 1, 0).
"""

import sys
from pathlib import Path

from mpmath import asin, cos, diff, mp, mpf, pi, sin, sqrt

mp.dps = 60
DECKS = Path(__file__).resolve().parent.parent / "decks"
VECTORS = {
    "u": ("u1", "u2", "u3"),
    "ur": ("ur1", "ur2", "ur3"),
    "q": ("q0", "q1", "q2", "q3"),
    "v": ("v1", "v2", "v3"),
    "vr": ("vr1", "vr2", "vr3"),
    "a": ("a1", "a2", "a3"),
    "ar": ("ar1", "ar2", "ar3"),
    "flow": ("flow",),
    "flow_v": ("flow_v",),
    "flow_a": ("flow_a",),
}


def add(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def scale(factor, vector):
    return [factor * part for part in vector]


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def turn(axis, angle):
    """Quaternion of a rotation about a unit axis."""
    return [cos(angle / 2)] + scale(sin(angle / 2), axis)


def multiply(a, b):
    """Quaternion of the rotation b followed by a."""
    vector = add(scale(a[0], b[1:]), scale(b[0], a[1:]), cross(a[1:], b[1:]))
    return [a[0] * b[0] - sum(x * y for x, y in zip(a[1:], b[1:]))] + vector


def rotate(q, v):
    twice = scale(2, cross(q[1:], v))
    return add(v, scale(q[0], twice), cross(q[1:], twice))


def moving(displacement):
    """Displacement with its rates, each component a function of time given with its two derivatives."""
    return {"u": [c[0] for c in displacement], "v": [c[1] for c in displacement], "a": [c[2] for c in displacement]}


def about_z(angle):
    return {"ur": [0, 0, angle[0]], "vr": [0, 0, angle[1]], "ar": [0, 0, angle[2]]}


def circle(radius, angle):
    """radius (cos, sin) of an angle that is given with its two derivatives, and the same derivatives of it."""
    phi, rate, acceleration = angle
    x = (radius * cos(phi), -radius * sin(phi) * rate, -radius * (sin(phi) * acceleration + cos(phi) * rate**2))
    y = (radius * sin(phi), radius * cos(phi) * rate, radius * (cos(phi) * acceleration - sin(phi) * rate**2))
    return x, y


def minus(triple, constant):
    return (triple[0] - constant, *triple[1:])


ZERO = (mpf(0), mpf(0), mpf(0))


def hinge_pendulum():
    length = mpf(1)

    def state(t):
        w = 2 * pi
        phi = (w * t + sin(w * t) / 4, w + w * cos(w * t) / 4, -(w**2) * sin(w * t) / 4)
        x, y = circle(length, phi)
        return {2: about_z(phi), 3: {**moving([minus(x, length), y, ZERO]), **about_z(phi)}}

    return state, [mpf(k) / 8 for k in range(25)]


def slider_crank():
    r, reach = mpf(0.2), mpf(0.8)
    l = reach - r

    def state(t):
        theta = (2 * pi * t, 2 * pi, mpf(0))
        sine = -(r / l) * sin(theta[0])
        psi = asin(sine)
        rate = -(r / l) * cos(theta[0]) * theta[1] / cos(psi)
        psi = (psi, rate, ((r / l) * sin(theta[0]) * theta[1] ** 2 + sine * rate**2) / cos(psi))
        crank = circle(r, theta)
        rod = circle(l, psi)
        pin = moving([minus(crank[0], r), crank[1], ZERO])
        slider = moving([tuple(c + d for c, d in zip(minus(crank[0], r), minus(rod[0], l))), ZERO, ZERO])
        return {
            2: about_z(theta),
            3: {**pin, **about_z(theta)},
            4: {**pin, **about_z(psi)},
            5: {**slider, **about_z(psi)},
            6: slider,
        }

    return state, [mpf(k) / 24 for k in range(25)]


def seat_belt():
    pull, beta = mpf(0.1), mpf(50)

    def state(t):
        p = pull * t
        root = sqrt(25 + 8 * p)
        drum = (root - 5, 4 * pull / root, -16 * pull**2 / root**3)
        stretch = (1 + drum[0] / 8, drum[1] / 8, drum[2] / 8)
        ring = ((1 + p) / stretch[0] - 1,)
        ring += ((pull - (1 + ring[0]) * stretch[1]) / stretch[0],)
        ring += ((-2 * ring[1] * stretch[1] - (1 + ring[0]) * stretch[2]) / stretch[0],)

        def flow(psi):
            return {"flow": [psi[0]], "flow_v": [psi[1]], "flow_a": [psi[2]]}

        return {
            1: about_z([beta * part for part in drum]),
            10: flow(drum),
            20: flow(ring),
            30: moving([(p, pull, mpf(0)), ZERO, ZERO]),
        }

    return state, [mpf(k) / 10 for k in range(11)]


def revolute_mpc():
    m = [mpf(1) / 3, mpf(2) / 3, mpf(2) / 3]
    a0 = [mpf(2) / 3, mpf(1) / 3, mpf(2) / 3]

    def state(t):
        w = 2 * pi
        chi = (3 * pi * t / 2, 3 * pi / 2)
        rate = 29 * pi / 10
        phi = (rate * t + sin(pi * t) / 2, rate + pi * cos(pi * t) / 2, -(pi**2) * sin(pi * t) / 2)
        master = turn(m, chi[0])
        a = rotate(master, a0)
        omega = scale(chi[1], m)
        path = moving(
            [
                (t / 2, mpf(1) / 2, mpf(0)),
                (sin(w * t) / 3, w * cos(w * t) / 3, -(w**2) * sin(w * t) / 3),
                ((1 - cos(w * t)) / 4, w * sin(w * t) / 4, w**2 * cos(w * t) / 4),
            ]
        )
        dependent = {
            "q": multiply(master, turn(a0, phi[0])),
            "vr": add(omega, scale(phi[1], a)),
            "ar": add(scale(phi[2], a), scale(phi[1], cross(omega, a))),
        }
        return {
            10: {**path, **dependent},
            20: {**path, "ur": scale(chi[0], m), "vr": omega},
            30: about_z(phi),
        }

    return state, [mpf(k) / 16 for k in range(33)]


def parallel_cranks():
    r, turn_of_step = mpf(0.5), mpf(6.283185307)

    def state(t):
        phi = (turn_of_step * t, turn_of_step, mpf(0))
        x, y = circle(r, (pi / 2 + phi[0], phi[1], phi[2]))
        tip = moving([x, minus(y, r), ZERO])
        turn = about_z(phi)
        return {
            "CRANK-1.1": turn,
            "CRANK-1.2": {**tip, **turn},
            "CRANK-2.1": turn,
            "CRANK-2.2": {**tip, **turn},
            "COUPLER-1.1": tip,
            "COUPLER-1.2": tip,
        }

    return state, [mpf(k) / 24 for k in range(25)]


SCENES = {
    "hinge_pendulum": hinge_pendulum,
    "slider_crank": slider_crank,
    "seat_belt": seat_belt,
    "revolute_mpc": revolute_mpc,
    "parallel_cranks": parallel_cranks,
}


def check_rates(name, state, t):
    """The rates that a scene states against numerical differentiation of what they are rates of."""

    def value(node, quantity, index, time):
        vector = state(time)[node].get(quantity)
        return vector[index] if vector else mpf(0)

    def agree(node, rate, quantity):
        for index in range(len(VECTORS[rate])):
            wanted = diff(lambda time: value(node, quantity, index, time), t)
            got = value(node, rate, index, t)
            if abs(wanted - got) > mpf(10) ** -25 * (1 + abs(wanted)):
                raise SystemExit(f"{name}: {rate}{index + 1} of node {node} at t = {t}: {got}, not {wanted}")

    for node, motion in state(t).items():
        for rate, quantity in [("v", "u"), ("a", "v"), ("ar", "vr"), ("flow_v", "flow"), ("flow_a", "flow_v")]:
            agree(node, rate, quantity)
        if "q" in motion:
            q = motion["q"]
            rates = [diff(lambda time: state(time)[node]["q"][index], t) for index in range(4)]
            spin = scale(2, multiply(rates, [q[0]] + scale(-1, q[1:]))[1:])
            if max(abs(x - y) for x, y in zip(spin, motion["vr"])) > mpf(10) ** -25:
                raise SystemExit(f"{name}: angular velocity of node {node} at t = {t}")
        elif "ur" in motion:  # about a fixed axis, so that the rotation vector has the angular velocity as its rate
            agree(node, "vr", "ur")


def number(x):
    """The nearest double, in the fewest digits that give it back; zeros are left empty."""
    return repr(float(mp.nstr(x, 50))) if abs(x) > mpf(10) ** -50 else ""


def table(name):
    state, times = SCENES[name]()
    states = [(t, state(t)) for t in times]
    for t in (mpf(3) / 7, mpf(6) / 7):
        check_rates(name, state, t)
    used = {quantity for _, nodes in states for motion in nodes.values() for quantity in motion}
    quantities = [quantity for quantity in VECTORS if quantity in used]
    lines = ["# written by scripts/gallery_states.py, which states the closed form"]
    lines.append(",".join(["state", "time", "node"] + [column for quantity in quantities for column in VECTORS[quantity]]))
    for index, (t, nodes) in enumerate(states):
        for node, motion in nodes.items():
            fields = [str(index), repr(float(t)), str(node)]
            for quantity in quantities:
                fields += [number(x) for x in motion.get(quantity, [0] * len(VECTORS[quantity]))]
            lines.append(",".join(fields))
    return "\n".join(lines) + "\n"


def main():
    check = "--check" in sys.argv[1:]
    for name in SCENES:
        path, text = DECKS / f"{name}.states.csv", table(name)
        if not check:
            path.write_text(text)
            print(f"wrote {path.name}")
        elif not path.exists() or path.read_text() != text:
            raise SystemExit(f"{path.name} differs from its closed form: run scripts/gallery_states.py")
        else:
            print(f"{path.name} agrees")


if __name__ == "__main__":
    main()
