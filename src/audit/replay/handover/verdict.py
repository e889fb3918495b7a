

ROUNDING = 4
"""These formulas round as those of pintle do: by as many tolerances they may miss a right number."""

found = counter_example()
print(ABOUT)
print(f"  given {GIVEN!r}, must be {WANTED!r}, tolerance {TOLERANCE!r}; JAX {found!r}")
if not abs(found - WANTED) <= ROUNDING * TOLERANCE:
    raise SystemExit("JAX does not confirm what must be")
print("JAX confirms what must be")
