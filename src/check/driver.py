"""Asks a Python function by the protocol pintle-candidate/1."""
import inspect, json, math
try:
    import numpy
except ImportError:
    numpy = None
AS_IT_IS = "memory", "out_of_domain", "error"
def plain(x):
    if x is None or isinstance(x, str):
        return x
    if hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, (list, tuple)):
        return [plain(entry) for entry in x]
    x = float(x)
    return x if math.isfinite(x) else "NaN" if x != x else "Infinity" if x > 0 else "-Infinity"
def arrays(x):
    if isinstance(x, dict):
        return {key: arrays(value) for key, value in x.items()}
    if numpy is not None and isinstance(x, list) and x and not isinstance(x[0], (dict, type(None))):
        return numpy.array(x)
    return x
def named(given):
    if not isinstance(given, dict):
        values, rows = given
        given = {"values": values, "rows": rows}
    return {key: value if key in AS_IT_IS else plain(value) for key, value in given.items()}
NODE = [("x", (3,)), ("u", (3,)), ("triad", (3, 3)), ("quaternion", (4,)), ("rotation_vector", (3,)), ("flow", ())]
RATES = [(f"{of}{kind}", shape) for kind in ("velocity", "acceleration") for of, shape in (("", (3,)), ("angular_", (3,)), ("flow_", ()))]
def node(row, keys):
    found, at = {}, 0
    for key, shape in keys:
        size = 1 if not shape else 9 if len(shape) > 1 else shape[0]
        found[key] = row[at:at + size].reshape(shape) if shape else float(row[at])
        at += size
    return found
def states_of(data, count, want):
    """The states of a binary payload: 166 numbers each, in the order of pintle_state in pintle_element.h."""
    keys = NODE + [("increment", (3,))] + (RATES if {"rates", "accelerations"} & {*want} else [])
    for row in numpy.frombuffer(bytearray(data), "<f8").reshape(count, -1):
        previous = {"a": node(row[80:], NODE), "b": node(row[120:], NODE)}
        previous["values"] = arrays([None if x != x else x for x in row[160:].tolist()])
        yield {"a": node(row, keys), "b": node(row[40:], keys), "previous": previous}
def packed(given, want, has, width):
    """The numbers of all answers, state by state; None where one is to be told in words: anything but plain numbers."""
    shapes = {"values": (), "rates": (), "accelerations": (), "rows": (width,), "nodal_forces": (width,)}
    there, absent = [k for k in range(len(has)) if has[k]], [k for k in range(len(has)) if not has[k]]
    found = []
    for key in want:
        shape, whole = shapes.get(key, (width, width)), key.startswith("element")
        lines = [one.get(key) for one in given]
        if any(line is None for line in lines):
            return None
        if whole:
            shape, lines = shape[1:] if key == "element_forces" else shape, [[line] for line in lines]
        elif any(len(line) != len(has) or any(line[k] is not None for k in absent) for line in lines):
            return None
        else:
            lines = [[line[k] for k in there] for line in lines]
        try:
            present = numpy.array(lines, dtype=float)
        except (TypeError, ValueError):
            return None
        if present.shape[2:] != shape or not numpy.isfinite(present).all():
            return None
        if not whole:
            every = numpy.full((len(given), len(has), *shape), math.nan)
            every[:, there] = present
            present = every
        found.append(present.reshape(len(given), -1))
    return numpy.concatenate(found, axis=1).astype("<f8").tobytes()
class Routine:
    """A function on one state, and what its hello says besides its name."""
    def __init__(self, function, name, own):
        self.function, self.hello, self.connector = function, {"name": name, **own}, None
        try:
            places = [one for one in inspect.signature(function).parameters.values() if one.kind != one.KEYWORD_ONLY]
            self.takes_want = len(places) > 2
        except (TypeError, ValueError):
            self.takes_want = False
    # What a routine with a state of its own does besides.
    def begin(self, connector):
        pass
    def commit(self):
        pass
    revert = commit
    def failed(self, error):
        return {"error": f"{type(error).__name__}: {error}"}
    def answer_bytes(self, asked, data):
        """The answer to states as bytes: a message, and bytes after it."""
        want, has = asked["want"], [one is not None for one in self.connector["components"]]
        width = len(self.hello.get("convention", {}).get("columns", range(14)))
        given, plain = [], True
        for state in states_of(data, asked["count"], want):
            try:
                one = self.function(state, self.connector, *([want] if self.takes_want else []))
                if not isinstance(one, dict):
                    one = dict(zip(("values", "rows"), one, strict=True))
                plain = plain and not {*one} & {*AS_IT_IS}
                given.append(one)
            except Exception as error:
                given.append(self.failed(error))
                plain = False
        try:
            out = packed(given, want, has, width) if plain else None
        except Exception:
            out = None
        if out is None:
            return {"id": asked["id"], "answers": [self.told(one) for one in given]}, b""
        return {"id": asked["id"], "bytes": len(out)}, out
    def told(self, given):
        try:
            return named(given)
        except Exception as error:
            return self.failed(error)
    def answer(self, state, want):
        try:
            memory = state.get("previous", {}).pop("memory", None)
            state = arrays(state)
            if memory is not None:
                state["previous"]["memory"] = memory
            return named(self.function(state, self.connector, *([want] if self.takes_want else [])))
        except Exception as error:
            return self.failed(error)
    def answers(self, states, want):
        return [self.answer(state, want) for state in states]
    def reply(self, message):
        """The answer to a message, or None to close."""
        if "hello" in message:
            return {"hello": {"protocol": "pintle-candidate/1", **self.hello}}
        if "open" in message:
            self.connector = arrays(message["open"])
            # Constraints and frictions have equations and forces, and no steps.
            if "components" in self.connector:
                self.begin(self.connector)
            return {"opened": True}
        if "commit" in message:
            self.commit()
            return {"committed": True}
        if "revert" in message:
            self.revert()
            return {"reverted": True}
        if "evaluate" in message:
            asked = message["evaluate"]
            return {"id": asked["id"], "answers": self.answers(asked["states"], asked["want"])}
def own_steps(routine, module, has_memory):
    """begin, commit and revert of the routine itself or its object, else of its module, unless its memory is in its answers."""
    for of in (routine, getattr(routine, "__self__", None), None if has_memory else module):
        if all(callable(getattr(of, word, None)) for word in ("commit", "revert")):
            return {word: getattr(of, word) for word in ("begin", "commit", "revert") if hasattr(of, word)}
    return {}
def main():
    import importlib, os, sys
    sys.path.insert(0, os.getcwd())
    # What the routine prints belongs on stderr: stdout carries messages.
    messages, sys.stdout = os.fdopen(os.dup(1), "wb"), sys.stderr
    name, function = sys.argv[1:3]
    module = importlib.import_module(name)
    routine = module
    for part in function.split("."):
        routine = getattr(routine, part)
    own = {"offers": getattr(module, "OFFERS", ["values", "rows"]), "components": getattr(module, "COMPONENTS", None)}
    own |= {"convention": getattr(module, "CONVENTION", {}), "memory": getattr(module, "MEMORY", False)}
    own["binary"] = numpy is not None and not own["memory"]
    own |= {key: getattr(module, key.upper()) for key in ("types", "domain") if hasattr(module, key.upper())}
    steps = own_steps(routine, module, own["memory"])
    own["commits"] = bool(steps)
    asked = Routine(routine, f"{name}:{function}", own)
    for word, step in steps.items():
        setattr(asked, word, step)
    for line in sys.stdin.buffer:
        message, data = json.loads(line), b""
        count = message.get("evaluate", {}).get("bytes")
        if count is not None:
            answer, data = asked.answer_bytes(message["evaluate"], sys.stdin.buffer.read(count))
        else:
            answer = asked.reply(message)
        if answer is None:
            break
        messages.write(json.dumps(answer, allow_nan=False).encode() + b"\n" + data)
        messages.flush()
if __name__ == "__main__":
    main()
