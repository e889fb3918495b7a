def select(less, than, yes, no):
    """yes where less < than, else no."""
    return Piecewise((yes, sympify(less) < sympify(than)), (no, True))


