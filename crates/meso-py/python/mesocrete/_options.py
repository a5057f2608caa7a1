"""Sections of a spec and tests by their names in the field: `Grading.fuller(5, 20)`, `Specimen.cylinder(100, 200)`, `Test.triaxial(10)`.

They return plain dicts, as in a SPEC.toml or TEST.toml; `pack`, `Spec` and `Mesh.solve` check the values.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from math import isfinite, nan
from os import PathLike, fspath
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypedDict, cast

import numpy as np
from numpy.typing import ArrayLike

from ._mesocrete import Spec, _checked_test, _concrete_materials

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from . import _types

    _TurnOf = Literal["strain", "stress", "opening"]
    _Rock = Literal["granite", "basalt", "limestone", "quartzite", "sandstone", "gneiss"]
    _Law = Literal["meso", "cdp", "cdpm2", "elastic"]

    class _Frame(Protocol):
        """A DataFrame of pandas or polars."""

        @property
        def columns(self) -> Iterable[str]: ...
        def __getitem__(self, name: str, /) -> Iterable[object]: ...

Axes = Sequence[Literal["x", "y", "z"]] | str | bool | None


# Shares do not reach this by rounding.
_PER_CENT = 1.001
_PANS = ("pan", "tray", "bottom")


class GradingOptions(TypedDict, total=False):
    """The keys of a grading beside its curve and limits."""

    classes_mm: list[float]
    form: Literal["normalised", "raw"]
    size: Literal["longest-axis", "sieve"]
    size_law: Literal["uniform", "volume-uniform"]


class TableChoices(TypedDict, total=False):
    """What a sieve table's own words and numbers do not say."""

    column: str | int
    blend: dict[str, float]
    means: Literal["passing", "cumulative-retained", "retained"]
    unit: Literal["percent", "share", "mass"]
    sieve_unit: Literal["mm", "um", "in", "astm-number"]
    sheet: str


class Grading:
    """Gradings, for the key `grading` of a spec; `options` are its further keys: `classes_mm`, `size`, `size_law`, `form`.

    Sizes are square openings in tables and standards, longest axes in the formulas, unless `size` says otherwise.
    """

    @staticmethod
    def fuller(d_min_mm: float, d_max_mm: float, exponent: float = 0.5, **options: Unpack[GradingOptions]) -> _types.Grading:
        """Return Fuller's curve between two sizes, mm: (d / d_max)^exponent."""
        curve: _types.FullerCurve = {"kind": "fuller", "exponent": exponent}
        return {"curve": curve, "d_min_mm": d_min_mm, "d_max_mm": d_max_mm, **options}

    @staticmethod
    def bolomey(d_min_mm: float, d_max_mm: float, a: float = 0.1, **options: Unpack[GradingOptions]) -> _types.Grading:
        """Return Bolomey's curve between two sizes, mm: a + (1 - a) (d / d_max)^0.5, `a` from 0.08 to 0.16."""
        return {"curve": {"kind": "bolomey", "a": a}, "d_min_mm": d_min_mm, "d_max_mm": d_max_mm, **options}

    @staticmethod
    def sieves(
        sieve_mm: ArrayLike,
        passing: ArrayLike | None = None,
        d_min_mm: float | None = None,
        d_max_mm: float | None = None,
        *,
        passing_percent: ArrayLike | None = None,
        **options: Unpack[GradingOptions],
    ) -> _types.Grading:
        """Return a sieve table: openings, mm, in any order, and the share that passes each, 0 to 1; arrays of shape (n,).

        Both may be the columns of one array of shape (n, 2), or of a DataFrame, given first; a heading with `%` means per cent. A row of the pan is left out: nothing is finer. `passing_percent` takes per cent instead of shares. The limits of the sizes are the finest and the widest opening, unless they are given.
        """
        if passing is not None and passing_percent is not None:
            message = "passing and passing_percent are both given; keep one"
            raise ValueError(message)
        headings: list[str] = []
        if passing is None and passing_percent is None and hasattr(sieve_mm, "columns"):
            headings = [f"column {str(name)!r}" for name in sieve_mm.columns]
            sieve_mm, passing, passing_percent = _framed(sieve_mm)
        key: Literal["passing", "passing_percent"] = "passing" if passing_percent is None else "passing_percent"
        passing = passing if passing_percent is None else passing_percent
        if passing is None:
            table = np.asarray(sieve_mm)
            if table.ndim != 2 or table.shape[1] != 2:
                message = f"passing is missing, and sieve_mm has shape {table.shape}; give two rows, or one table of shape (n, 2)"
                raise ValueError(message)
            sieve_mm, passing = table[:, 0], table[:, 1]
        headings = headings or ["sieve_mm", key]
        sieve_mm, passing, numbers = _without_pan(sieve_mm, passing)
        sieves, shares = _row(headings[0], sieve_mm, numbers), _row(headings[1], passing, numbers)
        if key == "passing" and max(shares, default=0.0) > _PER_CENT:
            message = (
                f"passing goes up to {max(shares):g}: per cent? Write Grading.sieves(sieves, passing_percent=...), or "
                "Grading.table(file)"
            )
            raise ValueError(message)
        if not sieves:
            message = "sieve_mm is empty; give openings in mm, e.g. [5, 10, 20]"
            raise ValueError(message)
        if len(sieves) == len(shares):
            rows = sorted(zip(sieves, shares, strict=True))
            sieves, shares = [row[0] for row in rows], [row[1] for row in rows]
        curve: _types.SievesCurve = {"kind": "sieves", "sieves_mm": sieves}
        curve[key] = shares
        low = min(sieves) if d_min_mm is None else d_min_mm
        high = max(sieves) if d_max_mm is None else d_max_mm
        return {"curve": curve, "d_min_mm": low, "d_max_mm": high, **options}

    @staticmethod
    def table(
        file: str | PathLike[str] | _Frame,
        d_min_mm: float,
        d_max_mm: float,
        *,
        choices: TableChoices | None = None,
        **options: Unpack[GradingOptions],
    ) -> _types.Grading:
        """Return the grading of a laboratory's sieve table between two sizes, mm: CSV, text or .xlsx (by openpyxl), with any heading; or a DataFrame of pandas or polars.

        How the table was read is logged in one line. A table that could mean two things is refused; `choices` decides it: `column`, or `blend` for aggregates in columns, e.g. `{"Sand": 0.4, "Gravel": 0.6}`; `means`, `unit`, `sieve_unit` and `sheet`.
        """
        if not isinstance(file, (str, PathLike)):
            with TemporaryDirectory() as folder:
                path = _saved(file, folder)
                saved = Grading.table(path, d_min_mm, d_max_mm, choices=choices, **options)
                try:
                    return Spec({"grading": saved}).to_dict()["grading"]
                except ValueError as error:
                    where = f'grading.curve.file is "{path}"'
                    raise ValueError(str(error).replace(where, "the table, with its headings as line 1")) from None
        curve = cast("_types.SievesFileCurve", {"kind": "sieves", "file": fspath(file), **(choices or {})})
        return {"curve": curve, "d_min_mm": d_min_mm, "d_max_mm": d_max_mm, **options}

    @staticmethod
    def standard(name: str, d_min_mm: float, d_max_mm: float, **options: Unpack[GradingOptions]) -> _types.Grading:
        """Return a curve of a standard between two sizes, mm, e.g. "din-1045-2-a16"."""
        curve = cast("_types.StandardCurve", {"kind": "standard", "name": name})
        return {"curve": curve, "d_min_mm": d_min_mm, "d_max_mm": d_max_mm, **options}


class Specimen:
    """Specimens, for the key `specimen` of a spec; lengths in mm."""

    @staticmethod
    def cube(side_mm: float, periodic: Axes = None) -> _types.CubeSpecimen:
        """Return a cube; `periodic` names the axes along which it repeats itself, True all of them."""
        cube: _types.CubeSpecimen = {"kind": "cube", "side_mm": side_mm}
        if axes := _periodic(periodic):
            cube["periodic"] = axes
        return cube

    @staticmethod
    def box(x_mm: float, y_mm: float, z_mm: float, periodic: Axes = None) -> _types.BoxSpecimen:
        """Return a box of three edge lengths."""
        box: _types.BoxSpecimen = {"kind": "box", "size_mm": [x_mm, y_mm, z_mm]}
        if axes := _periodic(periodic):
            box["periodic"] = axes
        return box

    @staticmethod
    def prism(length_mm: float, width_mm: float, depth_mm: float) -> _types.PrismSpecimen:
        """Return a beam: its length along x, its depth along z."""
        return {"kind": "prism", "length_mm": length_mm, "width_mm": width_mm, "depth_mm": depth_mm}

    @staticmethod
    def cylinder(diameter_mm: float, height_mm: float) -> _types.CylinderSpecimen:
        """Return an upright cylinder."""
        return {"kind": "cylinder", "diameter_mm": diameter_mm, "height_mm": height_mm}

    @staticmethod
    def sphere(diameter_mm: float) -> _types.SphereSpecimen:
        """Return a sphere."""
        return {"kind": "sphere", "diameter_mm": diameter_mm}

    @staticmethod
    def notched_prism(
        length_mm: float,
        width_mm: float,
        depth_mm: float,
        notch_width_mm: float,
        notch_depth_mm: float,
        upper_notch_depth_mm: float = 0.0,
        notch_at_mm: float = 0.0,
    ) -> _types.NotchedPrismSpecimen:
        """Return a beam with a notch sawn into its lower side, across its width, and perhaps one above it.

        `notch_at_mm` is the place of both along x, from the middle."""
        notch = {
            "notch_width_mm": notch_width_mm,
            "notch_depth_mm": notch_depth_mm,
            "upper_notch_depth_mm": upper_notch_depth_mm,
            "notch_at_mm": notch_at_mm,
        }
        beam = {"kind": "notched-prism", "length_mm": length_mm, "width_mm": width_mm, "depth_mm": depth_mm, **notch}
        return cast("_types.NotchedPrismSpecimen", beam)

    @staticmethod
    def dogbone(
        length_mm: float,
        width_mm: float,
        thickness_mm: float,
        neck_width_mm: float,
        neck_length_mm: float,
        radius_mm: float,
    ) -> _types.DogboneSpecimen:
        """Return a plate, `thickness_mm` along z, that narrows in arcs of `radius_mm` to a neck in the middle of its length."""
        neck = {"neck_width_mm": neck_width_mm, "neck_length_mm": neck_length_mm, "radius_mm": radius_mm}
        plate = {"kind": "dogbone", "length_mm": length_mm, "width_mm": width_mm, "thickness_mm": thickness_mm, **neck}
        return cast("_types.DogboneSpecimen", plate)

    @staticmethod
    def polyhedron(vertices_mm: ArrayLike) -> _types.PolyhedronSpecimen:
        """Return the convex hull of points, shape (n, 3)."""
        return {"kind": "polyhedron", "vertices_mm": np.asarray(vertices_mm, float).tolist()}

    @staticmethod
    def stl(path: str | PathLike[str], *, scale: float = 1.0) -> _types.MeshFileSpecimen:
        """Return what the closed surface of a file (STL, PLY, OBJ, OFF) encloses; `scale` is the mm in a unit of the file."""
        return {"kind": "mesh", "file": fspath(path), "scale": scale}

    @staticmethod
    def mesh(vertices_mm: ArrayLike, triangles: ArrayLike) -> _types.MeshSpecimen:
        """Return what a closed surface encloses: points (n, 3), triangles (m, 3) counter-clockwise from outside."""
        points = np.asarray(vertices_mm, float).tolist()
        return {"kind": "mesh", "vertices_mm": points, "triangles": np.asarray(triangles, int).tolist()}


# Words in headings of columns that are no passing.
_NO_PASSING = ("retain", "mass", "weight", "residue", "(g)", "(kg)", "rückstand", "refus")


def _saved(table: _Frame, folder: str) -> Path:
    """Return the file of a DataFrame; a missing value is a blank cell."""
    path, names = Path(folder) / "DataFrame.csv", list(table.columns)
    rows = zip(*(["" if _is_missing(value) else value for value in table[name]] for name in names), strict=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([names, *rows])
    return path


def _framed(table: Any) -> tuple[Any, Any, Any]:
    """Return sizes, shares and per cent of a DataFrame of two columns, by their order and the second heading."""
    names = list(table.columns)
    if len(names) != 2:
        message = f"the table has {len(names)} columns; give two, openings in mm and what passes, or Grading.table(table, ...)"
        raise ValueError(message)
    if wrong := [word for word in _NO_PASSING if word in str(names[1]).lower()]:
        message = (
            f"the second column is {names[1]!r}, {wrong[0]}, and no passing; read the table by "
            "Grading.table(table, d_min_mm, d_max_mm)"
        )
        raise ValueError(message)
    sizes, passing = (list(table[name]) for name in names)
    is_percent = any(word in str(names[1]).lower() for word in ("%", "percent", "per cent"))
    return (sizes, None, passing) if is_percent else (sizes, passing, None)


def _without_pan(sizes: Any, passing: Any) -> tuple[Any, Any, Sequence[int]]:
    """Return both rows without the one of the pan, which has no opening, and the numbers of what is left."""
    sizes, passing = np.asarray(sizes), np.asarray(passing)
    if sizes.ndim != 1 or sizes.dtype.kind not in "OU" or len(sizes) != len(passing):
        return sizes, passing, range(1, 1 + sizes.size)
    kept = [place for place, size in enumerate(sizes) if str(size).strip().lower() not in _PANS]
    return sizes[kept], passing[kept], [1 + place for place in kept]


def _row(name: str, values: ArrayLike, numbers: Sequence[int]) -> list[float]:
    row = np.asarray(values)
    if row.ndim != 1:
        message = f"{name} has shape {row.shape}; it must be one row of numbers"
        raise ValueError(message)
    found = [_number(value) for value in row]
    if wrong := [place for place, value in enumerate(found) if not isfinite(value)]:
        number = numbers[wrong[0]] if wrong[0] < len(numbers) else 1 + wrong[0]
        message = (
            f"{name} has {str(row[wrong[0]])!r} in row {number}, which is no number; fill it, or leave the row out; "
            "Grading.table(file) reads the sheet of a laboratory"
        )
        raise ValueError(message)
    return found


def _number(value: Any) -> float:
    """Return a cell's number, NaN where it has none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return nan


def _is_missing(value: Any) -> bool:
    """Return whether a cell is empty: the missing value of pandas is not even unequal to itself."""
    try:
        return value is None or bool(value != value)
    except TypeError:
        return True


def _periodic(axes: Axes) -> _types.Periodic:
    if isinstance(axes, bool) or axes is None:
        return ["x", "y", "z"] if axes else []
    return cast("_types.Periodic", list(axes))


class Test:
    """Named tests, for `mesh.solve(test=mc.Test.triaxial(10))`, or `mesh.solve(**mc.Test.triaxial(10))`.

    `options` are the test's further keywords of `Mesh.solve`. Wrong names and values are refused at once.
    """

    __test__ = False  # No case for pytest, in spite of its name.

    @staticmethod
    def compression(friction: float = 0.1, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return plates that press along z, and rub with Coulomb's `friction`; brushes and teflon have 0.005."""
        return _checked_test({"test": "compression", "friction": friction, **options})

    @staticmethod
    def tension(**options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return plates that are glued on and pull along z."""
        return _checked_test({"test": "tension", **options})

    @staticmethod
    def triaxial(pressure_mpa: float = 5.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return a pressure on all sides, MPa, and then plates that press along z."""
        return _checked_test({"test": "triaxial", "pressure_mpa": pressure_mpa, **options})

    @staticmethod
    def biaxial(stress_ratio: float = 1.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return plates along z, and plates along x that have `stress_ratio` times their stress."""
        return _checked_test({"test": "biaxial", "stress_ratio": stress_ratio, **options})

    @staticmethod
    def cyclic(
        turns: Sequence[tuple[float, _TurnOf]] = (), /, **options: Unpack[_types.SolveOptions]
    ) -> _types.NamedTest:
        """Return plates that turn: each turn is a value and its quantity, "strain", "stress" (MPa) or "opening" (mm)."""
        listed: list[_types.SolveTurn] = [{"at": at, "of": of} for at, of in turns]
        return _checked_test({"test": "cyclic", "turns": listed, **options})

    @staticmethod
    def splitting(strip_mm: float | None = None, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return strips that press the mantle along x; they are a tenth of the diameter wide when `strip_mm` is absent."""
        return _checked_test({"test": "splitting", "strip_mm": strip_mm, **options})

    @staticmethod
    def bending(span_mm: float | None = None, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return a beam on two rollers, `span_mm` apart, that a third one presses."""
        return _checked_test({"test": "bending", "span_mm": span_mm, **options})

    @staticmethod
    def four_point(span_mm: float | None = None, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return a beam on two rollers, `span_mm` apart, that two more press at its third points (ASTM C78, EN 12390-5)."""
        return _checked_test({"test": "four-point", "span_mm": span_mm, **options})

    @staticmethod
    def shear(**options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return plates glued to the upper left and lower right half of a double-notched prism, which move past each other."""
        return _checked_test({"test": "shear", **options})

    @staticmethod
    def hopkinson(speed_m_per_s: float = 8.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return two steel bars, along one of which a striker of this speed sends a pulse; `pressure_mpa` confines."""
        return _checked_test({"test": "hopkinson", "speed_m_per_s": speed_m_per_s, **options})

    @staticmethod
    def hopkinson_splitting(speed_m_per_s: float = 8.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return strips that split a cylinder or a cube between two steel bars, along one of which a striker sends a pulse."""
        return _checked_test({"test": "hopkinson-splitting", "speed_m_per_s": speed_m_per_s, **options})

    @staticmethod
    def spall(speed_m_per_s: float = 1.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return a steel bar that sends a triangular pulse, whose reflection from the free end tears the specimen."""
        return _checked_test({"test": "spall", "speed_m_per_s": speed_m_per_s, **options})

    @staticmethod
    def drop(
        mass_kg: float = 1.0, speed_m_per_s: float = 3.0, /, **options: Unpack[_types.SolveOptions]
    ) -> _types.NamedTest:
        """Return a mass that falls on a beam on two rollers, or on a specimen on a base, and strikes at this speed."""
        return _checked_test({"test": "drop", "mass_kg": mass_kg, "speed_m_per_s": speed_m_per_s, **options})

    @staticmethod
    def impact(speed_m_per_s: float = 8.0, /, **options: Unpack[_types.SolveOptions]) -> _types.NamedTest:
        """Return a plate of constant speed that presses the specimen against a base."""
        return _checked_test({"test": "impact", "speed_m_per_s": speed_m_per_s, **options})

    @staticmethod
    def expansion(
        mortar: _types.SolveCourse = 0.0,
        aggregate: _types.SolveCourse = 0.0,
        fibre: _types.SolveCourse = 0.0,
        itz: _types.SolveCourse | None = None,
        layer_mm: float | None = None,
        below: _types.SolveBelow | None = None,
        **options: Unpack[_types.SolveOptions],
    ) -> _types.NamedTest:
        """Return linear strains of the phases without supports; shrinkage is negative, and the ITZ follows the mortar.

        A strain is a number, rows of a time and a strain, or a CSV file with the columns time and strain. If `layer_mm` is given,
        only a layer so deep has them, and the strains `below` it are those of its own phases.
        """
        strains: _types.SolveExpansion = {
            "mortar": mortar, "aggregate": aggregate, "fibre": fibre, "itz": itz, "layer_mm": layer_mm, "below": below
        }
        return _checked_test({"test": "expansion", "expansion": strains, **options})


class Materials:
    """Material values, for the keyword `materials` of `Mesh.solve`; `mesocrete init --materials` gives the source of each."""

    @staticmethod
    def for_concrete(
        fcm: float | str, *, rock: _Rock | None = None, fraction: float = 0.4, law: _Law = "meso"
    ) -> _types.DeckMaterials:
        """Return the values of a concrete by its mean cylinder strength, MPa, or by its class, "C30" or "C30/37", or its mortar, "M40".

        `rock` is the aggregates' kind, `fraction` the packing's share of aggregates, which the mortar's modulus follows
        from, and `law` the law of the mortar; decks take the values of `cdp`.
        """
        return _concrete_materials(fcm=fcm, rock=rock, fraction=fraction, law=law)

    @staticmethod
    def for_mortar(
        strength: float | str, *, rock: _Rock | None = None, fraction: float = 0.4, law: _Law = "meso"
    ) -> _types.DeckMaterials:
        """Return the values of the concrete that a mortar of this mean strength, MPa or "M40", makes; the others as in `for_concrete`."""
        return _concrete_materials(mortar=strength, rock=rock, fraction=fraction, law=law)
