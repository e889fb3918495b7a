"""Asks a Python function by the protocol pintle-candidate/1."""
import inspect, math
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
class Routine:
    """A function on one state, and what its hello says besides its name."""
    def __init__(self, function, name, own):
        self.function, self.hello, self.connector = function, {"name": name, **own}, None
        try:
            places = [one for one in inspect.signature(function).parameters.values() if one.kind != one.KEYWORD_ONLY]
            self.takes_want = len(places) > 2
        except (TypeError, ValueError):
            self.takes_want = False
    def failed(self, error):
        return {"error": f"{type(error).__name__}: {error}"}
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
            return {"opened": True}
        if "evaluate" in message:
            asked = message["evaluate"]
            return {"id": asked["id"], "answers": self.answers(asked["states"], asked["want"])}
def main():
    import importlib, json, os, sys
    sys.path.insert(0, os.getcwd())
    # What the routine prints belongs on stderr: stdout carries messages.
    messages, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
    name, function = sys.argv[1:3]
    module = importlib.import_module(name)
    routine = module
    for part in function.split("."):
        routine = getattr(routine, part)
    own = {"offers": getattr(module, "OFFERS", ["values", "rows"]), "components": getattr(module, "COMPONENTS", None)}
    own |= {"convention": getattr(module, "CONVENTION", {}), "memory": getattr(module, "MEMORY", False)}
    asked = Routine(routine, f"{name}:{function}", own)
    for line in sys.stdin:
        answer = asked.reply(json.loads(line))
        if answer is None:
            break
        messages.write(json.dumps(answer, allow_nan=False) + "\n")
        messages.flush()
if __name__ == "__main__":
    main()
