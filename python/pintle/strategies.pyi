from typing import Any

from hypothesis.strategies import SearchStrategy

def states(
    of: str, *, near_singular: bool = False, history: bool = False
) -> SearchStrategy[tuple[dict[str, Any], dict[str, Any]]]: ...
