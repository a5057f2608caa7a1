"""The compiled part of the mesocrete package."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypedDict, final, overload

import meshio  # type: ignore[import-not-found, import-untyped, unused-ignore]
import numpy as np
import pandas as pd  # type: ignore[import-not-found, import-untyped, unused-ignore]
import polars as pl  # type: ignore[import-not-found, import-untyped, unused-ignore]
from matplotlib.axes import Axes  # type: ignore[import-not-found, import-untyped, unused-ignore]
from numpy.typing import ArrayLike, NDArray
from pyvista import Plotter, PolyData, UnstructuredGrid  # type: ignore[import-not-found, import-untyped, unused-ignore]
from typing_extensions import Unpack

from . import _results, _types
from ._effective import Effective
from ._executor import Submitter
from ._types import DeckOptions, MeshOptions, SolveOptions, SpecOptions, StatisticsOptions

__version__: str
__all__ = [
    "Aggregate",
    "Aggregates",
    "Bodies",
    "Frame",
    "Mesh",
    "Packing",
    "Polyhedron",
    "Response",
    "Spec",
    "_Fit",
    "_Lock",
    "_StudyCase",
    "_StudyPlan",
    "_StudyRun",
    "__version__",
    "_checked_test",
    "_colours",
    "_concrete_materials",
    "_restore_aggregate",
    "_restore_frame",
    "_restore_mesh",
    "_restore_packing",
    "_restore_polyhedron",
    "_restore_response",
    "_restore_spec",
    "_run_command",
    "_study_case",
    "_study_results",
    "_usual_threads",
    "closest_points",
    "convex_hull",
    "distance",
    "effective",
    "from_labels",
    "intersects",
    "intersects_many",
    "load",
    "pack",
    "penetration",
    "recipes",
    "time_of_impact",
]

_Path: TypeAlias = str | PathLike[str]
_Axis: TypeAlias = Literal["x", "y", "z"]
_Cut: TypeAlias = _Axis | tuple[_Axis, float]

class _Images(TypedDict, total=False):
    images: Literal["none", "whole", "cut"]

class _Axes(TypedDict, total=False):
    ax: Axes | None

@final
class Spec:
    """Everything that determines a model; omitted options keep their defaults, the paper's specimen."""

    def __new__(cls, table: SpecOptions | None = None, /, **options: Unpack[SpecOptions]) -> Spec: ...
    @staticmethod
    def from_toml(text: str) -> Spec:
        """Reads the text of a SPEC.toml."""

    @staticmethod
    def read(path: _Path) -> Spec:
        """Reads a SPEC.toml."""

    @staticmethod
    def recipe(name: str) -> Spec:
        """A specimen of the paper or of a standard, by its name in `recipes()`.

        Raises
        ------
        ValueError
            For another name; the message lists them.
        """

    @property
    def seed(self) -> int:
        """Seed of all randomness."""

    @property
    def fraction(self) -> float:
        """Volume of the aggregates over the specimen's, 0 to 1."""

    @property
    def specimen(self) -> _types.Specimen:
        """Specimen to fill; a copy."""

    @property
    def grading(self) -> _types.Grading:
        """Sizes; a copy."""

    @property
    def shape(self) -> _types.Shape:
        """Shapes; a copy."""

    @property
    def itz(self) -> _types.Itz:
        """Interfacial transition zone; a copy."""

    @property
    def placement(self) -> _types.Placement:
        """Placement; a copy."""

    @property
    def voids(self) -> _types.Voids | None:
        """Spherical voids, None where there are none; a copy."""

    @property
    def fibres(self) -> _types.Fibres | None:
        """Straight fibres, None where there are none; a copy."""

    def to_dict(self) -> SpecOptions:
        """Everything as a dict that `Spec(**it)` takes back."""

    def to_toml(self) -> str:
        """Everything as the text of a SPEC.toml."""

    def describe(self) -> str:
        """The text of a SPEC.toml with the meaning of each key above it: `print(spec.describe())`."""

    def replace(self, **changes: Unpack[SpecOptions]) -> Spec:
        """A spec with `changes` laid over this one; sections are merged key by key."""

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def _repr_html_(self) -> str: ...
    def __copy__(self) -> Spec: ...
    def __deepcopy__(self, _memo: object) -> Spec: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Polyhedron:
    """A closed convex polyhedron, mm."""

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Vertex positions: ndarray, shape (n, 3), float64, mm; a copy."""

    @property
    def faces(self) -> list[list[int]]:
        """Vertex indices of every face, counter-clockwise from outside: list of lists of int."""

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Faces cut into triangles: ndarray, shape (m, 3), int64."""

    @property
    def volume(self) -> float:
        """Volume, mm3."""

    @property
    def area(self) -> float:
        """Surface area, mm2."""

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centre of volume: ndarray, shape (3,), float64, mm."""

    def offset(self, thickness: float) -> Polyhedron | None:
        """The body with every face moved inwards by `thickness` (mm), or `None` where it vanishes.

        Raises
        ------
        ValueError
            For a thickness that is negative or not finite.
        ArithmeticError
            Where the rest is too thin, or too small, for float64 vertices to show its shape.
        """

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Polyhedron: ...
    def __deepcopy__(self, _memo: object) -> Polyhedron: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Aggregate:
    """One aggregate, or one void or fibre, at its position in the specimen."""

    @property
    def id(self) -> int:
        """Position in the packing, from 0; voids and fibres count on from the last aggregate."""

    @property
    def phase(self) -> str:
        """Its phase: "aggregate", "void", "fibre", or the name of one of the packing's own."""

    @property
    def size_class(self) -> int:
        """Index of the size class, from the finest; those of voids and of fibres follow the grading's."""

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Vertex positions: ndarray, shape (n, 3), float64, mm; a copy."""

    @property
    def faces(self) -> list[list[int]]:
        """Vertex indices of every face, counter-clockwise from outside: list of lists of int."""

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Faces cut into triangles: ndarray, shape (m, 3), int64."""

    @property
    def volume(self) -> float:
        """Volume of the outer body, ITZ shell included, mm3."""

    @property
    def area(self) -> float:
        """Surface of the outer body, mm2."""

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centre of volume: ndarray, shape (3,), float64, mm."""

    @property
    def size(self) -> float:
        """Longest distance of two vertices, mm: the longest axis 2a."""

    @property
    def sieve_size(self) -> float:
        """Side of the smallest square hole that it passes, mm."""

    @property
    def itz_thickness(self) -> float:
        """Thickness of the ITZ shell, mm."""

    @property
    def body(self) -> Polyhedron:
        """The outer body as a `Polyhedron`."""

    def core(self) -> Polyhedron | None:
        """The body inside the ITZ shell, or `None` where the shell takes it all."""

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Aggregate: ...
    def __deepcopy__(self, _memo: object) -> Aggregate: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Aggregates:
    """The aggregates of a packing, in descending volume: a sequence, and arrays of their properties."""

    @property
    def volume(self) -> NDArray[np.float64]:
        """Volumes, mm3: ndarray, shape (n,), float64; so are the other properties of all aggregates."""

    @property
    def area(self) -> NDArray[np.float64]:
        """Surfaces, mm2."""

    @property
    def size(self) -> NDArray[np.float64]:
        """Longest distances of two vertices, mm."""

    @property
    def sieve_size(self) -> NDArray[np.float64]:
        """Sides of the smallest square holes that they pass, mm."""

    @property
    def itz_thickness(self) -> NDArray[np.float64]:
        """Thicknesses of the ITZ shells, mm."""

    @property
    def size_class(self) -> NDArray[np.int64]:
        """Indices of the size classes, from the finest: ndarray, shape (n,), int64."""

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centres of volume, mm: ndarray, shape (n, 3)."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Aggregate]: ...
    @overload
    def __getitem__(self, key: int, /) -> Aggregate: ...
    @overload
    def __getitem__(self, key: slice, /) -> list[Aggregate]: ...
    def index(self, value: object, start: int = 0, stop: int | None = None) -> int:
        """Position of the first aggregate that equals `value`, from `start` on and before `stop`.

        Raises
        ------
        ValueError
            Where there is none.
        """

    def count(self, value: object) -> int:
        """How many aggregates equal `value`."""

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Packing:
    """A packed specimen."""

    @property
    def fraction(self) -> float:
        """Volume of all aggregates, ITZ shells included, over the specimen's."""

    @property
    def seed(self) -> int:
        """Seed of the run."""

    @property
    def spec(self) -> Spec:
        """The spec."""

    @property
    def aggregates(self) -> Aggregates:
        """The aggregates in descending volume: a sequence of `Aggregate`."""

    @property
    def inclusions(self) -> list[Aggregate]:
        """Voids in descending volume, then fibres: a list of `Aggregate`, empty where the spec asks for none."""

    @property
    def bounds(self) -> tuple[list[float], list[float]]:
        """The specimen's bounding box: lowest and highest corner, mm."""

    def report(self) -> _results.Report:
        """The result: a dict with the keys of `--summary-json` but `seconds`, so that equal runs compare equal."""

    def cite(self, mesh: Mesh | None = None, materials: _types.DeckMaterials | None = None) -> str:
        """A paragraph for the methods section of a paper, with the figures of this packing and what to cite, as `report --cite`.

        `mesh` of this packing and `materials`, as `Mesh.solve` takes them, add a sentence each.
        """

    @property
    def work(self) -> _results.WorkDone:
        """Cost of the result: the counters of `work` in `--summary-json`, and `seconds`, a dict of wall times by stage; a
        new dict.
        """

    @overload
    def table(self, frame: None = None) -> _results.Table:
        """Every aggregate, void and fibre as a row: a dict of arrays of one length, or a frame of pandas or polars.

        `table("pandas")` is a `pandas.DataFrame`, `table("polars")` a `polars.DataFrame`.

        Columns: `id`, `class` (int64), `phase` (str), `size_mm` (longest distance of two vertices), `sieve_size_mm`,
        `volume_mm3`, `area_mm2`, `sphericity` (Wadell), `centroid_x_mm`, `centroid_y_mm`, `centroid_z_mm`,
        `itz_thickness_mm` (float64), `vertices`, `faces` (int64). They are those of the `.csv`, and the sieve size.

        Raises
        ------
        ImportError
            Where the library is not installed.
        """

    @overload
    def table(self, frame: Literal["pandas"]) -> pd.DataFrame: ...
    @overload
    def table(self, frame: Literal["polars"]) -> pl.DataFrame: ...

    @overload
    def effective(
        self,
        what: Literal["diffusivity", "conductivity", "permeability"] = "diffusivity",
        *,
        voxel_size: float | None = None,
        method: Literal["voxel", "lattice"] = "voxel",
        element_size: float | None = None,
        phases: Mapping[str, float] | None = None,
        eigenstrain: None = None,
        axes: str = "xyz",
        boundary: Literal["fixed", "uniform-gradient", "uniform-flux"] = "fixed",
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> Effective:
        """Effective diffusivity, conductivity, permeability or stiffness, with its error, on exact voxels or on tetrahedra.

        Parameters
        ----------
        what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
            The property. All are diffusivity, conductivity and stiffness. For all, `phases` has a mapping for each, and a list of three is returned.
        voxel_size : float, optional
            Edge of a voxel, mm; by default an eighth of the smallest grain. The error follows from voxels of twice the size.
        method : {"voxel", "lattice"}
            Division into voxels, or into tetrahedra whose faces follow the aggregates.
        element_size : float, optional
            Edge of the tetrahedra, mm; a quarter of the smallest grain if omitted.
        phases : mapping, optional
            Values of `mortar`, `aggregate`, `itz`, `void`, `fibre`; omitted ones keep their defaults: for diffusivity 1, 0,
            the mortar's, 0, 0, for conductivity 1.5, 3, the mortar's, 0.025, 50 W/(m K), for permeability 1e-11, 0, the
            mortar's, 0, 0 mm2. For stiffness, each phase has a mapping of `youngs_modulus_mpa`, `poisson_ratio`, `eigenstrain`.
        eigenstrain : mapping, optional
            Strains without stress of the phases by name, for stiffness: shrinkage is negative.
        axes : str
            Axes of the gradient, some of x, y, z; each takes a solution. Stiffness always has all.
        boundary : {"fixed", "uniform-gradient", "uniform-flux"}
            Conditions at walls: given values at the ends of the gradient and insulated sides; in tetrahedra also a uniform
            gradient, an upper estimate, or a uniform flux, a lower one.
        tolerance : float, optional
            Error of the equations, over the result; 1e-9, and 1e-12 for stiffness, if omitted.
        progress : bool or callable, optional
            True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
            the work ends with a `RuntimeError`.

        Returns
        -------
        Effective
            A dict whose keys are attributes, too: the content of `effective.json` but `seconds`. It has `tensor`, `error`,
            `fine`, `coarse` (rows of mean flux, columns of gradients, None where not asked for), `bounds`, `phases`, `boundary`,
            `voxels` and `voxel_size_mm` or `elements` and `element_size_mm`, `iterations`, `solver_error`, `warnings`.
            Stiffness has 6 x 6 entries in MPa in the order xx, yy, zz,
            yz, zx, xy, and `isotropic`, `isotropic_error`, `expansion`, `expansion_error`.

        Raises
        ------
        ValueError, TypeError
            Names the option, its value and the accepted range; a specimen that is no box; tetrahedra
            also take a cylinder along z.
        RuntimeError
            Where the equations do not converge.
        """

    @overload
    def effective(
        self,
        what: Literal["stiffness"],
        *,
        voxel_size: float | None = None,
        method: Literal["voxel", "lattice"] = "voxel",
        element_size: float | None = None,
        phases: Mapping[str, Mapping[str, float]] | None = None,
        eigenstrain: Mapping[str, float] | None = None,
        axes: Literal["xyz"] = "xyz",
        boundary: Literal["fixed"] = "fixed",
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> Effective: ...

    @overload
    def effective(
        self,
        what: Literal["all"],
        *,
        voxel_size: float | None = None,
        method: Literal["voxel", "lattice"] = "voxel",
        element_size: float | None = None,
        phases: Mapping[str, Mapping[str, object]] | None = None,
        eigenstrain: Mapping[str, float] | None = None,
        axes: str = "xyz",
        boundary: Literal["fixed", "uniform-gradient", "uniform-flux"] = "fixed",
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> list[Effective]: ...

    @overload
    def voxelize(
        self,
        h: float | None = None,
        what: Literal["phase"] = "phase",
        box: Sequence[Sequence[float]] | None = None,
        *,
        shape: int | Sequence[int] | None = None,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[np.uint8]:
        """Phases, ids, shares or distances at every voxel of the specimen, or of a box in it.

        Voxel (k, j, i) has its centre at (i + 0.5, j + 0.5, k + 0.5) h from the lower corner of the specimen's bounding
        box, or of `box`. It lies in a body if its centre lies in the closed polyhedron.

        Parameters
        ----------
        h : float, optional
            Edge of a voxel, mm; along periodic axes it must divide the specimen's length. Give `h` or `shape`.
        what : {"phase", "grain", "share", "distance"}
            "phase": uint8, 0 mortar, 1 ITZ, 2 aggregate, 3 void, 4 fibre, 255 outside the specimen. "grain": int32, the id
            of the aggregate, void or fibre, -1 in the mortar, -2 outside. "share": float32, the share of the voxel's
            volume, exact to rounding; see `of`. "distance": float32, mm to the nearest surface of an aggregate, void or
            fibre, negative inside, NaN outside the specimen.
        box : pair of triples, optional
            Lower and upper corner of the part that is shown, mm, in the specimen's bounding box.
        shape : int or triple, optional
            Number of voxels along the longest side, or (nz, ny, nx); `h` follows from it. Voxels are cubes.
        of : {"aggregate", "core", "itz", "void", "fibre"}
            Whose share: of aggregates with their ITZ shells (as the packing's fraction counts them), of aggregates
            without, of the shells alone, of voids or of fibres. Cores and shells of ellipsoids and of grains with dents are
            sampled, to 0.01 of a voxel.

        Returns
        -------
        ndarray, shape (nz, ny, nx), C order

        Raises
        ------
        ValueError, TypeError
            Names the option, its value and the accepted range. Images of more than 2^33 voxels are left to
            `mesocrete image`, which streams them.
        """

    @overload
    def voxelize(
        self,
        h: float,
        what: Literal["grain"],
        box: Sequence[Sequence[float]] | None = None,
        *,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[np.int32]: ...
    @overload
    def voxelize(
        self,
        h: float | None = None,
        *,
        what: Literal["grain"],
        box: Sequence[Sequence[float]] | None = None,
        shape: int | Sequence[int] | None = None,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[np.int32]: ...
    @overload
    def voxelize(
        self,
        h: float,
        what: Literal["share", "distance"],
        box: Sequence[Sequence[float]] | None = None,
        *,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[np.float32]: ...
    @overload
    def voxelize(
        self,
        h: float | None = None,
        *,
        what: Literal["share", "distance"],
        box: Sequence[Sequence[float]] | None = None,
        shape: int | Sequence[int] | None = None,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
    ) -> NDArray[np.float32]: ...

    @overload
    def section(
        self,
        axis: Literal["x", "y", "z"] | None = None,
        at: float | None = None,
        px: int = 512,
        what: Literal["phase"] = "phase",
        *,
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
    ) -> NDArray[np.uint8]:
        """Phases, ids, shares or distances on a plane normal to an axis, pixel by pixel.

        Parameters
        ----------
        axis : {"x", "y", "z"}
            The axis that the plane is normal to.
        at : float, optional
            Position of the plane on it, mm; by default the middle of the specimen.
        x, y, z : float, optional
            One of them instead of `axis` and `at`, as in `section(y=50)`.
        px : int
            Pixels along the longer side of the section; they are square.
        what, of
            As for `voxelize`; shares are those of cubic voxels.

        Returns
        -------
        ndarray, shape (rows, columns)
            [y, x] across z, [z, x] across y, [z, y] across x; the first row is the lowest, as with
            `matplotlib.pyplot.imshow(..., origin="lower")`.

        Raises
        ------
        ValueError, TypeError
            Names the option, its value and the accepted range.
        """

    @overload
    def section(
        self,
        axis: Literal["x", "y", "z"] | None = None,
        at: float | None = None,
        px: int = 512,
        *,
        what: Literal["grain"],
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
    ) -> NDArray[np.int32]: ...
    @overload
    def section(
        self,
        axis: Literal["x", "y", "z"] | None = None,
        at: float | None = None,
        px: int = 512,
        *,
        what: Literal["share", "distance"],
        of: Literal["aggregate", "core", "itz", "void", "fibre"] = "aggregate",
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
    ) -> NDArray[np.float32]: ...

    def _repr_html_(self) -> str: ...
    def _section_svg(self, axis: int, at: float) -> str: ...
    def _asked_curve(self) -> tuple[list[float], list[float]]: ...
    def write(
        self,
        path: _Path,
        *,
        overwrite: bool = True,
        compress: bool = False,
        images: Literal["none", "whole", "cut"] = "none",
        mortar: bool = False,
        named_solids: bool = False,
    ) -> None:
        """Writes the packing, whole or not at all; the extension names the format.

        `.json` is the saved model and `.json.gz` the same, compressed; `.step` has an editable solid per aggregate; `.vtu`,
        `.vtp`, `.stl`, `.ply`, `.obj` and `.glb` hold the surfaces, `.csv` one row per aggregate, `.html` the page of
        `mesocrete report`, `.inp` an Abaqus deck of the default mesh (`mesh()` has the options).

        Parameters
        ----------
        path : path
            Where to.
        overwrite : bool
            Whether to replace a file that is there.
        compress : bool
            Whether to compress the data of a `.vtu` or `.vtp`.
        images : {"none", "whole", "cut"}
            Aggregates that cross a face of a periodic specimen, where surfaces are written: each once, every image that
            reaches in, or these cut at the faces, so that opposite faces match.
        mortar : bool
            Whether a `.step` has the mortar, too: a solid with a cavity per aggregate.
        named_solids : bool
            Whether an `.stl` is text, each aggregate a solid with its name.

        Raises
        ------
        ValueError
            For an extension that names no format; the message lists them.
        OSError
            Where the file cannot be written, or exists and `overwrite` is False.
        """

    def specimen_surface(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The specimen's surface: points (n, 3), mm, and triangles (m, 3), counter-clockwise from outside.

        Exact for planes; curved walls are polygons within 1e-3 of their size.
        """

    def check(self, *, progress: bool | Callable[..., object] | None = None) -> _results.CheckResult:
        """Proves, independently of how it was packed, that nothing overlaps and everything lies inside.

        Parameters
        ----------
        progress : bool or callable, optional
            True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
            the work ends with a `RuntimeError`.

        Returns
        -------
        dict
            `sound` (bool), `aggregates`, `pairs_tested`, `fraction` (recomputed), `findings`, a list of what is wrong, and
            `not_checked`, properties that a check of the model alone cannot prove.
        """

    def statistics(self, *, progress: bool | Callable[..., object] | None = None, **options: Unpack[StatisticsOptions]) -> _results.Statistics:
        """Measures grading, shape, orientation, wall effect, gaps and correlation functions of the aggregates, and counts
        voids and fibres under `phases`.

        Parameters
        ----------
        progress : bool or callable, optional
            True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
            the work ends with a `RuntimeError`.
        **options
            How much is sampled, and how finely: `seed`, `lines`, `lag_mm`, `lags`, `points`, `layer_mm`.

        Returns
        -------
        dict
        """

    def mesh(
        self, *, method: Literal["voxel", "lattice", "conforming"] | None = None, element_size: float | Literal["auto"] | None = None, for_test: bool = False, accept_phase_error: bool = False, progress: bool | Callable[..., object] | None = None, **options: Unpack[MeshOptions]
    ) -> Mesh:
        """Meshes the packing.

        Parameters
        ----------
        method : str, optional
            Method of meshing; "voxel" is the default.
        element_size : float or "auto", optional
            Edge length of the elements, mm; default 2. "auto" tries sizes on a small cube of the packing, and takes the
            largest that keeps every phase within 5 %.
        for_test : bool, optional
            Whether options that are not given are those of `mesocrete solve` with a model: a lattice with a smeared ITZ,
            aggregates of exact volume that mortar separates, and split narrow gaps. `Mesh.solve` then gives the command's
            curve.
        accept_phase_error : bool, optional
            Whether a mesh may have a phase more than 10 % off its exact volume, which is an error otherwise. A test of such
            a mesh warns before its first step, and its results carry a flag.
        progress : bool or callable, optional
            True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
            meshing stops with a `RuntimeError`.
        **options
            The other options of `mesocrete mesh`, e.g. `itz="cohesive"`. Where `itz` is not given, the mesh has the ITZ
            if its elements resolve it: voxels thicker than the thinnest shell cannot. None means "none". Where `volumes` is
            not given, meshes that follow grains other than convex polyhedra have their exact volumes.

        Raises
        ------
        ValueError, TypeError
            Names the option, its value and the accepted range; or the phase that the elements are too coarse for.
        MemoryError
            Where the mesh would take more memory than is free.
        """

    def to_pyvista(self, **options: Unpack[_Images]) -> PolyData:
        """The bodies' outer surfaces as PyVista polygons (needs the extra `plot`); `images` as for `write`."""

    def plot(
        self,
        *,
        cut: _Cut | None = None,
        itz: bool = False,
        screenshot: _Path | bool | None = None,
        plotter: Plotter | None = None,
        **options: object,
    ) -> object:
        """Shows the bodies, coloured by size class, inside the specimen's edges (needs the extra `plot`).

        Parameters
        ----------
        cut : str or pair, optional
            "z", or ("z", 30.0) in mm: takes the part beyond a plane away, and shows the phases on the plane.
        itz : bool
            Whether the cut shows the ITZ. Without a cut the bodies are translucent around their cores.
        screenshot : path or True, optional
            Writes the picture to this path, off screen. True returns it as an array, shape (rows, columns, 3), uint8.
        plotter : pyvista.Plotter, optional
            Adds everything to this plotter and returns it; nothing is shown.
        **options
            `legend=False` leaves the names of the colours and the scale out. `window_size`, `off_screen`, `notebook`, `background` and `cpos` go to the plotter, all others, such as
            `color` or `scalars`, to `pyvista.Plotter.add_mesh`.
        """

    def screenshot(self, path: _Path, **options: object) -> None:
        """Writes the picture of `plot` to `path`, off screen, with the same options."""

    def plot_grading(self, **options: Unpack[_Axes]) -> Axes:
        """Draws the grading asked for and the one reached; returns the matplotlib axes (extra `plot`)."""

    def _surfaces(self, images: str) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Packing: ...
    def __deepcopy__(self, _memo: object) -> Packing: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Mesh:
    """A mesh of a packing."""

    @property
    def points(self) -> NDArray[np.float64]:
        """Node positions: ndarray, shape (n, 3), float64, mm; a copy."""

    @property
    def cells(self) -> NDArray[np.int64]:
        """Node indices of every cell, in the order of Abaqus and VTK: ndarray, shape (m, nodes), int64; a copy."""

    @property
    def cell_type(self) -> str:
        """The cells' shape, by its name in meshio: "tetra", "tetra10" or "hexahedron"."""

    @property
    def phase(self) -> NDArray[np.uint8]:
        """Phase of every cell: ndarray, shape (m,), uint8; 0 mortar, 1 ITZ, 2 aggregate, 4 fibre, 5 on the packing's own; a copy."""

    @property
    def aggregate(self) -> NDArray[np.int64]:
        """Id of the aggregate or fibre every cell belongs to, -1 in the mortar: ndarray, shape (m,), int64; a copy."""

    @property
    def cohesive(self) -> NDArray[np.int64]:
        """Zero-thickness cohesive elements, the aggregate side's face and then the nodes over it, counter-clockwise seen
        from outside the aggregate: ndarray, shape (k, 6 or 8), int64; a copy. Empty unless `itz="cohesive"`.
        """

    @property
    def _cohesive_aggregate(self) -> NDArray[np.int64]: ...
    @property
    def notes(self) -> dict[str, float]:
        """Decisions of the builder, and how often it took each: gaps closed, ITZ thinned; a dict."""

    def volumes(self) -> dict[str, float]:
        """Volume of every phase in the mesh, mm3: a dict with the keys `aggregate`, `itz`, `mortar`, and `fibre` where
        there are fibres.
        """

    def quality(self) -> _results.QualityReport:
        """The worst cells, a histogram of smallest dihedral angles, the cells below 8 degrees (`bad_cells`), the stable
        time step that the default materials allow, the phases' volumes (`volumes_mm3`) against the exact ones
        (`exact_volumes_mm3`), and how far the interface nodes lie from the aggregates' surfaces: a dict.

        Pairs are (value, index of the cell); `interface_distance` has of the nodes where aggregates meet other
        materials how many there are (`nodes`), how many lie on none of the surfaces that meet there (`off`) and how
        far from the nearest one (`rms_mm`, `max_mm`); `joined` of them close a gap, and their distances from the surface
        beyond it are `joined_rms_mm` and `joined_max_mm`.
        """

    def mass_scaling(self, time_step_s: float = 5e-7) -> _results.MassScaling:
        """The mass that explicit dynamics in steps of `time_step_s` seconds takes, with the default materials: a dict of
        `time_step_s`, `factor` (scaled mass over the mesh's own) and `phases`, a list of dicts of `phase`,
        `elements`, `scaled` (share of them whose own step is shorter), `factor`, `shortest_step_s` and `mass_t`.
        """

    def bad_cells(self, degrees: float) -> NDArray[np.int64]:
        """The cells whose smallest dihedral angle lies below `degrees`, as indices: ndarray, int64."""

    def write(
        self,
        path: _Path,
        *,
        overwrite: bool = True,
        compress: bool = False,
        test: str | _types.NamedTest | None = None,
        **deck: Unpack[DeckOptions],
    ) -> None:
        """Writes the mesh, whole or not at all; the extension names the format.

        Parameters
        ----------
        path : path
            `.inp`, `.k`, `.cdb`, `.vtu`, `.msh`, `.pvtu` with its pieces `name_0.vtu`, ... beside it, or `.xdmf` with its `.h5` (through meshio and h5py, the extra `mesh`).
        overwrite : bool
            Whether a file that is there already is replaced.
        compress : bool
            Whether the data of a `.vtu` are compressed.
        test : str or dict, optional
            A named test, a dict as `Test` returns it, or one of the keys of a TEST.toml: the deck then has its supports and loads (docs/decks.md).
        **deck
            Contents of an `.inp` or a `.k` besides the mesh: `geometry_only`, `reduced_integration`, `periodic_equations` (booleans),
            `with_damage`, `allow_joined`, `analysis` ("none", "elastic", the name of a test, and "striker" in a `.k`), `lsdyna_law`, `frames`, `impact_speed_mm_per_s`,
            `heading` (a list), `materials` (a dict; absent values keep their illustrative defaults). `strain`, `friction`, `duration_s` and `time_increment_s` are laid over the test's own.

        Raises
        ------
        ValueError
            For an extension that names no mesh format, and for options that a deck cannot have; the message lists the accepted ones.
        OSError
            Where the file cannot be written.
        """

    def solve(
        self,
        test: Literal["compression", "tension", "splitting", "bending", "triaxial", "biaxial", "cyclic", "expansion", "shear"] | _types.NamedTest = "compression",
        *,
        materials: _types.DeckMaterials | None = None,
        threads: int | None = None,
        device: str = "cpu",
        progress: bool | Callable[..., object] | None = None,
        **options: Unpack[SolveOptions],
    ) -> Response:
        """Tests the specimen, and returns its curve, figures and fields.

        Parameters
        ----------
        test : str or dict
            A named test of docs/tests.md: "compression", "tension", "triaxial", "biaxial", "cyclic", "splitting", "bending", "four-point", "shear" or "expansion"; or one of `Test` or a dict of the keys of a TEST.toml, whose values further keywords override.
        friction : float
            Coulomb's coefficient between plates and specimen in compression.
        strain : float, optional
            Mean axial strain at the end; 0.005 in compression, 0.0005 in tension.
        law : str, optional
            The law of mortar and ITZ; aggregates and fibres are elastic.
        materials : dict, optional
            The `[materials]` of a deck; absent values keep their illustrative defaults.
        frames : int
            Moments, evenly over the strain, whose fields are kept in `Response.frames`.
        threads : int, optional
            All cores when absent. It changes the time, never the result.
        device : str
            What takes the steps: "cpu", "gpu" (the first that there is), "cuda:N" or "opencl:N"; the results are the same bytes.
        progress : bool or callable, optional
            True shows a bar. A callable is called about 25 times a second as `progress(strain, target)`; when it returns False, the test stops, and the
            curve so far is returned.
        **options
            `duration_s`, `time_step_s`, `control`, `ramp`, `rows`, `smoothing`, `hourglass`, `interface`: see docs/solve.md. `pressure_mpa`, `stress_ratio`,
            `strip_mm`, `span_mm`, `turns`, `supports`, `gauges`, `expansion`: see docs/tests.md.

        Returns
        -------
        Response
            Also of a test that was stopped or diverged: `result["ended"]` says so, and the curve is valid until there.

        Warns
        -----
        UserWarning
            Before the first step, where a phase of the mesh is more than 10 % off its exact volume, or aggregates share nodes.
            After the last, where the test was not quasi-static before its peak.

        Raises
        ------
        ValueError, TypeError
            For values that cannot be and for a mesh without faces for the plates or of second order, before any step.
        KeyboardInterrupt
            On Ctrl-C, within 0.5 s on meshes of moderate size. Its attribute `response` is the test so far; it has none
            where the first step was not yet taken, or after a second Ctrl-C.
        """

    def to_pyvista(self) -> UnstructuredGrid:
        """The mesh as a PyVista unstructured grid (needs the extra `plot`)."""

    def plot(
        self,
        *,
        cut: _Cut | None = "y",
        phases: Sequence[Literal["mortar", "itz", "aggregate", "fibre"]] | None = None,
        screenshot: _Path | bool | None = None,
        plotter: Plotter | None = None,
        **options: object,
    ) -> object:
        """Shows the mesh by phase (needs the extra `plot`).

        Parameters
        ----------
        cut : str or pair, optional
            "z", or ("z", 30.0) in mm: cuts the mesh at a plane and shows the phases there. None shows the whole mesh, as
            `phases` do without a cut.
        phases : sequence of str, optional
            Shows only these: "mortar", "itz", "aggregate", "fibre".
        screenshot : path or True, optional
            Writes the picture to this path, off screen. True returns it as an array, shape (rows, columns, 3), uint8.
        plotter : pyvista.Plotter, optional
            Adds everything to this plotter and returns it; nothing is shown.
        **options
            `legend=False` leaves the names of the colours and the scale out. `window_size`, `off_screen`, `notebook`, `background` and `cpos` go to the plotter, all others, such as
            `scalars` or `opacity`, to `pyvista.Plotter.add_mesh`.
        """

    def screenshot(self, path: _Path, **options: object) -> None:
        """Writes the picture of `plot` to `path`, off screen, with the same options."""

    def to_meshio(self) -> meshio.Mesh:
        """The mesh as a meshio mesh with a cell set per phase (needs the extra `mesh`)."""

    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def _repr_html_(self) -> str: ...
    def __copy__(self) -> Mesh: ...
    def __deepcopy__(self, _memo: object) -> Mesh: ...
    def __reduce__(self) -> tuple[object, ...]: ...

@final
class Response:
    """The test of a mesh: stress and strain, energies, figures and fields."""

    @property
    def curve(self) -> dict[str, NDArray[np.float64]]:
        """The curve, row by row: a dict of arrays, float64, by the names of `curve.csv`; copies.

        `strain` and `stress_mpa` are positive in the test's own sense; `kinetic`, `internal`, `external`, `friction_work`,
        `hourglass` and `dissipated` are energies in mJ.
        """

    @overload
    def table(self, frame: None = None) -> dict[str, NDArray[np.float64]]:
        """The curve as `curve` has it, or as a frame: `table("pandas")`, `table("polars")`.

        Raises
        ------
        ImportError
            Where the library is not installed.
        """

    @overload
    def table(self, frame: Literal["pandas"]) -> pd.DataFrame: ...
    @overload
    def table(self, frame: Literal["polars"]) -> pl.DataFrame: ...

    @property
    def result(self) -> _results.TestResult:
        """The figures of the test, as in `result.json`: a dict; a copy."""

    @property
    def frames(self) -> list[Frame]:
        """The frames that were asked for, in their order: a list."""

    @property
    def last(self) -> Frame | None:
        """The end of the test; None where it diverged."""

    def plot(self, *, ax: Axes | None = None, **options: object) -> Axes:
        """Draws stress over strain with the peak; returns the matplotlib axes (extra `plot`).

        `ax` are axes to draw on; further `options` go to `Axes.plot`.
        """

    def to_pyvista(self, frame: int | None = None) -> UnstructuredGrid:
        """A frame, by its place in `frames`, or the end, as a PyVista grid with all fields (extra `plot`).

        Raises
        ------
        IndexError
            Where there is no such frame; ask for `frames` when solving.
        """

    @overload
    def effective(
        self,
        frame: Literal["peak", "last"] | float = "peak",
        what: Literal["diffusivity", "conductivity", "permeability", "stiffness"] = "diffusivity",
        *,
        phases: Mapping[str, object] | None = None,
        axes: str = "xyz",
        crack_diffusivity: float | None = None,
        crack_conductivity: float | None = None,
        crack_roughness: float | None = None,
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> Effective:
        """Effective diffusivity, conductivity, permeability or stiffness of the cracked specimen in a frame, with its error.

        Cracks are layers of the opening that the frame has, on the mesh of the test. Each axis has given values at its ends;
        the other sides are insulated.

        Parameters
        ----------
        frame : {"peak", "last", "all"}, int or float
            The frame of the largest stress, the end, or all frames; a frame's number from 1; or the strain that it is nearest to.
        what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
            The property. For all, `phases` has a mapping for each, and a list of four is returned. Stiffness are Young's moduli
            between smooth ends, with which the specimen unloads: `youngs_modulus_mpa` and `error`, along x, y, z.
        phases : mapping, optional
            Values of `mortar`, `aggregate`, `itz`, `void`, `fibre`; see `Packing.effective`.
        axes : str
            Axes of the gradient, some of x, y, z; each takes a solution.
        crack_diffusivity : float, optional
            Diffusivity of what fills the cracks, in the unit of the phases; 200 times the mortar's if omitted.
        crack_conductivity : float, optional
            Conductivity of what fills the cracks, W/(m K); 0.6, of water, if omitted.
        crack_roughness : float, optional
            Permeability of the cracks over that of smooth ones, whose opening w gives w^2/12; 1 if omitted.
        tolerance : float, optional
            Error of the equations, over the result; 1e-9 if omitted.
        progress : bool or callable, optional
            True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
            the work ends with a `RuntimeError`.

        Returns
        -------
        Effective
            See `Packing.effective`; it also has `frame`, `strain` and `stress_mpa`. Of all frames, a list.

        Raises
        ------
        ValueError, TypeError
            Names the option, its value and the accepted range; a test without frames, or without such a one.
        RuntimeError
            Where the equations do not converge.
        """

    @overload
    def effective(
        self,
        frame: Literal["all"],
        what: Literal["diffusivity", "conductivity", "permeability", "stiffness", "all"] = "diffusivity",
        *,
        phases: Mapping[str, object] | None = None,
        axes: str = "xyz",
        crack_diffusivity: float | None = None,
        crack_conductivity: float | None = None,
        crack_roughness: float | None = None,
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> list[Effective]: ...
    @overload
    def effective(
        self,
        frame: Literal["peak", "last", "all"] | float = "peak",
        *,
        what: Literal["all"],
        phases: Mapping[str, object] | None = None,
        axes: str = "xyz",
        crack_diffusivity: float | None = None,
        crack_conductivity: float | None = None,
        crack_roughness: float | None = None,
        tolerance: float | None = None,
        progress: bool | Callable[..., object] | None = None,
    ) -> list[Effective]: ...
    def write(self, folder: _Path, *, overwrite: bool = True) -> None:
        """Writes `curve.csv`, `result.json`, `frames.pvd` with a `.vtu` for each frame, and `result.html`, all or none.

        Parameters
        ----------
        folder : path
            Where they go; made where it is not there.
        overwrite : bool
            Whether results that are there already are replaced.

        Raises
        ------
        OSError
            Where they cannot be written, or are there already.
        """

    def __reduce__(self) -> tuple[object, ...]: ...
    def _repr_html_(self) -> str: ...
    def __copy__(self) -> Response: ...
    def __deepcopy__(self, _memo: object) -> Response: ...

@final
class Frame:
    """The fields of a moment of a test; arrays have one row for each node or cell, real ones are float32."""

    @property
    def strain(self) -> float:
        """Mean axial strain, positive in the test's sense."""

    @property
    def stress_mpa(self) -> float:
        """Stress of the curve's latest row, MPa, positive in the test's sense."""

    @property
    def time_s(self) -> float:
        """Time in the test, s."""

    @property
    def displacement(self) -> NDArray[np.float32]:
        """Displacement of every node against the lower plate: ndarray, shape (n, 3), float32, mm; a copy."""

    @property
    def stress(self) -> NDArray[np.float32]:
        """Stress in every cell, xx yy zz xy yz zx: ndarray, shape (m, 6), float32, MPa; tension is positive; a copy."""

    @property
    def damage(self) -> NDArray[np.float32]:
        """Share of its stiffness that every cell has lost, 0 to 1: ndarray, shape (m,), float32; a copy."""

    @property
    def damage_tension(self) -> NDArray[np.float32]:
        """Damage in tension, 0 to 1: ndarray, shape (m,), float32; a copy."""

    @property
    def damage_compression(self) -> NDArray[np.float32]:
        """Damage in compression, 0 to 1: ndarray, shape (m,), float32; a copy."""

    @property
    def crack_opening_mm(self) -> NDArray[np.float32]:
        """Opening of the crack in every cell: ndarray, shape (m,), float32, mm; a copy."""

    @property
    def crack_strain(self) -> NDArray[np.float32]:
        """Strain of the cracks in every cell, xx yy zz xy yz zx: ndarray, shape (m, 6), float32; openings over the width of the
        band, along the cracks' normals; a copy.
        """

    @property
    def stiffness_left(self) -> NDArray[np.float32]:
        """Share of the stiffness with which every cell unloads, 0 to 1: ndarray, shape (m,), float32; a copy."""

    @property
    def strength_factor(self) -> NDArray[np.float32]:
        """Factor of the strengths in every cell, 1 where they do not scatter: ndarray, shape (m,), float32; a copy."""

    @property
    def phase(self) -> NDArray[np.uint8]:
        """Phase of every cell of the mesh: ndarray, shape (m,), uint8; 0 mortar, 1 ITZ, 2 aggregate, 4 fibre, 5 on the packing's own; a copy."""

    @property
    def aggregate(self) -> NDArray[np.int64]:
        """Id of the aggregate or fibre every cell of the mesh belongs to, -1 in the mortar: ndarray, shape (m,), int64; a copy."""

    def _mesh(self) -> tuple[NDArray[np.float64], NDArray[np.int64], str]: ...
    def __copy__(self) -> Frame: ...
    def __deepcopy__(self, _memo: object) -> Frame: ...
    def __reduce__(self) -> tuple[object, ...]: ...

def pack(
    spec: Spec | SpecOptions | Mapping[str, object] | _Path | None = None,
    *,
    seed: int | None = None,
    fraction: float | None = None,
    threads: int | None = None,
    time_limit: float | None = None,
    for_test: bool = False,
    method: Literal["voxel", "lattice", "conforming"] | None = None,
    element_size: float | Literal["auto"] | None = None,
    progress: bool | Callable[..., object] | None = None,
) -> Packing:
    """Generates and places the aggregates that a spec asks for.

    Parameters
    ----------
    spec : None, dict, path or Spec
        The spec; None is the paper's specimen.
    seed : int, optional
        Replaces the spec's seed; 0 to 2^64 - 1.
    fraction : float, optional
        Replaces the spec's fraction: aggregate volume over specimen volume, above 0 and below 1.
    threads : int, optional
        All cores when absent. It changes the time, never the result.
    time_limit : float, optional
        Stop after so many seconds with the best packing found; replaces the spec's.
    for_test : bool, optional
        Whether the packing is for a test: aggregates keep gaps of half an element, or less in dense packings, where the
        spec leaves `min_gap_mm` at 0. `mesocrete pack --analysis compression` packs in the same way.
    method : str, optional
        Method of the mesh that follows. "conforming" needs gaps of 0.05 mm, which are left where the spec has none. It
        is "lattice" by default with `for_test`.
    element_size : float or "auto", optional
        Edge length of the elements of the mesh that follows, mm; default 2. "auto" tries sizes on a small cube of the
        packing, and takes the largest that keeps every phase within 5 %.
    progress : bool or callable, optional
        True shows a bar, in a notebook, too. A callable is called about 25 times a second as `progress(done, total)`:
        `total` is the fraction asked for, and `done` never falls. If it has a parameter `stage`, it gets the stage's
        name, too: "take", "place", "jammed" or "prove", and before them "read" where the specimen is a surface. When it returns
        False, the best valid packing found so far is returned.

    Returns
    -------
    Packing
        Also where the target was not reached: `report()["stop_reason"]` says why.

    Raises
    ------
    ValueError, TypeError
        For a spec that cannot be, before any work starts.
    OSError
        Where the spec's file cannot be read.
    TimeoutError
        Where the time limit ended the proof of the specimen's surface, so that there is nothing to return.
    KeyboardInterrupt
        On Ctrl-C, within 0.2 s.

    Warns
    -----
    UserWarning
        Before the work, where the target exceeds the fraction that the strategy was measured to reach, or a class is
        too small for a single aggregate.
    """

@overload
def effective(
    labels: ArrayLike,
    what: Literal["diffusivity", "conductivity", "permeability"] = "diffusivity",
    *,
    voxel_size: float | Sequence[float] | None = None,
    phases: Mapping[int, float] | Mapping[str, float] | None = None,
    eigenstrain: None = None,
    axes: str = "xyz",
    tolerance: float | None = None,
    periodic: str = "",
    executor: None = None,
    progress: bool | Callable[..., object] | None = None,
) -> Effective:
    """Effective diffusivity, conductivity, permeability or stiffness of a label volume, with its error.

    Every voxel has the value of its label. `fine` is the volume's own value; `tensor` is extrapolated from it and a
    volume of every second voxel, since labels have errors of first order.

    Parameters
    ----------
    labels : array_like of int, shape (nz, ny, nx) or (ny, nx)
        One integer a phase, at most 256. With an `executor`: a sequence of such volumes, or of paths of `.npy` files.
    what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
        The property. All are diffusivity, conductivity and stiffness; `phases` has a mapping for each, and a list of three is
        returned.
    voxel_size : float or sequence of three float
        Edge of a voxel, mm; three are along x, y, z.
    phases : mapping, optional
        Values by label, as in `{0: 1.0, 1: 0.0}`; for stiffness, each label has a mapping of `youngs_modulus_mpa`,
        `poisson_ratio`, `eigenstrain`. Without, labels are those of `Packing.voxelize`, with its phases' defaults.
    eigenstrain : mapping, optional
        Strains without stress by label, for stiffness.
    axes : str
        Axes of the gradient, some of x, y, z; each takes a solution. Stiffness always has all.
    tolerance : float, optional
        Error of the equations, over the result; 1e-9, and 1e-12 for stiffness, if omitted.
    periodic : str
        Axes along which the volume repeats itself; along others both faces have given values.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Does many volumes, one a call, each on one thread; see `study`. Paths are read by its workers.
    progress : bool or callable, optional
        True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1, or in volumes. When it returns
        False, the work ends with a `RuntimeError`.

    Returns
    -------
    Effective
        See `Packing.effective`; names of phases are their labels. With an `executor`, a list in the order of the volumes.

    Raises
    ------
    ValueError, TypeError
        Names the option, its value and the accepted range; a label without a value.
    RuntimeError
        Where the equations do not converge, or an executor has lost its workers.
    """

@overload
def effective(
    labels: ArrayLike,
    what: Literal["stiffness"],
    *,
    voxel_size: float | Sequence[float] | None = None,
    phases: Mapping[int, Mapping[str, float]] | Mapping[str, Mapping[str, float]] | None = None,
    eigenstrain: Mapping[int, float] | Mapping[str, float] | None = None,
    axes: Literal["xyz"] = "xyz",
    tolerance: float | None = None,
    periodic: str = "",
    executor: None = None,
    progress: bool | Callable[..., object] | None = None,
) -> Effective: ...


@overload
def effective(
    labels: ArrayLike,
    what: Literal["all"],
    *,
    voxel_size: float | Sequence[float] | None = None,
    phases: Mapping[int, Mapping[str, float]] | Mapping[str, Mapping[str, float]] | None = None,
    eigenstrain: Mapping[int, float] | Mapping[str, float] | None = None,
    axes: str = "xyz",
    tolerance: float | None = None,
    periodic: str = "",
    executor: None = None,
    progress: bool | Callable[..., object] | None = None,
) -> list[Effective]: ...


@overload
def effective(
    labels: Iterable[ArrayLike | _Path],
    what: Literal["diffusivity", "conductivity", "stiffness"] = "diffusivity",
    *,
    voxel_size: float | Sequence[float] | None = None,
    phases: Mapping[int, float | Mapping[str, float]] | Mapping[str, float | Mapping[str, float]] | None = None,
    eigenstrain: Mapping[int, float] | Mapping[str, float] | None = None,
    axes: str = "xyz",
    tolerance: float | None = None,
    periodic: str = "",
    executor: Submitter,
    progress: bool | Callable[..., object] | None = None,
) -> list[Effective]: ...

def from_labels(
    labels: ArrayLike | _Path,
    voxel_size: float | Sequence[float] | None = None,
    *,
    array: str | None = None,
    mortar: Sequence[int] | None = None,
    aggregate: Sequence[int] = (),
    outside: Sequence[int] = (),
    least_voxels: int = 64,
    largest_grain: float = 0.2,
    gap: float = 0.0,
    itz_thickness: float = 0.0,
    tolerance: float = 0.2,
    smoothing: float = 1.0,
    step: float = 2.0,
    progress: bool | Callable[..., object] | None = None,
) -> Packing:
    """The grains of a label volume, as a CT scan leaves them after segmentation, as a packing in a box.

    Every connected part of a label is a grain: a smooth closed surface with the volume of its voxels, apart from all
    others. Grains that the volume's faces cut end at the box.

    Parameters
    ----------
    labels : array_like of int, shape (nz, ny, nx), or path-like
        One integer a grain or a phase; or a file (.tif, .npy, .vti).
    voxel_size : float or sequence of three float, optional
        Edge of a voxel, mm; three are along x, y, z. Without, the file's, or else 1.
    array : str, optional
        Array of a .vti that has the labels. Without, its scalars, of the cells or else of the points.
    mortar : sequence of int, optional
        Labels of the mortar, 0 without. Ids of `Packing.voxelize` take (-1,).
    aggregate : sequence of int
        Labels that are the aggregates' phase together, such as core and ITZ; all others are then mortar.
    outside : sequence of int
        Labels outside a drilled core, which stands along z: its cylinder is the specimen, not the whole box.
    least_voxels : int
        Smaller grains are mortar.
    largest_grain : float
        Largest share of the volume that a grain may have; a larger one is asked about, since it may be mortar.
    gap : float
        Gap between grains that are nearer, mm, so that elements of this size keep mortar between them; at least half a voxel.
    itz_thickness : float
        Thickness of the ITZ of every grain, mm.
    tolerance : float
        Root mean square error of merged triangles, in voxels.
    smoothing : float
        Width of the blur that smooths surfaces, in voxels.
    step : float
        Distance of the points between which a surface is found, in voxels; at most 1 on grains of fewer than 12 along an axis.
    progress : bool or callable, optional
        True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
        the work ends with a `RuntimeError`.

    Returns
    -------
    Packing
        `report()["labels"]` has the label of every aggregate, and how far surfaces are from the voxels.

    Raises
    ------
    ValueError, TypeError
        Names the option, its value and the accepted range; a volume without grains, or with one that fills it.
    OSError
        Where the file cannot be read.
    """

def load(path: _Path, *, progress: bool | Callable[..., object] | None = None) -> Packing:
    """Reads a saved model.

    Parameters
    ----------
    path : path-like
        A `.json` or `.json.gz` that `Packing.write` or the command wrote.
    progress : bool or callable, optional
        True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
        the work ends with a `RuntimeError`. The time goes into the proof of the specimen's surface, where it is one.

    Raises
    ------
    OSError
        Where the file cannot be read.
    ValueError
        Where it is no model; the message names the fault and its place.
    """

def convex_hull(points: ArrayLike) -> Polyhedron:
    """The convex hull of `points`.

    Parameters
    ----------
    points : array_like, shape (n, 3), mm

    Returns
    -------
    Polyhedron
        The exact extreme set, outward faces, coplanar triangles merged into polygons.

    Raises
    ------
    ValueError
        Where the points span fewer than three dimensions (the message says how many), or are no (n, 3) array.
    """

_Points: TypeAlias = ArrayLike | Aggregate | Polyhedron
_Method: TypeAlias = Literal["enhanced", "classical", "signed-volumes", "exact"]

def intersects(a: _Points, b: _Points, method: _Method = "enhanced") -> bool:
    """Whether the convex hulls of `a` and `b` share a point.

    Parameters
    ----------
    a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron
        Hulls of any dimension; closed sets, so touching counts. Any finite numbers.
    method : str
        The search that proposes the answer: "enhanced", "classical", "signed-volumes" or "exact". The answer is
        certified and does not depend on it.

    Raises
    ------
    ValueError, TypeError
        For arrays that are no (n, 3) array of finite numbers, and for an unknown method.
    """

def distance(a: _Points, b: _Points) -> float:
    """Distance of the convex hulls of `a` and `b`, in the unit of the arrays; 0.0 exactly when they share a point.

    Parameters
    ----------
    a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron

    Raises
    ------
    ValueError, TypeError
        For arrays that are no (n, 3) array of finite numbers.
    """

def intersects_many(
    a: _Points, bodies: Iterable[_Points], method: _Method = "enhanced"
) -> NDArray[np.bool_]:
    """`intersects` of `a` with each of many bodies.

    Boxes separate most bodies. To ask about the same bodies again, make `Bodies` of them.

    Parameters
    ----------
    a : array_like, shape (n, 3), or Aggregate, or Polyhedron
    bodies : iterable of the same
    method : str
        As in `intersects`.

    Returns
    -------
    ndarray, shape (len(bodies),), bool
    """

def closest_points(a: _Points, b: _Points) -> NDArray[np.float64]:
    """A point of each convex hull: the two that are nearest each other, or one that both share, twice.

    Parameters
    ----------
    a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron

    Returns
    -------
    ndarray, shape (2, 3), float64
        Row 0 lies in `a`, row 1 in `b`. Each coordinate is the exact one, rounded once.

    Raises
    ------
    ValueError, TypeError
        For arrays that are no (n, 3) array of finite numbers.
    """

def penetration(a: _Points, b: _Points) -> tuple[float, float, NDArray[np.float64]] | None:
    """The fields of `mesocrete.gjk.penetration`: depth, at_least, direction."""

def time_of_impact(
    a: _Points, b: _Points, motion: ArrayLike
) -> tuple[float, float | None, NDArray[np.float64]] | None:
    """The fields of `mesocrete.gjk.time_of_impact`: not_before, by, direction."""

@final
class Bodies:
    """Convex bodies that are laid out once and asked often.

    Parameters
    ----------
    bodies : iterable of array_like, shape (n, 3), or Aggregate, or Polyhedron
        Hulls of any dimension, closed, in one frame and any unit. Any finite numbers.

    All answers are exact for the points and shifts as given, as those of `intersects` are. A solid keeps the corners of its
    hull; points inside are dropped.

    Raises
    ------
    ValueError, TypeError
        For a body that is not an (n, 3) array of finite numbers; the message says which.
    """

    def __new__(cls, bodies: Iterable[_Points]) -> Bodies: ...
    def __len__(self) -> int: ...
    def points(self, index: int) -> NDArray[np.float64]:
        """The points of body `index`, in their order; of a solid the corners of its hull: ndarray, shape (n, 3), float64."""

    def intersects(self, a: _Points, shift: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Whether each body shares a point with `a`.

        Parameters
        ----------
        a : array_like, shape (n, 3), or Aggregate, or Polyhedron
        shift : array_like, shape (3,), optional
            Added to the points of `a`, exactly.

        Returns
        -------
        ndarray, shape (len(self),), bool
        """

    def intersects_pairs(
        self, pairs: ArrayLike, other: Bodies | None = None, shifts: ArrayLike | None = None
    ) -> NDArray[np.bool_]:
        """Whether the bodies of each pair share a point.

        Parameters
        ----------
        pairs : array_like, shape (m, 2), int
            (i, j): our body i and body j of `other`.
        other : Bodies, optional
            These bodies themselves by default.
        shifts : array_like, shape (m, 3), optional
            Added to the points of each second body, exactly.

        Returns
        -------
        ndarray, shape (m,), bool

        Raises
        ------
        ValueError, TypeError
            For a pair of bodies that are not there, and for arrays of another shape.
        """

    def overlapping_pairs(self) -> NDArray[np.int64]:
        """All pairs of these bodies that share a point: ndarray, shape (k, 2), int64, in ascending order."""

    def clear(self, a: _Points, shifts: ArrayLike, gap: float = 0.0) -> NDArray[np.bool_]:
        """At which shifts `a` keeps clear of all bodies: placement attempts.

        Parameters
        ----------
        a : array_like, shape (n, 3), or Aggregate, or Polyhedron
        shifts : array_like, shape (m, 3)
            Added to the points of `a`, exactly.
        gap : float
            The distance to exceed, at least 0, in the unit of the points.

        Returns
        -------
        ndarray, shape (m,), bool
        """

    def placed(self, positions: ArrayLike, rotations: ArrayLike | None = None) -> Bodies:
        """The bodies turned about the origin, if at all, and then displaced.

        Each coordinate is rounded, so that answers are exact for the points that `points` then returns.

        Parameters
        ----------
        positions : array_like, shape (len(self), 3)
            Added to the points of each body.
        rotations : array_like, shape (len(self), 4), optional
            Quaternions x, y, z, w, as scipy's `Rotation.as_quat` gives them; they need not be of unit length.

        Returns
        -------
        Bodies
        """

def _checked_test(test: _types.NamedTest) -> _types.NamedTest: ...
def _concrete_materials(
    *,
    fcm: float | str | None = ...,
    mortar: float | str | None = ...,
    rock: str | None = ...,
    fraction: float = ...,
    law: str = ...,
) -> _types.DeckMaterials: ...
def recipes() -> dict[str, str]:
    """The specimens that `Spec.recipe` knows: a dict of names and titles."""

@final
class _StudyPlan:
    def __new__(
        cls,
        spec: Spec | dict[str, Any] | _Path | list[Any] | None,
        over: dict[str, Any],
        zip: dict[str, Any] | None = None,
        draw: dict[str, Any] | None = None,
        steps: dict[str, Any] | None = None,
        model: str = "json",
    ) -> _StudyPlan: ...
    @staticmethod
    def of_file(path: _Path) -> _StudyPlan | None: ...
    @property
    def keys(self) -> list[str]: ...
    @property
    def folders(self) -> list[str]: ...
    def values(self, number: int) -> dict[str, Any]: ...
    def spec(self, number: int) -> Spec: ...
    def packed_spec(self, number: int) -> Spec: ...
    def tables(self, then: str, out: _Path) -> tuple[dict[str, list[Any]], dict[str, list[Any]]]: ...
    def ensemble(self, then: str, out: _Path, replicate: str) -> dict[str, list[Any]]: ...
    def results(self, then: str, out: _Path) -> Any: ...
    def __len__(self) -> int: ...

@final
class _Fit:
    def __new__(
        cls,
        points: Sequence[tuple[float, float]] | None,
        file: _Path | None,
        spec: Spec | dict[str, Any] | _Path | None,
        given: dict[str, Any],
        materials: dict[str, Any] | None,
        out: _Path,
    ) -> _Fit: ...
    def plan(self) -> _StudyPlan | None: ...
    @property
    def cases(self) -> Path: ...
    def learn(self, plan: _StudyPlan) -> str: ...
    def save(self, title: str) -> None: ...
    def close(self) -> None: ...
    def materials(self) -> _types.DeckMaterials: ...
    def report(self) -> dict[str, Any]: ...

@final
class _StudyRun:
    def __new__(cls, plan: _StudyPlan, then: str, out: _Path, retry_failed: bool, layout: str | None = None) -> _StudyRun: ...
    @property
    def left(self) -> list[int]: ...
    @property
    def over(self) -> int: ...
    @property
    def failed(self) -> int: ...
    @property
    def is_exclusive(self) -> bool: ...
    def case(self, number: int) -> _StudyCase: ...
    def seen(self, number: int) -> None: ...
    def note(self, number: int, failed: bool) -> None: ...
    def close(self) -> None: ...
    def leave_lock_to_parent(self) -> None: ...

@final
class _Lock:
    def __new__(cls, folder: _Path, work: str | None, part: str) -> _Lock: ...
    @staticmethod
    def briefly(folder: _Path) -> _Lock: ...
    @property
    def is_exclusive(self) -> bool: ...
    def release(self) -> None: ...
    def leave_lock_to_parent(self) -> None: ...

@final
class _StudyCase:
    @property
    def folder(self) -> Path: ...
    @property
    def is_marked(self) -> bool: ...
    @property
    def has_steps(self) -> bool: ...
    @property
    def memory(self) -> float: ...
    def find_device(self) -> None: ...
    def begin(self) -> Literal["turn", "done", "failed", "busy"]: ...
    def work(self, threads: int | None = None) -> tuple[Packing, str, str | None, list[str]]: ...
    def end(self, results: str, error: str | None, warnings: list[str]) -> Literal["done", "failed"]: ...
    def leave(self) -> None: ...
    def leave_lock_to_parent(self) -> None: ...

def _study_case(of: str) -> _StudyCase: ...
def _study_results(packing: Packing) -> dict[str, Any]: ...
def _usual_threads(threads: int | None) -> int | None: ...
def _colours() -> tuple[list[str], list[str]]: ...
def _run_command(args: list[str]) -> int: ...
def _restore_spec(options: dict[str, Any]) -> Spec: ...
def _restore_polyhedron(
    vertices: ArrayLike, faces: list[list[int]], dents: int | None = None, is_round: bool = False
) -> Polyhedron: ...
def _restore_aggregate(
    body: Polyhedron,
    id: int,
    size_class: int,
    itz_thickness: float,
    phase: str = "aggregate",
    own: int | None = None,
) -> Aggregate: ...
def _restore_mesh(state: tuple[Any, ...], packing: tuple[bytes, str], options: str) -> Mesh: ...
def _restore_frame(mesh: tuple[Any, ...], fields: tuple[str, list[NDArray[np.float32]]]) -> Frame: ...
def _restore_response(
    mesh: tuple[Any, ...],
    source: tuple[str, int, float, str],
    rows: NDArray[np.float64],
    extra: NDArray[np.float64],
    figures: str,
    frames: list[tuple[str, list[NDArray[np.float32]]]],
    last: tuple[str, list[NDArray[np.float32]]] | None,
    page: tuple[str, str],
) -> Response: ...
def _restore_packing(model: bytes, report: str) -> Packing: ...
