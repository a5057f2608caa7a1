"""The compiled part of the mesocrete package."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__ = [
    "Aggregate",
    "Aggregates",
    "Frame",
    "Mesh",
    "Packing",
    "Polyhedron",
    "Response",
    "Spec",
    "__version__",
    "_restore_aggregate",
    "_restore_packing",
    "_restore_polyhedron",
    "_restore_spec",
    "_run_command",
    "convex_hull",
    "distance",
    "intersects",
    "intersects_many",
    "load",
    "pack",
]

_Path: TypeAlias = str | PathLike[str]

@final
class Spec:
    """Everything that determines a model; omitted options keep their defaults, the paper's specimen."""

    def __new__(cls, **options: Any) -> Spec: ...
    @staticmethod
    def from_toml(text: str) -> Spec: ...
    @staticmethod
    def read(path: _Path) -> Spec: ...
    @property
    def seed(self) -> int: ...
    @property
    def fraction(self) -> float: ...
    @property
    def specimen(self) -> dict[str, Any]: ...
    @property
    def grading(self) -> dict[str, Any]: ...
    @property
    def shape(self) -> dict[str, Any]: ...
    @property
    def itz(self) -> dict[str, Any]: ...
    @property
    def placement(self) -> dict[str, Any]: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_toml(self) -> str: ...
    def replace(self, **changes: Any) -> Spec: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Spec: ...
    def __deepcopy__(self, _memo: Any) -> Spec: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Polyhedron:
    """A closed convex polyhedron, mm."""

    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> list[list[int]]: ...
    @property
    def triangles(self) -> NDArray[np.int64]: ...
    @property
    def volume(self) -> float: ...
    @property
    def area(self) -> float: ...
    @property
    def centroid(self) -> NDArray[np.float64]: ...
    def offset(self, thickness: float) -> Polyhedron | None: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Polyhedron: ...
    def __deepcopy__(self, _memo: Any) -> Polyhedron: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Aggregate:
    """One aggregate, or one void or fibre, at its place in the specimen."""

    @property
    def id(self) -> int: ...
    @property
    def phase(self) -> str: ...
    @property
    def size_class(self) -> int: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> list[list[int]]: ...
    @property
    def triangles(self) -> NDArray[np.int64]: ...
    @property
    def volume(self) -> float: ...
    @property
    def area(self) -> float:
        """Surface of the outer body, mm2."""

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centre of volume, mm: shape (3,)."""

    @property
    def size(self) -> float:
        """Longest distance of two vertices, mm."""

    @property
    def sieve_size(self) -> float:
        """Side of the smallest square hole that it passes, mm."""

    @property
    def itz_thickness(self) -> float: ...
    @property
    def body(self) -> Polyhedron: ...
    def core(self) -> Polyhedron | None: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Aggregate: ...
    def __deepcopy__(self, _memo: Any) -> Aggregate: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Aggregates:
    """The aggregates of a packing, in descending volume: a sequence, and arrays of their properties."""

    @property
    def volume(self) -> NDArray[np.float64]:
        """Volumes, mm3: shape (n,)."""

    @property
    def area(self) -> NDArray[np.float64]:
        """Surfaces, mm2: shape (n,)."""

    @property
    def size(self) -> NDArray[np.float64]:
        """Longest distances of two vertices, mm: shape (n,)."""

    @property
    def sieve_size(self) -> NDArray[np.float64]:
        """Sides of the smallest square holes that they pass, mm: shape (n,)."""

    @property
    def itz_thickness(self) -> NDArray[np.float64]:
        """Thicknesses of the ITZ shells, mm: shape (n,)."""

    @property
    def size_class(self) -> NDArray[np.int64]:
        """Indices of the size classes, from the finest: shape (n,)."""

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centres of volume, mm: shape (n, 3)."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Aggregate]: ...
    @overload
    def __getitem__(self, key: int, /) -> Aggregate: ...
    @overload
    def __getitem__(self, key: slice, /) -> list[Aggregate]: ...
    def index(self, value: object, start: int = 0, stop: int | None = None) -> int: ...
    def count(self, value: object) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Packing:
    """A packed specimen."""

    @property
    def fraction(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def spec(self) -> Spec: ...
    @property
    def aggregates(self) -> Aggregates: ...
    @property
    def inclusions(self) -> list[Aggregate]: ...
    @property
    def bounds(self) -> tuple[list[float], list[float]]: ...
    def report(self) -> dict[str, Any]:
        """Return the result without wall times: equal runs have equal reports."""

    @property
    def work(self) -> dict[str, Any]:
        """What the result cost: counters, and wall times by stage under `seconds`."""

    def table(self) -> dict[str, NDArray[Any]]:
        """Return every aggregate, void and fibre as a row of columns, as `pandas.DataFrame` takes it."""

    def write(
        self, path: _Path, *, overwrite: bool = True, compress: bool = False, images: str = "none"
    ) -> None: ...
    def specimen_surface(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]: ...
    def check(self) -> dict[str, Any]: ...
    def statistics(
        self, *, progress: bool | Callable[[float, float], object] | None = None, **options: Any
    ) -> dict[str, Any]: ...
    def voxelize(
        self,
        h: float,
        what: Literal["phase", "grain", "share", "distance"] = "phase",
        box: Sequence[Sequence[float]] | None = None,
        *,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[Any]:
        """Return what is at every voxel of edge `h`, mm: an array [z, y, x] in C order.

        `what` is "phase" (uint8: 0 mortar, 1 ITZ, 2 aggregate, 3 void, 4 fibre, 255 outside), "grain" (int32: the id,
        -1 in the mortar, -2 outside), "share" (float32, of the voxel's volume, whose by `of`) or "distance" (float32, mm
        to the nearest surface, negative inside, NaN outside). `box` is a part by its lower and upper corner, mm.
        """

    def section(
        self,
        axis: Literal["x", "y", "z"],
        at: float,
        px: int = 512,
        what: Literal["phase", "grain", "share", "distance"] = "phase",
        *,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[Any]:
        """Return what is on the plane across `axis` at `at` mm, `px` pixels along its longer side; lowest row first."""

    def mesh(
        self,
        *,
        method: str | None = None,
        element_size: float | None = None,
        progress: bool | Callable[[float, float], object] | None = None,
        **options: Any,
    ) -> Mesh: ...
    def to_pyvista(self, **options: Any) -> Any: ...
    def plot(self, **options: Any) -> Any: ...
    def plot_grading(self, **options: Any) -> Any: ...
    def _repr_html_(self) -> str: ...
    def _section_svg(self, axis: int, at: float) -> str: ...
    def _asked_curve(self) -> tuple[list[float], list[float]]: ...
    def _surfaces(self, images: str) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Packing: ...
    def __deepcopy__(self, _memo: Any) -> Packing: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Mesh:
    """A mesh of a packing."""

    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def cells(self) -> NDArray[np.int64]: ...
    @property
    def cell_type(self) -> str: ...
    @property
    def phase(self) -> NDArray[np.uint8]: ...
    @property
    def aggregate(self) -> NDArray[np.int64]: ...
    @property
    def cohesive(self) -> NDArray[np.int64]: ...
    @property
    def notes(self) -> dict[str, float]: ...
    def volumes(self) -> dict[str, float]: ...
    def quality(self) -> dict[str, Any]: ...
    def mass_scaling(self, time_step_s: float = 5e-7) -> dict[str, Any]: ...
    def bad_cells(self, degrees: float) -> NDArray[np.int64]: ...
    def write(self, path: _Path, *, overwrite: bool = True, compress: bool = False, **deck: Any) -> None: ...
    def solve(
        self,
        test: str = "compression",
        *,
        materials: dict[str, Any] | None = None,
        threads: int | None = None,
        progress: bool | Callable[[float, float], object] | None = None,
        **options: Any,
    ) -> Response:
        """Test the specimen between rigid plates along z, and return its curve, figures and fields.

        `options` are `friction`, `strain`, `law`, `frames`, `duration_s`, `time_step_s`, `ramp`, `rows`, `itz`, `joined`,
        `hourglass` and `interface`.
        """

    def to_pyvista(self) -> Any: ...
    def plot(self, **options: Any) -> Any:
        """Show the mesh by phase; `cut`, `phases`, `screenshot`, and options of `pyvista.Plotter.add_mesh`."""

    def to_meshio(self) -> Any: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Mesh: ...
    def __deepcopy__(self, _memo: Any) -> Mesh: ...

@final
class Response:
    """The test of a mesh: stress and strain, energies, figures and fields."""

    @property
    def curve(self) -> dict[str, NDArray[np.float64]]:
        """The curve, row by row, by the names of `curve.csv`."""

    @property
    def result(self) -> dict[str, Any]:
        """The figures of the test, as in `result.json`."""

    @property
    def frames(self) -> list[Frame]:
        """The frames that were asked for, in their order."""

    @property
    def last(self) -> Frame | None:
        """The end of the test; None where it diverged."""

    def plot(self, **options: Any) -> Any:
        """Draw stress over strain with the peak; return the matplotlib axes."""

    def to_pyvista(self, frame: int | None = None) -> Any:
        """Return a frame, by its place in `frames`, or the end, as a PyVista grid with all fields."""

    def write(self, folder: _Path, *, overwrite: bool = True) -> None:
        """Write curve, figures, frames and page into a folder, all or none."""

    def __copy__(self) -> Response: ...
    def __deepcopy__(self, _memo: Any) -> Response: ...

@final
class Frame:
    """The fields of a moment of a test; arrays are float32, one row for each node or cell."""

    @property
    def strain(self) -> float:
        """Mean axial strain, positive in the test's sense."""

    @property
    def stress_mpa(self) -> float:
        """Stress of the curve's latest row, MPa."""

    @property
    def time_s(self) -> float:
        """Time in the test, s."""

    @property
    def displacement(self) -> NDArray[np.float32]:
        """Of every node, mm: shape (n, 3)."""

    @property
    def stress(self) -> NDArray[np.float32]:
        """In every cell, xx yy zz xy yz zx, MPa, tension positive: shape (m, 6)."""

    @property
    def damage(self) -> NDArray[np.float32]:
        """Share of its stiffness that every cell has lost: shape (m,)."""

    @property
    def damage_tension(self) -> NDArray[np.float32]:
        """Damage in tension, 0 to 1: shape (m,)."""

    @property
    def damage_compression(self) -> NDArray[np.float32]:
        """Damage in compression, 0 to 1: shape (m,)."""

    @property
    def crack_opening_mm(self) -> NDArray[np.float32]:
        """Opening of the crack in every cell, mm: shape (m,)."""

    @property
    def phase(self) -> NDArray[np.uint8]:
        """Phase that every cell has in the test: shape (m,)."""

    def _mesh(self) -> tuple[NDArray[np.float64], NDArray[np.int64], str]: ...
    def __copy__(self) -> Frame: ...
    def __deepcopy__(self, _memo: Any) -> Frame: ...

def pack(
    spec: Spec | dict[str, Any] | _Path | None = None,
    *,
    seed: int | None = None,
    fraction: float | None = None,
    progress: bool | Callable[[float, float], object] | None = None,
) -> Packing: ...
def load(path: _Path) -> Packing: ...
def convex_hull(points: ArrayLike) -> Polyhedron: ...
def intersects(a: ArrayLike, b: ArrayLike, method: str = "enhanced") -> bool: ...
def distance(a: ArrayLike, b: ArrayLike) -> float: ...
def intersects_many(
    a: ArrayLike, bodies: Iterable[ArrayLike], method: str = "enhanced"
) -> NDArray[np.bool_]: ...
def _run_command(args: list[str]) -> int: ...
def _restore_spec(options: dict[str, Any]) -> Spec: ...
def _restore_polyhedron(vertices: ArrayLike, faces: list[list[int]]) -> Polyhedron: ...
def _restore_aggregate(
    body: Polyhedron, id: int, size_class: int, itz_thickness: float, phase: str = "aggregate"
) -> Aggregate: ...
def _restore_packing(model: bytes, report: str) -> Packing: ...
