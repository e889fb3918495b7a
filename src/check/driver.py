"""Asks a Python function by the protocol pintle-candidate/1."""
import importlib, inspect, json, math, os, sys
sys.path.insert(0, os.getcwd())
try:
    import numpy
except ImportError:
    numpy = None
# What the routine prints belongs on stderr: stdout carries messages.
messages, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
AS_IT_IS = "memory", "out_of_domain", "error"
def send(message):
    messages.write(json.dumps(message, allow_nan=False) + "\n")
    messages.flush()
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
def answer(state, connector, want):
    try:
        memory = state.get("previous", {}).pop("memory", None)
        state = arrays(state)
        if memory is not None:
            state["previous"]["memory"] = memory
        given = routine(state, connector, want) if takes_want else routine(state, connector)
        if not isinstance(given, dict):
            values, rows = given
            given = {"values": values, "rows": rows}
        return {key: value if key in AS_IT_IS else plain(value) for key, value in given.items()}
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}
name, function = sys.argv[1:3]
module = importlib.import_module(name)
routine = module
for part in function.split("."):
    routine = getattr(routine, part)
try:
    takes_want = len(inspect.signature(routine).parameters) > 2
except (TypeError, ValueError):
    takes_want = False
own = {"offers": getattr(module, "OFFERS", ["values", "rows"]), "components": getattr(module, "COMPONENTS", None)}
own |= {"convention": getattr(module, "CONVENTION", {}), "memory": getattr(module, "MEMORY", False)}
connector = None
for line in sys.stdin:
    message = json.loads(line)
    if "hello" in message:
        send({"hello": {"protocol": "pintle-candidate/1", "name": f"{name}:{function}", **own}})
    elif "open" in message:
        connector = arrays(message["open"])
        send({"opened": True})
    elif "evaluate" in message:
        asked = message["evaluate"]
        send({"id": asked["id"], "answers": [answer(state, connector, asked["want"]) for state in asked["states"]]})
    elif "close" in message:
        break
