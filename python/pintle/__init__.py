"""A verification workbench for connector (joint) elements of finite-element and multibody codes.

`check` finds out whether a routine is right, `audit` whether a scene is; `Scene` and `rows` give numbers, `sweep`
goes over very many states.
Lengths are in the unit of the scene, angles in rad, axes global, arrays float64. `pintle.jax` and
`pintle.strategies` need JAX and Hypothesis, and are imported by themselves.
"""

from ._check import Report, RoutineError, check
from ._pintle import Entry, __version__
from ._rows import bias, geometric_stiffness, initial, pattern, rows
from ._scene import Jacobian, Scene, audit, catalog
from ._sweep import Sweep, sweep, sweep_chunk, sweep_left, sweep_merged, sweep_plan

__all__ = [
    "Entry", "Jacobian", "Report", "RoutineError", "Scene", "Sweep", "__version__", "audit", "bias", "catalog", "check",
    "geometric_stiffness", "initial", "pattern", "rows",
    "sweep", "sweep_chunk", "sweep_left", "sweep_merged", "sweep_plan",
]
