"""Pictures of packings and meshes, and their form in PyVista and meshio; each library is imported when it is used."""

from __future__ import annotations

import importlib
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

# VTK's numbers for the cells a mesh is made of.
_VTK_TYPES = {"tetra": 10, "hexahedron": 12, "wedge": 13, "tetra10": 24}
_PHASES = {"mortar": 0, "ITZ": 1, "aggregate": 2}
_FIBRE = 4
# Of surfaces; 3 is a void, which meshes do not have.
_KINDS = {"aggregate": 2, "void": 3, "fibre": _FIBRE}


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
    bodies = [*packing.aggregates, *packing.inclusions]
    data.cell_data["aggregate"] = owner
    if packing.inclusions:
        data.cell_data["phase"] = np.array([_KINDS[b.phase] for b in bodies], dtype=np.uint8)[owner]
    data.cell_data["class"] = np.array([b.size_class for b in bodies], dtype=np.int64)[owner]
    data.cell_data["itz_thickness_mm"] = np.array([b.itz_thickness for b in bodies], dtype=np.float64)[owner]
    return data


def plot_packing(packing: Any, *, screenshot: Any = None, **options: Any) -> Any:
    """Show the bodies, coloured by size class (voids and fibres as further ones), inside the specimen's edges; those of periodic specimens cut.

    With `screenshot` (a path) the picture is written off screen instead. `options` go to `pyvista.Plotter.add_mesh`.
    """
    pyvista = _need("pyvista", "plot")
    surface = packing_to_pyvista(packing, images="cut")
    plotter = pyvista.Plotter(off_screen=screenshot is not None)
    options = {"scalars": "class", "cmap": "cividis", "show_scalar_bar": False} | options
    plotter.add_mesh(surface, **options)
    points, triangles = packing.specimen_surface()
    outline = pyvista.PolyData.from_regular_faces(points, triangles).extract_feature_edges(20.0)
    if outline.n_points:
        plotter.add_mesh(outline, color="black")
    if screenshot is None:
        return plotter.show()
    plotter.screenshot(screenshot)
    return plotter.close()


def plot_grading(packing: Any, ax: Any = None) -> Any:
    """Draw the grading asked for and the one reached, as volume passing over size; returns the matplotlib axes."""
    if ax is None:
        ax = _need("matplotlib.pyplot", "plot").subplots()[1]
    classes = packing.report()["classes"]
    sizes = [classes[0]["d_min_mm"], *(c["d_max_mm"] for c in classes)]
    for key, label, style in (("target_fraction", "asked", "k--"), ("fraction", "reached", "o-")):
        volumes = np.array([0.0, *(c[key] for c in classes)])
        ax.plot(sizes, 100 * np.cumsum(volumes) / max(volumes.sum(), np.finfo(float).tiny), style, label=label)
    ax.set(xlabel="size, mm", ylabel="aggregate volume passing, %", xscale="log", ylim=(0, 102))
    ax.set_xticks(sizes, [f"{size:g}" for size in sizes])
    ax.minorticks_off()
    ax.legend()
    return ax


def _grid(points: Any, cells: Any, kind: str) -> Any:
    """Return a PyVista unstructured grid of cells of one kind."""
    width = np.full((len(cells), 1), cells.shape[1], dtype=np.int64)
    types = np.full(len(cells), _VTK_TYPES[kind], dtype=np.uint8)
    return _need("pyvista", "plot").UnstructuredGrid(np.hstack([width, cells]).ravel(), types, points)


def mesh_to_pyvista(mesh: Any) -> Any:
    """Return the mesh as a PyVista unstructured grid with the phase and the aggregate of every cell."""
    grid = _grid(mesh.points, mesh.cells, mesh.cell_type)
    grid.cell_data["phase"] = mesh.phase
    grid.cell_data["aggregate"] = mesh.aggregate
    return grid


def frame_to_pyvista(frame: Any) -> Any:
    """Return a moment of a test as a PyVista unstructured grid; its arrays are named as in the `.vtu` files of frames."""
    grid = _grid(*frame._mesh())
    grid.point_data["displacement_mm"] = frame.displacement
    grid.cell_data["damage"] = frame.damage
    grid.cell_data["damage_tension"] = frame.damage_tension
    grid.cell_data["damage_compression"] = frame.damage_compression
    grid.cell_data["crack_opening_mm"] = frame.crack_opening_mm
    grid.cell_data["stress_mpa"] = frame.stress
    grid.cell_data["phase"] = frame.phase
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
    ax.legend()
    return ax


def mesh_to_meshio(mesh: Any) -> Any:
    """Return the mesh as a meshio mesh with the phase and the aggregate of every cell, and a cell set per phase."""
    meshio = _need("meshio", "mesh")
    phase = mesh.phase
    phases = _PHASES | ({"fibre": _FIBRE} if (phase == _FIBRE).any() else {})
    sets = {name.upper(): [np.flatnonzero(phase == value)] for name, value in phases.items()}
    data = {"phase": [phase], "aggregate": [mesh.aggregate]}
    return meshio.Mesh(mesh.points, [(mesh.cell_type, mesh.cells)], cell_data=data, cell_sets=sets)


def write_xdmf(mesh: Any, path: Any, *, overwrite: bool) -> None:
    """Write the mesh as XDMF with its arrays in an HDF5 file beside it, both whole or none."""
    _need("h5py", "mesh")
    path = Path(path)
    heavy = path.with_suffix(".h5")
    for file in (path, heavy):
        if file.exists() and not overwrite:
            raise FileExistsError(f"{file} exists; overwrite=True replaces it")
    with tempfile.TemporaryDirectory(prefix=".mesocrete-", dir=path.parent) as folder:
        # The light file names the heavy one, so both are made under their own names.
        grid = mesh_to_meshio(mesh)
        grid.cell_sets = {}
        _need("meshio", "mesh").xdmf.write(Path(folder) / path.name, grid)
        os.replace(Path(folder) / heavy.name, heavy)
        os.replace(Path(folder) / path.name, path)
