"""Asks a Python function by the protocol pintle-candidate/1."""
import importlib, inspect, json, math, os, sys, traceback
try:
    import numpy
except ImportError:
    numpy = None
AS_IT_IS = "memory", "out_of_domain", "error"


def plain(x):
    """Numbers and lists of them, as JSON has them."""
    if x is None or isinstance(x, str):
        return x
    if hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, (list, tuple)):
        return [plain(entry) for entry in x]
    x = float(x)
    return x if math.isfinite(x) else "NaN" if x != x else "Infinity" if x > 0 else "-Infinity"


def arrays(x):
    """Lists of numbers as arrays, where NumPy is installed."""
    if isinstance(x, dict):
        return {key: value if key == "memory" else arrays(value) for key, value in x.items()}
    if numpy is not None and isinstance(x, list) and x and not isinstance(x[0], (dict, type(None), str)):
        return numpy.array([math.nan if entry is None else entry for entry in x])
    return x


class Driver:
    """A function, and what it is besides: offers, components, convention, memory."""

    def __init__(self, routine, name, offers=("values", "rows"), components=None, convention=None, memory=False):
        self.routine, self.error, self.connector = routine, None, None
        self.hello = {"protocol": "pintle-candidate/1", "name": name, "offers": list(offers), "components": components}
        self.hello |= {"convention": convention or {}, "memory": memory}
        try:
            self.takes_want = len(inspect.signature(routine).parameters) > 2
        except (TypeError, ValueError):
            self.takes_want = False

    def at(self, state, want):
        """The answer at one state; an exception is kept, and told as what it is."""
        try:
            state = arrays(state)
            given = self.routine(state, self.connector, want) if self.takes_want else self.routine(state, self.connector)
            if not isinstance(given, dict):
                values, rows = given
                given = {"values": values, "rows": rows}
            return {key: value if key in AS_IT_IS else plain(value) for key, value in given.items()}
        except Exception as error:
            self.error = error
            place = traceback.extract_tb(error.__traceback__)[-1]
            return {"error": f"{type(error).__name__}: {error} ({os.path.basename(place.filename)}:{place.lineno})"}

    def answer(self, message):
        """The answer to a message; None where it ends."""
        if "hello" in message:
            return {"hello": self.hello}
        if "open" in message:
            self.connector = arrays(message["open"])
            return {"opened": True}
        if "evaluate" in message:
            asked = message["evaluate"]
            return {"id": asked["id"], "answers": [self.at(state, asked["want"]) for state in asked["states"]]}
        return None

    def line(self, line):
        """The same as text."""
        answer = self.answer(json.loads(line))
        return None if answer is None else json.dumps(answer, allow_nan=False)


def main():
    sys.path.insert(0, os.getcwd())
    # What the routine prints belongs on stderr: stdout carries messages.
    messages, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
    name, function = sys.argv[1:3]
    module = importlib.import_module(name)
    routine = module
    for part in function.split("."):
        routine = getattr(routine, part)
    named = {"offers": "OFFERS", "components": "COMPONENTS", "convention": "CONVENTION", "memory": "MEMORY"}
    given = {key: getattr(module, of) for key, of in named.items() if hasattr(module, of)}
    driver = Driver(routine, f"{name}:{function}", **given)
    for line in sys.stdin:
        answer = driver.line(line)
        if answer is None:
            break
        messages.write(answer + "\n")
        messages.flush()


if __name__ == "__main__":
    main()
