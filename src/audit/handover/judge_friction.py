# The same number by these formulas


def numbers(value):
    """Doubles are written in hexadecimal."""
    if isinstance(value, dict):
        return {name: numbers(part) for name, part in value.items()}
    if isinstance(value, list):
        return [numbers(part) for part in value]
    if isinstance(value, str) and value.lstrip("-").startswith("0x"):
        return float.fromhex(value)
    return value


def functions():
    """What is differentiated, of every branch that the increment may take, and where."""
    case = numbers(VALUES) | {"returned_along": RETURNED_ALONG}
    if KIND == "belt":
        belt = Belt(case)
        if OF == "increment":
            return belt.solutions(), jnp.zeros(5)
        at = jnp.array([*case["tension"], case["angle"]])
        return [lambda t, mu=mu: belt_parts(t, mu, case["belt"]["maximum"]) for mu in belt.coefficients()], at
    friction = Friction(case, NAMED)
    if OF == "increment":
        return friction.solutions(), jnp.zeros(13)
    return [friction.parts], jnp.array(case["point"])


def counter_example():
    """The number that is nearest to what must be, of all between both sides of a kink, and of every branch that rounding may choose."""
    output, *inputs = PLACE
    found = []
    for side in (1.0, -1.0):
        SIDE[0] = side
        all_functions, at = functions()
        row = []
        for function in all_functions:
            asked = lambda y: function(y)[output]
            for j in inputs:
                asked = derivative(asked, jnp.eye(len(at))[j])
            row.append(float(asked(at)))
        found.append(row)
    known = [sides for sides in zip(*found) if all(np.isfinite(x) for x in sides)]
    if not known:
        raise SystemExit(f"undecided: the formulas give {found}, which are no finite numbers")
    near = [min(max(WANTED, min(sides)), max(sides)) for sides in known]
    return min(near, key=lambda x: abs(x - WANTED))


