"""Strategies of Hypothesis for states; the extra `pintle[hypothesis]` brings it."""

from hypothesis import strategies

from . import _check, _pintle


class _Seen(_check._driver.Routine):
    """Keeps the states it is asked for."""

    def __init__(self):
        super().__init__(lambda state, connector: None, "a strategy", {"offers": ["values"]})
        self.states = []

    def answers(self, states, want):
        self.states += [_check._driver.arrays(state) for state in states]
        return [{"out_of_domain": "it is drawn, not judged"} for _ in states]


def _drawn(of, seed, near_singular, history):
    seen = _Seen()
    drawn = {"states": int(not near_singular), "near_singular_states": int(near_singular), "histories": int(history)}
    _pintle.ask(seen.reply, of, seed=f"hypothesis {seed}", wide_states=0, **drawn)
    return seen.states[0], seen.connector


def states(of, *, near_singular=False, history=False):
    """States of a connector, drawn as a check draws them: pairs `(state, connector)`, as a routine gets them.

    `near_singular` draws near the singular sets of the type, `history` at the end of a history through half
    a turn and whole ones. A failing example is repeated by its seed; it is not made smaller.
    """
    _pintle.ask(_Seen().reply, of, states=1, near_singular_states=0, wide_states=0, histories=0, seed="known")
    seeds = strategies.integers(min_value=0, max_value=2**32 - 1)
    return seeds.map(lambda seed: _drawn(of, seed, near_singular, history))
