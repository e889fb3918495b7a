# The same number by these formulas


def counter_example():
    """The equation in question, differentiated by those of the 16 degrees of freedom, and of time along the rates, that are asked for."""
    vectors = {f"theta_{node}": np.asarray(principal_vector(jnp.asarray(quaternion_of(c)))) for node, c in ROTATIONS.items()}
    case = {"kind": KIND, "X": PLACES, "phi": [0.0, 0.0]} | STATE | vectors
    still = equations(case, KIND)(jnp.zeros(16))
    hinges = HINGES[KIND] or 0
    implied = [float(angle) for angle in still[len(still) - hinges :]] + [0.0, 0.0]
    case["phi"] = [implied[i] if angle is None else angle for i, angle in enumerate(ANGLES)]
    function, rates = equations(case, KIND), {"rates": jnp.array(RATES), "accelerations": jnp.array(ACCELERATIONS)}
    row, *variables = PLACE
    asked = lambda y: function(y[:16] + along(rates, y[16]))[row]
    for j in variables:
        asked = derivative(asked, jnp.eye(17)[j])
    return float(asked(jnp.zeros(17)))


def derivative(function, direction):
    return lambda y: jax.jvp(function, (y,), (direction,))[1]
