"""Plays a tape of answers, as a Python function and as a process that answers JSON lines."""
import json
import math
import os
import struct
import sys
from itertools import chain

KIND, OFFERS = os.environ["KIND"], os.environ["OFFERS"].split()
SIZE, LINES, WIDTH = {"ELEMENT": (166, 6, 14), "MPC": (86, 7, 16), "FRICTION": (37, 0, 12)}[KIND]
SHAPES = {"values": (LINES,), "rows": (LINES, WIDTH), "second_derivatives": (LINES, WIDTH, WIDTH), "rates": (LINES,),
          "accelerations": (LINES,), "nodal_forces": (LINES, WIDTH), "geometric_stiffness": (LINES, WIDTH, WIDTH),
          "element_forces": (WIDTH,), "element_stiffness": (WIDTH, WIDTH), "criterion": (4,), "gradients": (4, 6),
          "friction_forces": (10,), "friction_tangent": (6, 12)}
NONE = struct.pack("<Q", 0x7FF8_7069_6E74_6C65)
TAPE = {}
with open(os.environ["TAPE"], "rb") as file:
    while head := file.read(8):
        record = file.read(8 * int(struct.unpack("<d", head)[0]))
        TAPE[record[:8 + 8 * SIZE]] = record[8 + 8 * SIZE:]


def node(of):
    zero = [0.0] * 3
    numbers = [*of["x"], *of["u"], *chain(*of["triad"]), *of["quaternion"], *of["rotation_vector"], of["flow"], *of.get("increment", zero)]
    for kind in ("velocity", "acceleration"):
        numbers += [*of.get(kind, zero), *of.get(f"angular_{kind}", zero), of.get(f"flow_{kind}", 0.0)]
    return numbers


def two(x):
    return [*x, 0.0, 0.0][:2]


def asked(state):
    if KIND == "MPC":
        hinges = [two(state.get(key, [])) for key in ("angles", "angle_velocities", "angle_accelerations")]
        return [*node(state["S"]), *node(state["M"]), *chain(*hinges)]
    before = state["previous"]
    if KIND == "ELEMENT":
        values = [0.0 if x is None else x for x in before["values"]]
        return [*node(state["a"]), *node(state["b"]), *node(before["a"]), *node(before["b"]), *values]
    by, slip = state["increment"], [before["accumulated_slip"]]
    return [*chain(state["forces"], by["displacement"], by["pressing"], before["forces"], slip, state["position"], state["motion"])]


def shaped(data, shape, width):
    size = len(data) // shape[0]
    parts = [data[i:i + size] for i in range(0, len(data), size)]
    if len(shape) == 1:
        return [None if part == NONE else struct.unpack("<d", part)[0] for part in parts]
    return [None if part.startswith(NONE) else shaped(part, shape[1:], width)[:width] for part in parts]


def play(state, subject, want):
    bits = sum(1 << place for place, name in enumerate(SHAPES) if name in want)
    numbers = asked(state)
    data = TAPE[struct.pack(f"<{SIZE + 1}d", bits, *numbers)]
    width = 14 + len(subject["axes"]) if KIND == "MPC" else WIDTH
    answer = {}
    for name, shape in SHAPES.items():
        if name in want:
            size = 8 * math.prod(shape)
            answer[name], data = shaped(data[:size], shape, width)[:width], data[size:]
    return answer


def plain(x):
    if isinstance(x, list):
        return [plain(y) for y in x]
    return x if x is None or math.isfinite(x) else "NaN" if x != x else "Infinity" if x > 0 else "-Infinity"


if __name__ == "__main__":
    for line in sys.stdin:
        message = json.loads(line)
        if "hello" in message:
            answer = {"hello": {"protocol": "pintle-candidate/1", "name": "played", "offers": OFFERS}}
        elif "open" in message:
            subject, answer = message["open"], {"opened": True}
        elif "evaluate" in message:
            of = message["evaluate"]
            played = [play(state, subject, of["want"]) for state in of["states"]]
            answer = {"id": of["id"], "answers": [{key: plain(x) for key, x in one.items()} for one in played]}
        else:
            break
        print(json.dumps(answer, allow_nan=False), flush=True)
