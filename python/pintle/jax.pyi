from typing import Protocol

from jax import Array
from jax.typing import ArrayLike

class Values(Protocol):
    components: tuple[str, ...]
    def __call__(self, x_a: ArrayLike, triad_a: ArrayLike, x_b: ArrayLike, triad_b: ArrayLike) -> Array: ...

def rows(of: str) -> Values: ...
