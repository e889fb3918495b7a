"""Asks a Python function by the protocol pintle-candidate/1."""
import importlib, json, math, os, sys
sys.path.insert(0, os.getcwd())
try:
    import numpy
except ImportError:
    numpy = None
# What the routine prints belongs on stderr: stdout carries messages.
messages, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
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
        given = routine(arrays(state), connector)
        if not isinstance(given, dict):
            values, rows = given
            given = {"values": values, "rows": rows}
        return {key: plain(value) for key, value in given.items()}
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}
name, function = sys.argv[1:3]
module = importlib.import_module(name)
routine = module
for part in function.split("."):
    routine = getattr(routine, part)
convention = getattr(module, "CONVENTION", {})
components = getattr(module, "COMPONENTS", None)
offers = getattr(module, "OFFERS", ["values", "rows"])
connector = None
for line in sys.stdin:
    message = json.loads(line)
    if "hello" in message:
        hello = {"protocol": "pintle-candidate/1", "name": f"{name}:{function}", "offers": offers, "components": components, "convention": convention}
        send({"hello": hello})
    elif "open" in message:
        connector = arrays(message["open"])
        send({"opened": True})
    elif "evaluate" in message:
        asked = message["evaluate"]
        send({"id": asked["id"], "answers": [answer(state, connector, asked["want"]) for state in asked["states"]]})
    elif "close" in message:
        break
