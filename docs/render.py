#!/usr/bin/env python3
"""Draws the pictures of the README: the packed specimen, a section through it, other specimens, a mesh, an ITZ, cracks.

    pip install '.[plot]' && python docs/render.py [FOLDER]

Writes packing.png and section.png to FOLDER (default docs/images), from the specimen that `mesocrete pack` makes,
specimens.png, and mesh.png, itz.png and cracks.png side by side in results.png. The cracks take some 30 CPU s.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
import pyvista
from matplotlib.collections import PolyCollection

import mesocrete as mc
from mesocrete._views import _CLASSES as CLASS_COLORS
from mesocrete._views import _PALETTE

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

MORTAR, ITZ, CRACK = _PALETTE[0], "#c8553d", "#c8553d"
# A cylinder, a box that repeats itself in all directions, gravel in a sphere, crushed rock in a prism.
OTHERS = [
    {"specimen": {"kind": "cylinder", "diameter_mm": 100, "height_mm": 200}, "fraction": 0.55},
    {"specimen": {"kind": "cube", "side_mm": 100, "periodic": ["x", "y", "z"]}, "fraction": 0.6},
    {"specimen": {"kind": "sphere", "diameter_mm": 120}, "shape": {"kind": "rounded"}, "fraction": 0.5},
    {"specimen": {"kind": "box", "size_mm": [70, 70, 150]}, "shape": {"kind": "crushed"}, "fraction": 0.5},
]

# What mesh, ITZ and cracks are shown of.
SMALL = {"specimen": {"kind": "cube", "side_mm": 40.0}, "fraction": 0.4}


def main() -> None:
    """Pack the paper's specimen and draw it twice, and the others once."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images"
    folder.mkdir(parents=True, exist_ok=True)
    packing = mc.pack()
    save(draw(packing, [1400, 1300], zoom=0.95)[::2, ::2], folder / "packing.png")
    draw_section(packing, folder / "section.png", height=75.0)
    # As large as fits a tile, upright ones in narrow tiles.
    tiles = [(720, 0.95), (1000, 0.95), (900, 1.1), (720, 0.95)]
    pictures = [draw(mc.pack(spec), [w, 1000], zoom=zoom) for spec, (w, zoom) in zip(OTHERS, tiles, strict=True)]
    save(np.hstack(pictures)[::2, ::2], folder / "specimens.png")
    save(np.hstack([draw_mesh(), draw_itz(), draw_cracks()])[::2, ::2], folder / "results.png")
    print(f"{packing!r}: packing.png, section.png, specimens.png, results.png in {folder}")


def draw(packing: mc.Packing, size: list[int], *, zoom: float) -> np.ndarray:
    """All aggregates, coloured by class, in the edges of their specimen; periodic ones are cut at its faces."""
    plotter = new_plotter(size)
    bodies = packing.to_pyvista(images="cut")
    clim = (0, len(CLASS_COLORS) - 1)
    plotter.add_mesh(bodies, scalars="class", cmap=CLASS_COLORS, clim=clim, show_scalar_bar=False, ambient=0.15)
    outline = pyvista.PolyData.from_regular_faces(*packing.specimen_surface()).extract_feature_edges(20.0)
    if outline.n_points:
        plotter.add_mesh(outline, color="black", line_width=3)
    plotter.enable_ssao(radius=12.0, bias=0.4)
    return seen(plotter, packing.bounds, zoom)


def draw_mesh() -> np.ndarray:
    """A fitted lattice cut open: aggregates and mortar, conforming."""
    packing = mc.pack(SMALL, seed=2)
    grid = packing.mesh(method="lattice", element_size=2.0, itz="none").to_pyvista()
    shown = grid.extract_cells(np.flatnonzero(grid.cell_centers().points[:, 1] > 20.0)).extract_surface(algorithm="dataset_surface")
    plotter = new_plotter([900, 900])
    add_phases(plotter, shown, show_edges=True, line_width=1)
    return seen(plotter, packing.bounds, 0.95)


def draw_itz() -> np.ndarray:
    """Aggregates cut open in their shells, which are thicker here than by default, to be seen."""
    packing = mc.pack(SMALL | {"itz": {"thickness_mm": [0.5, 0.5]}}, seed=2)
    plotter = new_plotter([900, 900])
    for aggregate in packing.aggregates:
        for body, color in ((aggregate, ITZ), (aggregate.core(), CLASS_COLORS[aggregate.size_class])):
            if body is None:
                continue
            surface = pyvista.PolyData.from_regular_faces(body.vertices, body.triangles)
            # What is cut off an aggregate shows the cut through its shell and its core.
            part = surface.clip_closed_surface(normal="y", origin=(0.0, 20.0 + 1e-3 * (body is aggregate), 0.0))
            if part.n_cells:
                plotter.add_mesh(part, color=color, ambient=0.15)
    return seen(plotter, packing.bounds, 0.95)


def draw_cracks() -> np.ndarray:
    """The cracks of a cube that was crushed between plates with little friction."""
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 50.0}, "fraction": 0.4}, seed=1)
    response = packing.mesh(element_size=2.0, itz="none").solve(friction=0.1, strain=0.005)
    grid = response.to_pyvista()
    grid.points += 5.0 * grid.point_data["displacement_mm"]
    plotter = new_plotter([900, 900])
    opening = np.minimum(grid.cell_data["crack_opening_mm"], 0.05)
    grid.cell_data["opening"] = opening
    surface = grid.extract_surface(algorithm="dataset_surface")
    plotter.add_mesh(surface, scalars="opening", cmap=[MORTAR, "#e8b7a4", CRACK, "#5a1f12"], show_scalar_bar=False)
    return seen(plotter, packing.bounds, 0.95)


def add_phases(plotter: pyvista.Plotter, shown: pyvista.PolyData, **options: object) -> None:
    """Add a surface in the colours of its phases."""
    colors = np.array([matplotlib.colors.to_rgb(_PALETTE[phase]) for phase in shown.cell_data["phase"]])
    shown.cell_data["colour"] = (255 * colors).astype(np.uint8)
    plotter.add_mesh(shown, scalars="colour", rgb=True, ambient=0.15, **options)


def new_plotter(size: list[int]) -> pyvista.Plotter:
    """An empty white picture."""
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    return plotter


def seen(plotter: pyvista.Plotter, bounds: tuple[list[float], list[float]], zoom: float) -> np.ndarray:
    """The picture from above a corner, whole at a zoom of 1, as pixels."""
    low, high = map(np.array, bounds)
    plotter.camera_position = [(low + high) / 2.0 + np.array([1.9, -2.5, 1.5]), (low + high) / 2.0, (0, 0, 1)]
    plotter.reset_camera()
    plotter.camera.zoom(zoom)
    return plotter.screenshot(None, return_img=True)


def save(pixels: np.ndarray, path: Path) -> None:
    """Write `pixels` with 128 colours: a third of the bytes, and the eye sees no difference."""
    from PIL import Image

    Image.fromarray(pixels).quantize(128).save(path, optimize=True)


def draw_section(packing: mc.Packing, path: Path, height: float) -> None:
    """The plane z = `height`: mortar, the ITZ shells, the aggregates' cores."""
    shells, cores, colors = [], [], []
    for aggregate in packing.aggregates:
        outline = section(aggregate.vertices, aggregate.triangles, height)
        if outline is None:
            continue
        shells.append(outline)
        core = aggregate.core()
        inner = section(core.vertices, core.triangles, height) if core else None
        if inner is not None:
            cores.append(inner)
            colors.append(CLASS_COLORS[aggregate.size_class])
    low, high = packing.bounds
    figure, ax = pyplot.subplots(figsize=(6.5, 6.5))
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[], facecolor=MORTAR)
    ax.add_collection(PolyCollection(shells, facecolor=ITZ, edgecolor="none"))
    ax.add_collection(PolyCollection(cores, facecolor=colors, edgecolor="none"))
    figure.savefig(path, dpi=100, bbox_inches="tight", pad_inches=0.05)
    pyplot.close(figure)


def section(vertices: np.ndarray, triangles: np.ndarray, height: float) -> np.ndarray | None:
    """The convex polygon in which the plane z = `height` cuts a convex body, shape (n, 2), or None."""
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    a, b = vertices[edges[:, 0]], vertices[edges[:, 1]]
    cut = (a[:, 2] - height) * (b[:, 2] - height) < 0.0
    if cut.sum() < 3:
        return None
    a, b = a[cut], b[cut]
    share = ((height - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None]
    points = (a + share * (b - a))[:, :2]
    offset = points - points.mean(axis=0)
    return points[np.argsort(np.arctan2(offset[:, 1], offset[:, 0]))]


if __name__ == "__main__":
    main()
