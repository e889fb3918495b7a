"""A check of a callable: the questions, conventions and verdicts of `pintle check`, asked in this process."""

import sys
import types

from . import _pintle

_driver = types.ModuleType("pintle._driver")
exec(compile(_pintle.DRIVER, "pintle/_driver.py", "exec"), _driver.__dict__)


class RoutineError(Exception):
    """The routine raised an exception, which is the cause of this one. It is no wrong number."""


class _Routine(_driver.Routine):
    """Remembers the exception of the routine, with its traceback."""

    raised = None

    def failed(self, error):
        self.raised = error
        return super().failed(error)


def _stacked(states):
    """The leaves of states along a new first axis; what is not there is NaN."""
    import numpy

    first = states[0]
    if isinstance(first, dict):
        return {key: _stacked([state[key] for state in states]) for key in first}
    return numpy.array(states, dtype=float)


class _Batch(_Routine):
    """A routine on stacked states."""

    def answers(self, states, want):
        import numpy

        try:
            given = self.given(_stacked(states), self.connector, want, len(states))
            if not isinstance(given, dict):
                values, rows = given
                given = {"values": values, "rows": rows}
            given = {key: numpy.asarray(value) for key, value in given.items()}
            for key, value in given.items():
                if value.dtype != numpy.float64:
                    remedy = 'call jax.config.update("jax_enable_x64", True) first' if self.is_jax else "convert to float64"
                    raise TypeError(f"{key} is an array of {value.dtype}, whose digits are too few: {remedy}")
                if "sliding" not in self.connector and value.shape[:2] != (len(states), len(self.parts())):
                    count = len(self.parts())
                    raise ValueError(f"{key} has the shape {value.shape}, not ({len(states)}, {count}, …): one for each state and component")
            if "sliding" in self.connector:
                # Of a friction nothing is missing but what is NaN.
                return [{key: [_absent(x) for x in value[i]] for key, value in given.items()} for i in range(len(states))]
            has = [component is not None for component in self.parts()]
            return [
                {
                    key: [_driver.plain(value[i, k]) if has[k] else _absent(value[i, k]) for k in range(len(has))]
                    for key, value in given.items()
                }
                for i in range(len(states))
            ]
        except Exception as error:
            return [self.failed(error)] * len(states)

    is_jax = False

    def parts(self):
        """The components of a connector, or the equations of a constraint."""
        return self.connector["components" if "components" in self.connector else "equations"]

    def given(self, states, connector, want, count):
        return self.function(states, connector, *([want] if self.takes_want else []))


def _absent(value):
    """What a component that the connector has not may be: NaN. Anything else is judged."""
    import numpy

    return None if numpy.isnan(value).all() else _driver.plain(value)


class _Jax(_Batch):
    """A jitted function on one state, mapped over as many states as the next power of two, so that few shapes are compiled."""

    is_jax = True

    def given(self, states, connector, want, count):
        import jax
        import numpy

        size = 1 << (count - 1).bit_length()
        padded = jax.tree.map(lambda x: numpy.concatenate([x, numpy.repeat(x[-1:], size - count, axis=0)]), states)
        named = ("initial", "flow_scale", "axes", "coefficient", "parameters")
        numbers = {key: connector[key] for key in named if key in connector}
        given = jax.vmap(self.function, in_axes=(0, None))(padded, numbers)
        return jax.tree.map(lambda x: numpy.asarray(x)[:count], given)


def _is_jitted(routine):
    jax = sys.modules.get("jax")
    return jax is not None and isinstance(routine, jax.stages.Wrapped)


class Report:
    """What a check or an audit found.

    Attributes: `ok`, `verdict`, `worst` (`entry`, `got`, `want`, `tolerance`, `units`, `state`, `simplest`), `cause`
    (sentences), `codes`, `notes`, `compared`, `text`, and `repeat`, the line that repeats it.
    """

    def __init__(self, found, repeat):
        self._found = found
        self.repeat = repeat

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._found, name)

    def __dir__(self):
        return [*super().__dir__(), *(name for name in dir(self._found) if not name.startswith("_"))]

    def __bool__(self):
        return self.ok

    @property
    def short(self):
        """The matrix with the wrong entries, the cause, and the line that repeats it: what is printed of a failure."""
        found = self._found
        lines = [f"verdict: {found.verdict}, {found.compared} numbers compared"]
        if found.worst is not None:
            lines.append(f"worst: {found.worst!r}")
            if found.worst.simplest is not None:
                lines.append(f"simplest state at which it is wrong: {found.worst.simplest}")
        lines += found.cause + [f"note: {note}" for note in found.notes]
        if not found.ok:
            lines += ["", found.text.rstrip()]
        return "\n".join([*lines, f"repeat: {self.repeat}"])

    def __repr__(self):
        return self.short

    def _repr_html_(self):
        import html

        page = html.escape(self._found.to_html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'

    def assert_ok(self):
        """Raises AssertionError with the short text, unless every number is verified to be right."""
        __tracebackhide__ = True
        if not self.ok:
            raise AssertionError(self.short)


def _name(routine, between="."):
    module, name = getattr(routine, "__module__", None), getattr(routine, "__qualname__", None)
    return f"{module}{between}{name}" if module and name else type(routine).__name__


def check(
    routine,
    of,
    *,
    states=200,
    near_singular_states=50,
    wide_states=30,
    histories=40,
    convention=None,
    offers=("values", "rows"),
    components=None,
    memory=False,
    domain=None,
    springs=None,
    seed="pintle",
    at=None,
    independent=False,
    batch=False,
):
    """Is a routine right, and if not, which entry is wrong, and why?

    `routine(state, connector)` gets dictionaries of NumPy arrays, float64, lengths in the unit of the scene,
    angles in rad, global axes: `state["a"]["x"]` (3,), `["triad"]` (3, 3) with the directions e1, e2, e3 as
    rows, `["increment"]` (3,) …, `state["previous"]`, `connector["initial"]`. docs/reference/protocol.md has
    all keys. It returns values (6) and rows (6 × 14; columns x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b), None where the
    connector has no such component; or a dictionary of what it offers.

    `of` is a connection type, "REVOLUTE", two basic ones, "CARTESIAN CARDAN", or a connector of a scene,
    "model.inp:106", "gallery:slider_crank:106". "MPC REVOLUTE" is a multi-point constraint, with seven equations
    in place of components; "FRICTION HINGE" a friction: docs/reference/protocol.md has their keys.

    With `batch=True` the arrays have one more axis, the first, of states: `state["a"]["x"]` is (n, 3). The
    routine returns arrays (n, 6) and (n, 6, 14), NaN for components that the connector has not. A function
    jitted by JAX on one state is mapped over batches; it needs `jax_enable_x64`, and gets of the connector
    what is a number.

    `at` is a file with your own states, asked in place of drawn ones: nodes 1 (a) and 2 (b) of a type, those of the
    scene otherwise; a history, unless they are `independent`.

    `domain` is where states are drawn: `{"x1": [-0.1, 0.1], "r3": [0, 1]}`, places of b seen from a and angles of b
    against a. A routine with the methods `commit` and `revert` (and `begin`, which gets the connector) keeps its
    memory itself.

    `springs` are six stiffnesses, None for none, of an element that gives element_forces. `convention`, `offers`,
    `components` and `memory` are those of the protocol; the others those of `pintle check`.

    Raises RoutineError where the routine raises at the first states, from its exception (where it raises at some
    others, it has no numbers there, and the report says so); ValueError where it answers in another shape, or
    answers the same question differently, or where there is no such connector.
    """
    is_jitted = _is_jitted(routine)
    if is_jitted and memory:
        raise ValueError("a jitted function keeps no memory: pass a function on one state that calls it")
    kind = _Jax if is_jitted and not batch else _Batch if batch else _Routine
    if domain is not None and of.split(maxsplit=1)[0].upper() in ("MPC", "FRICTION"):
        raise ValueError(f"{of} has no domain: it limits places and turns of a connector")
    own = {"offers": list(offers), "components": components, "convention": convention or {}, "memory": memory}
    if domain is not None:
        own["domain"] = domain
    steps = _driver.own_steps(routine, None, memory)
    own["commits"] = bool(steps)
    # The name that the command gives it, so that both say the same.
    asked = kind(routine, _name(routine, ":"), own)
    asked.is_jax = is_jitted
    for word, step in steps.items():
        setattr(asked, word, step)
    numbers = {
        "states": states,
        "near_singular_states": near_singular_states,
        "wide_states": wide_states,
        "histories": histories,
        "springs": [None if x is None else float(x) for x in (*(springs or ()), *[None] * 6)][:6],
        "seed": seed,
        "at": at,
        "independent": independent,
    }
    try:
        found = _pintle.ask(asked.reply, of, **numbers)
    except ValueError:
        if asked.raised is not None:
            raise RoutineError(f"{_name(routine)} raised {type(asked.raised).__name__}: {asked.raised}") from asked.raised
        raise
    given = {**numbers, "springs": springs, "convention": convention, "components": components, "memory": memory, "domain": domain, "batch": batch}
    given["offers"] = tuple(offers)
    default = check.__kwdefaults__
    said = "".join(f", {key}={value!r}" for key, value in given.items() if value != default[key])
    return Report(found, f"pintle.check({_name(routine)}, {of!r}{said})")
