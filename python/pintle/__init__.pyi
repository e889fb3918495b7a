from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypedDict

from numpy import float64
from numpy.typing import NDArray

__version__: str

_Array = NDArray[float64]
_Offer = Literal[
    "values", "rows", "second_derivatives", "rates", "accelerations", "nodal_forces", "geometric_stiffness",
    "element_forces", "element_stiffness", "criterion", "gradients", "friction_forces", "friction_tangent",
]
_Component = Literal["u1", "u2", "u3", "ur1", "ur2", "ur3"]

class Entry:
    entry: str
    got: float
    want: float
    tolerance: float
    units: float
    state: str | None
    simplest: str | None

class RoutineError(Exception): ...

class Report:
    ok: bool
    verdict: str
    worst: Entry | None
    cause: list[str]
    codes: set[str]
    notes: list[str]
    compared: int
    text: str
    repeat: str
    @property
    def short(self) -> str: ...
    def __bool__(self) -> bool: ...
    def to_json(self) -> str: ...
    def to_html(self) -> str: ...
    def _repr_html_(self) -> str: ...
    def assert_ok(self) -> None: ...

class Connector(TypedDict):
    element: str
    type: str
    nodes: list[str | None]

class Jacobian:
    data: _Array
    indices: _Array
    indptr: _Array
    shape: tuple[int, int]
    @property
    def rows(self) -> list[str]: ...
    @property
    def columns(self) -> list[tuple[str, int]]: ...
    def matrix(self, state: int = 0) -> Any: ...

class Scene:
    def __init__(self, path_or_text: str | PathLike[str]) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def connectors(self) -> list[Connector]: ...
    def evaluate(
        self,
        states: str | PathLike[str] | Sequence[Mapping[str, Any]] | Mapping[str, Any] | None = None,
        outputs: Iterable[str] = ("CP", "CU", "RES"),
        order: Literal[0, 1, 2] = 1,
        *,
        out: dict[str, _Array] | None = None,
    ) -> dict[str, _Array]: ...
    def jacobian(
        self,
        states: str | PathLike[str] | Sequence[Mapping[str, Any]] | Mapping[str, Any] | None = None,
        *,
        out: _Array | None = None,
    ) -> Jacobian: ...

def audit(
    scene: Scene | str | PathLike[str],
    states: str | PathLike[str] | Sequence[Mapping[str, Any]] | None = None,
    *,
    model_only: bool = False,
    seed: str = "pintle",
) -> Report: ...
def catalog() -> dict[str, dict[str, Any]]: ...
def check(
    routine: Callable[..., Any],
    of: str,
    *,
    states: int = 200,
    near_singular_states: int = 50,
    wide_states: int = 30,
    histories: int = 40,
    convention: Mapping[str, Any] | None = None,
    offers: Iterable[_Offer] = ("values", "rows"),
    components: Sequence[_Component] | None = None,
    memory: bool = False,
    domain: dict[str, tuple[float, float]] | None = None,
    springs: Sequence[float | None] | None = None,
    seed: str = "pintle",
    at: str | PathLike[str] | None = None,
    independent: bool = False,
    batch: bool = False,
) -> Report: ...
def rows(
    of: str,
    x_a: _Array,
    triad_a: _Array,
    x_b: _Array,
    triad_b: _Array,
    *,
    columns: Literal[14, 12, 9, "sparse"] | Sequence[int] | None = None,
    components: Sequence[int] | None = None,
    out: tuple[_Array, _Array] | None = None,
) -> tuple[_Array, _Array]: ...
def bias(
    of: str,
    x_a: _Array,
    triad_a: _Array,
    x_b: _Array,
    triad_b: _Array,
    v_a: _Array,
    w_a: _Array,
    v_b: _Array,
    w_b: _Array,
    *,
    components: Sequence[int] | None = None,
    out: _Array | None = None,
) -> _Array: ...
def geometric_stiffness(
    of: str,
    x_a: _Array,
    triad_a: _Array,
    x_b: _Array,
    triad_b: _Array,
    forces: _Array | Sequence[float],
    *,
    along: tuple[_Array, _Array, _Array, _Array] | None = None,
    components: Sequence[int] | None = None,
    out: _Array | None = None,
) -> _Array: ...
def pattern(of: str, *, components: Sequence[int] | None = None) -> tuple[_Array, _Array]: ...
def initial(of: str) -> tuple[_Array, _Array, _Array]: ...

class Sweep:
    text: str
    digest: str
    summary: dict[str, Any]
    @property
    def states(self) -> int: ...
    @property
    def wrong(self) -> int: ...
    @property
    def compared(self) -> int: ...
    def picture(self) -> str: ...
    def _repr_svg_(self) -> str: ...

def sweep(
    *of: str | PathLike[str],
    states: int | float = 1_000_000,
    out: str | PathLike[str] | None = None,
    engine: Literal["joblib", "dask", "ray"] | None = None,
    workers: int | None = None,
    threads: int = 1,
    chunk_states: int | float = 1_000_000,
    oracle_share: float = 1e-3,
    generator: Literal["philox", "sobol"] = "philox",
    seed: str = "pintle",
    python: str | None = None,
    library: str | PathLike[str] | None = None,
    with_: str | None = None,
    convention: str | PathLike[str] | Mapping[str, Any] | None = None,
    timeout: float = 10.0,
    progress: Callable[[int, int], object] | Literal[True] | None = None,
) -> Sweep: ...
def sweep_plan(
    *of: str | PathLike[str],
    oracle_share: float = 1e-3,
    generator: Literal["philox", "sobol"] = "philox",
    seed: str = "pintle",
    python: str | None = None,
    library: str | PathLike[str] | None = None,
    with_: str | None = None,
    convention: str | PathLike[str] | Mapping[str, Any] | None = None,
) -> str: ...
def sweep_left(
    plan: str, *, states: int | float = 1_000_000, chunk_states: int | float = 1_000_000, out: str | PathLike[str] | None = None
) -> list[tuple[int, int]]: ...
def sweep_chunk(
    plan: str,
    part: tuple[int, int],
    *,
    out: str | PathLike[str] | None = None,
    threads: int = 1,
    timeout: float = 10.0,
) -> str | None: ...
def sweep_merged(plan: str, texts: Iterable[str] = (), *, out: str | PathLike[str] | None = None) -> Sweep: ...
