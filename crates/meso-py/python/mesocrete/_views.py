"""Pictures of packings and meshes, and their form in PyVista and meshio; each library is imported when it is used."""

from __future__ import annotations

import base64
import html
import importlib
import math
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ._mesocrete import _colours

# VTK's numbers for the cells a mesh is made of.
_VTK_TYPES = {"tetra": 10, "hexahedron": 12, "wedge": 13, "tetra10": 24}
_PHASES = {"mortar": 0, "itz": 1, "aggregate": 2}
_FIBRE = 4
# Of surfaces; 3 is a void, which meshes do not have.
_KINDS = {"aggregate": 2, "void": 3, "fibre": _FIBRE}
_OUTSIDE = 255
_AXES = ("x", "y", "z")
# The colours of phases, by their labels, and of size classes, as in pages and images.
_PALETTE, _CLASSES = _colours()
# Meshes of more cells are shown without their edges.
_EDGES = 200_000
# A whole mesh shows little but mortar.
_BY_PHASES = object()
# Options of a picture that are the plotter's and not a surface's.
_PLOTTER_OPTIONS = ("notebook", "off_screen", "window_size")


def _need(module: str, extra: str) -> Any:
    """Import an optional library, or say how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        message = f"{module} is not installed; get it with: pip install 'mesocrete[{extra}]'"
        raise ImportError(message) from error


def packing_to_pyvista(packing: Any, *, images: str = "none") -> Any:
    """Return the bodies' outer surfaces as PyVista polygons with id, class, ITZ thickness, and phase where that differs.

    `images` ("none", "whole" or "cut") is for aggregates that cross a face of a periodic specimen.
    """
    pyvista = _need("pyvista", "plot")
    points, faces, owner = packing._surfaces(images)
    data = pyvista.PolyData(points, faces)
    data.cell_data["aggregate"] = owner
    if packing.inclusions:
        kinds = [_KINDS["aggregate"]] * len(packing) + [_KINDS[body.phase] for body in packing.inclusions]
        data.cell_data["phase"] = np.array(kinds, dtype=np.uint8)[owner]
    data.cell_data["class"] = _class_of(packing)[owner]
    thicknesses = [body.itz_thickness for body in packing.inclusions]
    data.cell_data["itz_thickness_mm"] = np.array([*packing.aggregates.itz_thickness, *thicknesses])[owner]
    return data


def _class_of(packing: Any) -> Any:
    """Return the size class of every body."""
    classes = [body.size_class for body in packing.inclusions]
    return np.array([*packing.aggregates.size_class, *classes], dtype=np.int64)


def _across(cut: Any, bounds: Any) -> tuple[int, float]:
    """Return the axis and the place of a cut: a name, "z", through the middle, or a pair, ("z", 30.0)."""
    try:
        name, at = (cut, None) if isinstance(cut, str) else cut
        axis = _AXES.index(name)
        place = (bounds[0][axis] + bounds[1][axis]) / 2 if at is None else float(at)
    except (TypeError, ValueError):
        place = math.nan
    if not math.isfinite(place):
        message = f"cut is {cut!r}; it must be one of 'x', 'y', 'z', or a pair of one of them and a length in mm"
        raise ValueError(message)
    return axis, place


def _painted(labels: Any) -> Any:
    """Return red, green, blue and opacity of phase labels."""
    table = np.zeros((256, 4), dtype=np.uint8)
    for label, colour in enumerate(_PALETTE):
        table[label] = (*bytes.fromhex(colour[1:]), 255)
    return table[labels]


def _section(packing: Any, axis: int, at: float, *, itz: bool, by_class: bool, px: int = 800) -> Any:
    """Return a plane across an axis with the colours of the phases in its pixels, or those of the bodies' classes."""
    labels = packing.section(_AXES[axis], at, px=px)
    if not itz:
        labels = np.where(labels == _PHASES["itz"], _PHASES["aggregate"], labels)
    low, high = (np.array(corner) for corner in packing.bounds)
    low[axis] = high[axis] = at
    sides = [i for i in range(3) if i != axis]
    pixel = max(high - low) / px
    spacing = np.full(3, pixel)
    counts = np.ones(3, dtype=int)
    counts[sides[0]], counts[sides[1]] = labels.shape[1] + 1, labels.shape[0] + 1
    plane = _need("pyvista", "plot").ImageData(dimensions=counts, spacing=spacing, origin=low)
    colours = _painted(labels)
    if by_class:
        body = packing.section(_AXES[axis], at, px=px, what="grain")
        of = np.array([(*bytes.fromhex(colour[1:]), 255) for colour in _CLASSES], dtype=np.uint8)
        shown = (body >= 0) & (labels != _PHASES["itz"])
        colours[shown] = of[_class_of(packing)[body[shown]] % len(_CLASSES)]
    plane.cell_data["colour"] = colours.reshape(-1, 4)
    return plane.threshold(0.5, scalars="inside") if _mark(plane, labels) else plane


def _mark(plane: Any, labels: Any) -> bool:
    """Mark the pixels inside the specimen; True where some lie outside."""
    plane.cell_data["inside"] = (labels != _OUTSIDE).ravel().astype(np.uint8)
    return bool((labels == _OUTSIDE).any())


def plot_packing(
    packing: Any,
    *,
    cut: Any = None,
    itz: bool = False,
    screenshot: Any = None,
    plotter: Any = None,
    **options: Any,
) -> Any:
    """Show the bodies as `Packing.plot` documents; voids and fibres count as further classes.

    Bodies that cross a face of a periodic specimen are cut there.
    """
    pyvista = _need("pyvista", "plot")
    surface = packing_to_pyvista(packing, images="cut")
    picture = _Picture(screenshot, plotter, options)
    plotter = picture.plotter
    colours = _CLASSES[: max(int(surface.cell_data["class"].max(initial=0)) + 1, 2)]
    by_class = not {"color", "scalars"} & options.keys()
    if by_class:
        picture.legend(_class_names(packing, surface.cell_data["class"]))
        options = {"scalars": "class", "cmap": colours, "clim": (0, len(colours) - 1), "show_scalar_bar": False} | options
    if cut is not None:
        axis, at = _across(cut, packing.bounds)
        normal = np.eye(3)[axis]
        surface = surface.clip(normal, origin=at * normal)
        plane = _section(packing, axis, at, itz=itz, by_class=by_class)
        plotter.add_mesh(plane, scalars="colour", rgb=True, lighting=False)
    elif itz:
        cores = [core for core in (body.core() for body in packing.aggregates) if core is not None]
        if cores:
            plotter.add_mesh(_surfaces_of(cores), color=_PALETTE[_PHASES["aggregate"]])
        options = {"opacity": 0.35} | options
    if surface.n_cells:
        plotter.add_mesh(surface, **options)
    points, triangles = packing.specimen_surface()
    outline = pyvista.PolyData.from_regular_faces(points, triangles).extract_feature_edges(20.0)
    if outline.n_points:
        plotter.add_mesh(outline, color="black")
    picture.scale(packing.bounds)
    return picture.shown()


def _class_names(packing: Any, found: Any) -> list[tuple[str, str]]:
    """Return the size classes that occur with their colours; those of voids and fibres follow the aggregates'."""
    sizes = [f"{size['d_min_mm']:g} to {size['d_max_mm']:g} mm" for size in packing.report()["classes"]]
    name = lambda number: sizes[number] if number < len(sizes) else "voids and fibres"  # noqa: E731
    return [(name(int(number)), _CLASSES[int(number) % len(_CLASSES)]) for number in np.unique(found)]


def _surfaces_of(bodies: Any) -> Any:
    """Return the triangles of many bodies as one surface."""
    starts = np.cumsum([0, *(len(body.vertices) for body in bodies)])
    triangles = [body.triangles + start for body, start in zip(bodies, starts, strict=False)]
    points = np.concatenate([body.vertices for body in bodies])
    return _need("pyvista", "plot").PolyData.from_regular_faces(points, np.concatenate(triangles))


class _Picture:
    """A plotter, the caller's or our own, and how it is shown. Takes its options out of those of a surface."""

    def __init__(self, screenshot: Any, plotter: Any, options: dict[str, Any]) -> None:
        """Make a plotter where there is none yet."""
        self._screenshot = None if screenshot is False else screenshot
        self._is_ours = plotter is None
        self._has_legend = options.pop("legend", self._is_ours)
        self._cpos = options.pop("cpos", None)
        made = {name: options.pop(name) for name in _PLOTTER_OPTIONS if name in options}
        if self._is_ours:
            made = {"off_screen": True if self._screenshot is not None else None} | made
            plotter = _need("pyvista", "plot").Plotter(**made)
        self.plotter = plotter
        if (background := options.pop("background", None)) is not None:
            plotter.set_background(background)

    def legend(self, names: list[tuple[str, str]]) -> None:
        """Name colours, in a plotter of the caller only where they ask for it."""
        if not self._has_legend:
            return
        for place, (name, colour) in enumerate(names):
            at = (0.02, 0.94 - 0.045 * place)
            # The colours of phases are pale.
            style = {"font_size": 11, "color": colour, "shadow": True, "viewport": True}
            self.plotter.add_text(name, position=at, name=f"legend: {name}", **style)

    def scale(self, bounds: Any) -> None:
        """Write the size of the specimen, which a perspective shows no scale for."""
        if self._has_legend:
            size = " x ".join(f"{high - low:.4g}" for low, high in zip(*bounds, strict=True))
            self.plotter.add_text(f"{size} mm", position="lower_left", font_size=10, color="grey")

    def shown(self) -> Any:
        """Show it, write it as a picture, or return the caller's plotter."""
        if self._cpos is not None:
            self.plotter.camera_position = self._cpos
        if not self._is_ours:
            return self.plotter
        if self._screenshot is None:
            return self.plotter.show()
        is_asked_back = self._screenshot is True
        pixels = self.plotter.screenshot(None if is_asked_back else self._screenshot)
        self.plotter.close()
        return pixels if is_asked_back else None


def plot_mesh(
    mesh: Any, *, cut: Any = _BY_PHASES, phases: Any = None, screenshot: Any = None, plotter: Any = None, **options: Any
) -> Any:
    """Show a mesh as `Mesh.plot` documents."""
    if cut is _BY_PHASES:
        cut = "y" if phases is None else None
    picture = _Picture(screenshot, plotter, options)
    grid = mesh_to_pyvista(mesh)
    kept = np.ones(grid.n_cells, dtype=bool)
    if phases is not None:
        known = _PHASES | {"fibre": _FIBRE}
        # As materials and results call them; decks write ITZ.
        unknown = [name for name in phases if str(name).lower() not in known]
        if unknown:
            message = f"phases holds {unknown[0]!r}; it may hold {', '.join(map(repr, known))}"
            raise ValueError(message)
        kept &= np.isin(mesh.phase, [known[name.lower()] for name in phases])
    part = grid.extract_cells(np.flatnonzero(kept))
    if cut is not None:
        axis, at = _across(cut, (mesh.points.min(axis=0), mesh.points.max(axis=0)))
        part = part.clip(np.eye(3)[axis], origin=at * np.eye(3)[axis])
    shown = part.extract_surface(algorithm="dataset_surface")
    if not {"color", "scalars"} & options.keys():
        labels = np.asarray(shown.cell_data["phase"])
        shown.cell_data["colour"] = _painted(labels)
        names = {label: name for name, label in (_PHASES | {"fibre": _FIBRE}).items()}
        picture.legend([(names[int(label)], _PALETTE[int(label)]) for label in np.unique(labels)])
        options = {"scalars": "colour", "rgb": True} | options
    picture.plotter.add_mesh(shown, **({"show_edges": grid.n_cells < _EDGES} | options))
    picture.scale((mesh.points.min(axis=0), mesh.points.max(axis=0)))
    return picture.shown()


def packing_to_html(packing: Any) -> str:
    """Return a section through the middle beside the most important figures, for notebooks."""
    report = packing.report()
    low, high = packing.bounds
    svg = packing._section_svg(2, (low[2] + high[2]) / 2)
    picture = base64.b64encode(svg.encode()).decode()
    rows = {
        "specimen": f"{report['specimen']['kind']}, {report['specimen']['volume_mm3']:.4g} mm³",
        "aggregates": f"{report['aggregates']:,}",
        "fraction": f"{report['fraction']:.4f} of {report['target_fraction']:.4g} asked",
        "seed": report["seed"],
    }
    return (
        "<div style='display:flex;flex-wrap:wrap;gap:1em;align-items:center'>"
        f"<img alt='section at half height' style='width:240px' src='data:image/svg+xml;base64,{picture}'>"
        f"{_table_html(rows)}</div>"
    )


def _table_html(rows: dict[str, Any]) -> str:
    """Return rows of names and values as a table of a notebook."""
    cells = "".join(f"<tr><th style='text-align:left'>{key}</th><td>{value}</td></tr>" for key, value in rows.items())
    return f"<table>{cells}</table>"


def mesh_to_html(mesh: Any) -> str:
    """Return the sizes of a mesh and the volumes of its phases, for notebooks."""
    rows = {"cells": f"{len(mesh):,}, {mesh.cell_type}", "nodes": f"{len(mesh.points):,}"}
    if len(mesh.cohesive):
        rows["cohesive elements"] = f"{len(mesh.cohesive):,}"
    return _table_html(rows | {name: f"{volume:,.0f} mm³" for name, volume in mesh.volumes().items() if volume})


def spec_to_html(spec: Any) -> str:
    """Return the text of a SPEC.toml, for notebooks."""
    return f"<pre>{html.escape(spec.to_toml())}</pre>"


def response_to_html(response: Any) -> str:
    """Return the curve of a test beside its most important figures, for notebooks."""
    result, curve = response.result, response.curve
    strain, stress = curve["strain"], curve["stress_mpa"]
    width, height = max(strain.max(initial=0), 1e-12), max(stress.max(initial=0), 1e-12)
    points = " ".join(f"{230 * x / width + 5:.1f},{155 - 150 * y / height:.1f}" for x, y in zip(strain, stress, strict=True))
    line = f"<polyline points='{points}' fill='none' stroke='currentColor' stroke-width='1.5'/>"
    axes = "<path d='M5 5V155H235' fill='none' stroke='currentColor' stroke-opacity='.4'/>"
    rows = {
        "test": f"{result['test']}, {result['law']}",
        "peak": f"{result['peak_mpa']:.2f} MPa at a strain of {result['peak_strain']:.5f}",
        "modulus": f"{result['modulus_mpa']:,.0f} MPa",
    }
    rows |= {"warning": html.escape(warning) for warning in result["warnings"][:1]}
    rows |= {"error": html.escape(error) for error in result["errors"][:1]}
    return (
        "<div style='display:flex;flex-wrap:wrap;gap:1em;align-items:center'>"
        f"<svg width='240' height='160' role='img' aria-label='stress over strain'>{axes}{line}</svg>{_table_html(rows)}</div>"
    )


def plot_grading(packing: Any, ax: Any = None) -> Any:
    """Draw the grading asked for, the one reached, and the sieve curve, as volume passing over size.

    Which size the grading means, the longest axis or the sieve's, stands at the axis. Returns the matplotlib axes.
    """
    if ax is None:
        ax = _need("matplotlib.pyplot", "plot").subplots()[1]
    classes = packing.report()["classes"]
    sizes = [classes[0]["d_min_mm"], *(c["d_max_mm"] for c in classes)]
    total = max(sum(c["fraction"] for c in classes), np.finfo(float).tiny)
    asked_at, asked = packing._asked_curve()
    ax.plot(asked_at, 100 * np.array(asked), "k--", label="asked")
    reached = np.cumsum([0.0, *(c["fraction"] for c in classes)])
    ax.plot(sizes, 100 * (asked[0] + (1 - asked[0]) * reached / total), "o", label="reached")
    by_axis = packing.spec.grading.get("size", "longest-axis") == "longest-axis"
    if by_axis and len(packing):
        sieved, volumes = packing.aggregates.sieve_size, packing.aggregates.volume
        order = np.argsort(sieved)
        passing = asked[0] + (1 - asked[0]) * np.cumsum(volumes[order]) / volumes.sum()
        ax.plot(sieved[order], 100 * passing, label="by sieve size")
    label = "longest axis, mm" if by_axis else "sieve size, mm"
    ax.set(xlabel=label, ylabel="aggregate volume passing, %", xscale="log", ylim=(0, 102))
    ax.set_xticks(sizes, [f"{size:g}" for size in sizes])
    ax.minorticks_off()
    ax.legend()
    return ax


def _grid(points: Any, *blocks: tuple[str, Any]) -> Any:
    """Return a PyVista unstructured grid of cells of several kinds, one kind after another."""
    blocks = tuple((kind, cells) for kind, cells in blocks if len(cells))
    cells = [np.insert(cells, 0, cells.shape[1], axis=1).ravel() for _, cells in blocks]
    types = [np.full(len(cells), _VTK_TYPES[kind], dtype=np.uint8) for kind, cells in blocks]
    return _need("pyvista", "plot").UnstructuredGrid(np.concatenate(cells), np.concatenate(types), points)


def _blocks(mesh: Any) -> tuple[list[tuple[str, Any]], Any, Any]:
    """Return the cells and the cohesive elements by their names in meshio, the phases and the aggregates of all."""
    joints = mesh.cohesive
    if not len(joints):
        return [(mesh.cell_type, mesh.cells)], mesh.phase, mesh.aggregate
    blocks = [(mesh.cell_type, mesh.cells), ("wedge" if joints.shape[1] == 6 else "hexahedron", joints)]
    phase = np.concatenate([mesh.phase, np.full(len(joints), _PHASES["itz"], dtype=np.uint8)])
    return blocks, phase, np.concatenate([mesh.aggregate, mesh._cohesive_aggregate])


def mesh_to_pyvista(mesh: Any) -> Any:
    """Return the mesh as a PyVista unstructured grid with the phase and the aggregate of every cell.

    Cohesive elements follow the cells, as wedges (hexahedra between voxels) of the ITZ.
    """
    blocks, phase, aggregate = _blocks(mesh)
    grid = _grid(mesh.points, *blocks)
    grid.cell_data["phase"] = phase
    grid.cell_data["aggregate"] = aggregate
    return grid


def frame_to_pyvista(frame: Any) -> Any:
    """Return a moment of a test as a PyVista unstructured grid; its arrays are named as in the `.vtu` files of frames."""
    points, cells, kind = frame._mesh()
    grid = _grid(points, (kind, cells))
    grid.point_data["displacement_mm"] = frame.displacement
    grid.cell_data["damage"] = frame.damage
    grid.cell_data["damage_tension"] = frame.damage_tension
    grid.cell_data["damage_compression"] = frame.damage_compression
    grid.cell_data["crack_opening_mm"] = frame.crack_opening_mm
    grid.cell_data["stress_mpa"] = frame.stress
    grid.cell_data["stiffness_left"] = frame.stiffness_left
    grid.cell_data["crack_strain"] = frame.crack_strain
    if (frame.strength_factor != 1).any():
        grid.cell_data["strength_factor"] = frame.strength_factor
    grid.cell_data["phase"] = frame.phase
    grid.cell_data["aggregate"] = frame.aggregate
    return grid


def plot_response(response: Any, ax: Any = None, **options: Any) -> Any:
    """Draw stress over strain, with a dot at the peak; returns the matplotlib axes. `options` go to `Axes.plot`."""
    if ax is None:
        ax = _need("matplotlib.pyplot", "plot").subplots()[1]
    curve, result = response.curve, response.result
    strain, stress = (np.concatenate([[0.0], curve[name]]) for name in ("strain", "stress_mpa"))
    (line,) = ax.plot(strain, stress, **options)
    label = f"peak {result['peak_mpa']:.1f} MPa"
    ax.plot(result["peak_strain"], result["peak_mpa"], "o", color=line.get_color(), label=label)
    ax.set(xlabel="mean axial strain", ylabel="stress, MPa", xlim=(0, None), ylim=(0, None))
    ax.locator_params(axis="x", nbins=6)
    # Room for the legend above the curves.
    room = 1.08 + 0.1 * len(ax.get_legend_handles_labels()[0])
    ax.set_ylim(0, max(ax.get_ylim()[1], room * float(stress.max())))
    ax.legend(loc="upper right")
    return ax


def mesh_to_meshio(mesh: Any) -> Any:
    """Return the mesh as a meshio mesh with the phase and the aggregate of every cell, and a cell set per phase.

    Cohesive elements are a second block, of wedges (of hexahedra between voxels), in the set ITZ.
    """
    meshio = _need("meshio", "mesh")
    blocks, phase, aggregate = _blocks(mesh)
    ends = np.cumsum([len(cells) for _, cells in blocks])[:-1]
    split = {"phase": np.split(phase, ends), "aggregate": np.split(aggregate, ends)}
    phases = _PHASES | ({"fibre": _FIBRE} if (phase == _FIBRE).any() else {})
    sets = {name.upper(): [np.flatnonzero(block == value) for block in split["phase"]] for name, value in phases.items()}
    return meshio.Mesh(mesh.points, blocks, cell_data=split, cell_sets=sets)


def write_xdmf(mesh: Any, path: Any) -> None:
    """Write the mesh as XDMF with its arrays in an HDF5 file beside it, both whole or none."""
    _need("h5py", "mesh")
    path = Path(path)
    heavy = path.with_suffix(".h5")
    with tempfile.TemporaryDirectory(prefix=".mesocrete-", dir=path.parent) as folder:
        # The light file names the heavy one, so both are made under their own names.
        grid = mesh_to_meshio(mesh)
        grid.cell_sets = {}
        _need("meshio", "mesh").xdmf.write(Path(folder) / path.name, grid)
        os.replace(Path(folder) / heavy.name, heavy)
        os.replace(Path(folder) / path.name, path)
