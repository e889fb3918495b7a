from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, NoReturn

import numpy
from numpy.typing import NDArray

__version__: str

class Report:
    ok: bool
    verdict: str
    worst: dict[str, Any] | None
    cause: list[str]
    codes: list[str]
    text: str
    def to_json(self) -> str: ...
    def to_html(self) -> str: ...
    def assert_ok(self) -> None: ...
    def __bool__(self) -> bool: ...

def check(
    routine: Callable[..., Any],
    of: str,
    *,
    offers: Iterable[str] = ...,
    components: Sequence[str] | None = ...,
    convention: dict[str, Any] | None = ...,
    memory: bool = ...,
    springs: Sequence[float | None] | None = ...,
    states: int = ...,
    near_singular_states: int = ...,
    wide_states: int = ...,
    histories: int = ...,
    seed: str = ...,
) -> Report: ...

class Scene:
    path: str
    connectors: list[tuple[str, str, list[bool]]]
    def __init__(self, path: str | PathLike[str]) -> None: ...
    def evaluate(
        self,
        states: str | PathLike[str] | None = ...,
        outputs: str | Iterable[str] = ...,
        order: int = ...,
        independent: bool = ...,
    ) -> dict[str, NDArray[numpy.float64]]: ...

def audit(scene: Scene | str | PathLike[str], seed: str = ...) -> Report: ...
def catalog() -> dict[str, list[str | None]]: ...
def main() -> NoReturn: ...
