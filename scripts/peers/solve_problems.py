"""Two problems with stick that any simulator can be given, and their closed forms. Those of references/block and references/load_reversal:
a mass of 2 under a weight of 20 slides along x, and friction holds up to 5.

  free      no friction; a spring of 100 is pulled by its end, which moves with 1 until 0.2 and rests: is the set-up right?
  block     the same with friction: stick, slip, a turn, slip, rest
  reversal  a push that goes to 4.9 and back to −4.9: it sticks through

The spring stands as one of 100 to the origin, and a force of 100 s(t): programs have their own springs.
"""

import json
import math
from pathlib import Path

MASS, WEIGHT, BOUND, SPRING, END = 2.0, 20.0, 5.0, 100.0, 3.0
MU = BOUND / WEIGHT
ROOT = Path(__file__).resolve().parents[2]


def pulled(t):
    """Where the end of the spring is."""
    return min(t, 0.2)


def push(t):
    """The force of load_reversal."""
    return 4.9 * (t if t < 1 else 2 - t)


class Problem:
    def __init__(self, name, spring, bound, force):
        self.name, self.spring, self.bound, self.force = name, spring, bound, force
        self.mu = bound / WEIGHT


FREE = Problem("free", SPRING, 0.0, lambda t: SPRING * pulled(t))
BLOCK = Problem("block", SPRING, BOUND, lambda t: SPRING * pulled(t))
REVERSAL = Problem("reversal", 0.0, BOUND, push)


def free_at(t):
    """x of the frictionless problem."""
    w = math.sqrt(SPRING / MASS)
    if t <= 0.2:
        return t - math.sin(w * t) / w
    x, v = 0.2 - math.sin(w * 0.2) / w, 1 - math.cos(w * 0.2)
    return 0.2 + (x - 0.2) * math.cos(w * (t - 0.2)) + v / w * math.sin(w * (t - 0.2))


def block_end():
    """Where references/block comes to rest: its closed form."""
    stored = json.loads((ROOT / "references" / "block" / "closed.json").read_text())
    return float(stored["last"]["connectors"]["101"]["1"]["CU"])
