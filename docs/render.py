#!/usr/bin/env python3
"""Draws the pictures of the README: the packed specimen, a section through it, and other specimens and shapes.

    pip install '.[plot]' && python docs/render.py [FOLDER]

Writes packing.png and section.png to FOLDER (default docs/images), from the specimen that `mesocrete pack` makes, and
specimens.png.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
import pyvista
from matplotlib.collections import PolyCollection

import mesocrete as mc

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

# Limestone, sandstone, basalt: the size classes from the finest to the coarsest.
CLASS_COLORS = ["#d9cbb3", "#b08d6a", "#5f6b73"]
MORTAR, ITZ = "#e9e7e2", "#c8553d"
# A cylinder, a box that repeats itself in all directions, gravel in a sphere, crushed rock in a prism.
OTHERS = [
    {"specimen": {"kind": "cylinder", "diameter_mm": 100, "height_mm": 200}, "fraction": 0.55},
    {"specimen": {"kind": "cube", "side_mm": 100, "periodic": ["x", "y", "z"]}, "fraction": 0.6},
    {"specimen": {"kind": "sphere", "diameter_mm": 120}, "shape": {"kind": "rounded"}, "fraction": 0.5},
    {"specimen": {"kind": "box", "size_mm": [70, 70, 150]}, "shape": {"kind": "crushed"}, "fraction": 0.5},
]


def main() -> None:
    """Pack the paper's specimen and draw it twice, and the others once."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images"
    folder.mkdir(parents=True, exist_ok=True)
    packing = mc.pack()
    draw_solid(packing, folder / "packing.png")
    draw_section(packing, folder / "section.png", height=75.0)
    pictures = [draw(mc.pack(spec), [900, 900], zoom=0.95)[::2, ::2] for spec in OTHERS]
    save(np.hstack(pictures), folder / "specimens.png")
    print(f"{packing!r}: packing.png, section.png, specimens.png in {folder}")


def draw_solid(packing: mc.Packing, path: Path) -> None:
    """All aggregates in their box, every second pixel of a picture twice as large."""
    save(draw(packing, [1400, 1300], zoom=1.2)[::2, ::2], path)


def draw(packing: mc.Packing, size: list[int], *, zoom: float) -> np.ndarray:
    """All aggregates, coloured by class, seen from above a corner, as pixels."""
    low, high = map(np.array, packing.bounds)
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    plotter.add_mesh(packing.to_pyvista(), scalars="class", cmap=CLASS_COLORS, show_scalar_bar=False, ambient=0.15)
    plotter.add_mesh(pyvista.Box(np.column_stack([low, high]).ravel()).extract_all_edges(), color="black", line_width=3)
    plotter.enable_ssao(radius=12.0, bias=0.4)
    plotter.enable_anti_aliasing("ssaa")
    middle = (low + high) / 2.0
    plotter.camera_position = [middle + np.array([1.9, -2.5, 1.5]) * (high - low).max(), middle, (0, 0, 1)]
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
