#!/usr/bin/env python3
"""Draws the pictures of the README: the packed specimen, a section through it, other specimens, a mesh, an ITZ, cracks.

    pip install '.[plot]' && python docs/render.py [--only NAME] [FOLDER]

Writes packing.png and section.png to FOLDER (default docs/images), from the specimen that `mesocrete pack` makes, the same
specimen turning (turning.gif), other specimens (specimens.png), a mesh, ITZ shells and cracks side by side (results.png), a
computed curve beside a published test (curve.png), and the flux through a crack (flux.png). Cracks and the curve take some
minutes each.
"""

import argparse
import csv
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
import pyvista
from matplotlib.collections import PolyCollection

import mesocrete as mc
from mesocrete._views import _CLASSES as CLASS_COLORS
from mesocrete._views import _PALETTE
from PIL import Image

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

MORTAR, ITZ, CRACK = _PALETTE[0], "#c8553d", "#c8553d"
# Phases by their labels, the ITZ so that it is seen.
PHASES = [MORTAR, ITZ, *_PALETTE[2:]]
# A cylinder, a box that repeats itself in all directions, gravel in a sphere, crushed rock in a prism.
OTHERS = [
    {"specimen": {"kind": "cylinder", "diameter_mm": 100, "height_mm": 200}, "fraction": 0.55},
    {"specimen": {"kind": "cube", "side_mm": 100, "periodic": ["x", "y", "z"]}, "fraction": 0.6},
    {"specimen": {"kind": "sphere", "diameter_mm": 120}, "shape": {"kind": "rounded"}, "fraction": 0.5},
    {"specimen": {"kind": "box", "size_mm": [70, 70, 150]}, "shape": {"kind": "crushed"}, "fraction": 0.5},
]

# What mesh and ITZ are shown of: shells of one thickness, and a box that repeats itself, so that its faces cut aggregates.
SMALL = {"specimen": {"kind": "cube", "side_mm": 40.0}, "fraction": 0.4, "itz": {"thickness_mm": [0.5, 0.5]}}
REPEATED = SMALL | {"specimen": {"kind": "cube", "side_mm": 40.0, "periodic": ["x", "y", "z"]}, "fraction": 0.55}


# What is split for the flux through its cracks.
SPLIT = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 30 }\ngrading = { d_min_mm = 4, d_max_mm = 10, classes_mm = [4, 10] }\n"

# Uniaxial compression of Kupfer, Hilsdorf and Ruesch 1969: plates of 200 x 200 x 50 mm, brush platens.
EXPERIMENT = Path(__file__).parent / "experiments" / "kupfer_uniaxial.csv"
# Pictures of the turning specimen, its height in pixels and its colours: 2 MB at most.
TURNS, TURNING_PX, TURNING_COLORS = 32, 360, 32


def main() -> None:
    """Draw every picture, or the one that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "images")
    pictures: dict[str, Callable[[Path], None]] = {
        "packing.png": lambda path: save([draw(mc.pack())], path, height=640),
        "turning.gif": lambda path: draw_turning(mc.pack(), path),
        "section.png": lambda path: draw_section(mc.pack(), path, height=75.0),
        "specimens.png": lambda path: save([draw(mc.pack(spec)) for spec in OTHERS], path, height=460),
        "results.png": lambda path: save([draw_mesh(), draw_itz(), draw_cracks()], path, height=460),
        "curve.png": draw_curve,
        "flux.png": lambda path: save(draw_flux(), path, height=420),
    }
    parser.add_argument("--only", metavar="NAME", choices=pictures)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for name in [arguments.only] if arguments.only else pictures:
        pictures[name](arguments.folder / name)
        print(f"wrote {arguments.folder / name}", flush=True)


def draw(packing: mc.Packing) -> np.ndarray:
    """All aggregates, coloured by class, in the edges of their specimen; periodic ones are cut at its faces."""
    return seen(scene(packing), packing.bounds)


def scene(packing: mc.Packing, pixels: int = 1500) -> pyvista.Plotter:
    """The aggregates of a packing and the edges of its specimen."""
    plotter = new_plotter(pixels)
    bodies = packing.to_pyvista(images="cut")
    clim = (0, len(CLASS_COLORS) - 1)
    plotter.add_mesh(bodies, scalars="class", cmap=CLASS_COLORS, clim=clim, show_scalar_bar=False, ambient=0.15)
    outline = pyvista.PolyData.from_regular_faces(*packing.specimen_surface()).extract_feature_edges(20.0)
    if outline.n_points:
        plotter.add_mesh(outline, color="black", line_width=3)
    plotter.enable_ssao(radius=12.0, bias=0.4)
    return plotter


def draw_turning(packing: mc.Packing, path: Path) -> None:
    """The packing as it turns once about its axis, as a GIF that repeats."""
    plotter = scene(packing, 2 * TURNING_PX)
    # Frames are drawn twice as large as they are kept.
    plotter.disable_anti_aliasing()
    plotter.show(auto_close=False)
    middle = np.mean(packing.bounds, axis=0)
    frames = []
    for turn in range(TURNS):
        angle = 2.0 * np.pi * turn / TURNS - 0.9
        plotter.camera_position = [middle + 600.0 * np.array([np.cos(angle), np.sin(angle), 0.48]), middle, (0, 0, 1)]
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.46 * np.linalg.norm(np.diff(packing.bounds, axis=0))
        plotter.reset_camera_clipping_range()
        plotter.render()
        pixels = plotter.screenshot(None, return_img=True)
        frames.append(Image.fromarray(pixels).resize((TURNING_PX, TURNING_PX), Image.Resampling.LANCZOS))
    # One palette for all frames and no dither: colours that change from frame to frame flicker, and cost bytes.
    palette = frames[0].quantize(TURNING_COLORS)
    still = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    colors = np.array(palette.getpalette()).reshape(-1, 3)
    colors[colors.sum(axis=1).argmax()] = 255  # the ground is white, not nearly so
    for frame in still:
        frame.putpalette(colors.ravel().tolist())
    still[0].save(path, save_all=True, append_images=still[1:], duration=90, loop=0, optimize=True)


def draw_curve(path: Path) -> None:
    """The computed curve of a plate like that of the experiment, beside the measured one."""
    with EXPERIMENT.open(encoding="utf-8") as file:
        measured = np.array([[-float(strain), -float(stress)] for strain, stress in csv.reader(file)])
    measured = measured[np.argsort(measured[:, 0])]
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 50.0}, "fraction": 0.4, "placement": {"min_gap_mm": 1.0}}, seed=1)
    response = packing.mesh(for_test=True, element_size=2.0).solve(friction=0.0, strain=0.006)
    figure, axes = pyplot.subplots(figsize=(5.2, 3.9), layout="constrained")
    axes.plot(100 * measured[:, 0], measured[:, 1], "o", ms=3.5, color="black", label="test, Kupfer et al. 1969 (digitised)")
    axes.plot(100 * response.curve["strain"], response.curve["stress_mpa"], color=CRACK, lw=2, label="mesocrete, default materials")
    axes.set(xlabel="strain, %", ylabel="stress, MPa", xlim=(0, 0.6), ylim=(0, 1.35 * measured[:, 1].max()))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def draw_mesh() -> np.ndarray:
    """A fitted lattice with its layers of ITZ, cut open."""
    packing = mc.pack(SMALL, seed=2)
    grid = packing.mesh(method="lattice", element_size=2.0, itz="solid").to_pyvista()
    plotter = new_plotter()
    add_painted(plotter, cut_open(grid), lambda cells: rgb(PHASES)[cells["phase"]], show_edges=True, line_width=1)
    return seen(plotter, packing.bounds)


def draw_itz() -> np.ndarray:
    """A box that repeats itself, without the eighth that is nearest: mortar, shells and cores in exact sections."""
    packing = mc.pack(REPEATED, seed=2)
    low, high = (np.array(corner) for corner in packing.bounds)
    middle = (low + high) / 2.0
    plotter = new_plotter()
    # The eighth beyond the middle of x and z, and before that of y, is away: its three faces lie inside.
    for axis, outside in enumerate([high, low, high]):
        for at, is_inner in ((outside[axis], False), (middle[axis], True)):
            plane = painted_section(packing, axis, at)
            centers = plane.cell_centers().points
            beyond = (centers > middle) == [True, False, True]
            away = beyond[:, [i for i in range(3) if i != axis]].all(axis=1)
            plotter.add_mesh(plane.extract_cells(np.flatnonzero(away == is_inner)), scalars="colour", rgb=True, ambient=0.2)
    return seen(plotter, packing.bounds)


def painted_section(packing: mc.Packing, axis: int, at: float, px: int = 800) -> pyvista.ImageData:
    """The exact section across an axis, mm, as pixels in the colours of the phases."""
    low, high = (np.array(corner) for corner in packing.bounds)
    # A face of the box belongs to it, but for rounding.
    labels = packing.section("xyz"[axis], float(np.clip(at, low[axis] + 1e-6, high[axis] - 1e-6)), px=px)
    low[axis] = at
    counts = np.insert(np.array(labels.shape[::-1]) + 1, axis, 1)
    plane = pyvista.ImageData(dimensions=counts, spacing=[max(high - low) / px] * 3, origin=low)
    plane.cell_data["colour"] = np.round(255 * rgb(PHASES)[labels.ravel()]).astype(np.uint8)
    return plane


def draw_cracks() -> np.ndarray:
    """The cracks of a cube that was crushed between plates with little friction, cut open; displacements five times."""
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 50.0}, "fraction": 0.4}, seed=1)
    response = packing.mesh(for_test=True, element_size=2.0).solve(friction=0.1, strain=0.005)
    grid = response.to_pyvista()
    grid.points += 5.0 * grid.point_data["displacement_mm"]
    shades = matplotlib.colors.LinearSegmentedColormap.from_list("cracks", [MORTAR, "#e8b7a4", CRACK, "#2b0d07"])

    def colors(cells: pyvista.DataSetAttributes) -> np.ndarray:
        opening = np.minimum(cells["crack_opening_mm"] / 0.05, 1.0)
        return np.where((cells["phase"] == 2)[:, None], rgb(_PALETTE)[cells["phase"]], shades(opening)[:, :3])

    plotter = new_plotter()
    add_painted(plotter, cut_open(grid), colors)
    return seen(plotter, packing.bounds)


def draw_flux() -> list[np.ndarray]:
    """A cube that was split, cut open: its cracks, and the flux of chloride along z, for which they are the way."""
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        run = lambda *words: subprocess.run(["mesocrete", *words, "--quiet"], cwd=folder, check=True)  # noqa: E731
        Path(folder, "spec.toml").write_text(SPLIT, encoding="utf-8")
        run("solve", "spec.toml", "-o", "run", "--test", "splitting", "--strain", "0.003", "--element-size-mm", "1.5", "--frames", "1")
        run("effective", "run", "--frame", "last", "--axes", "z", "-o", "found")
        frame, flux = (pyvista.read(Path(folder, name)) for name in ("run/frame_0001.vtu", "found/diffusivity_z.vtu"))
    strength = np.linalg.norm(flux.cell_data["flux"], axis=1)
    for grid, values, most in [(frame, frame.cell_data["crack_opening_mm"], 0.04), (flux, strength, 4.0)]:
        grid.cell_data["shade"] = np.minimum(values / most, 1.0)
        grid.cell_data["phase"] = frame.cell_data["phase"]
        shades = matplotlib.colors.LinearSegmentedColormap.from_list("shades", [MORTAR, "#e8b7a4", CRACK, "#2b0d07"])
        colors = lambda cells: np.where((cells["phase"] == 2)[:, None], rgb(_PALETTE)[cells["phase"]], shades(cells["shade"])[:, :3])  # noqa: E731, B023
        plotter = new_plotter()
        add_painted(plotter, cut_open(grid, "x"), colors)
        pictures.append(seen(plotter, tuple(np.array(grid.bounds).reshape(3, 2).T.tolist())))
    return pictures


def cut_open(grid: pyvista.UnstructuredGrid, away: str = "-y") -> pyvista.PolyData:
    """The surface of half of it: what lies on the side of the middle that this direction points away from."""
    low, high = np.array(grid.bounds).reshape(3, 2).T
    return grid.clip(away, origin=(low + high) / 2.0).extract_surface(algorithm="dataset_surface")


def rgb(colors: list[str]) -> np.ndarray:
    """Red, green and blue of each, 0 to 1."""
    return np.array([matplotlib.colors.to_rgb(color) for color in colors])


def add_painted(plotter: pyvista.Plotter, shown: pyvista.PolyData, colors: Callable, **options: object) -> None:
    """Add a surface whose cells have these colours, 0 to 1, of their data."""
    shown.cell_data["colour"] = np.round(255 * colors(shown.cell_data)).astype(np.uint8)
    plotter.add_mesh(shown, scalars="colour", rgb=True, ambient=0.15, **options)


def new_plotter(pixels: int = 1500) -> pyvista.Plotter:
    """An empty white picture."""
    plotter = pyvista.Plotter(off_screen=True, window_size=[pixels, pixels])
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    return plotter


def seen(plotter: pyvista.Plotter, bounds: tuple[list[float], list[float]]) -> np.ndarray:
    """The picture from above a corner as pixels, without the white around it."""
    low, high = map(np.array, bounds)
    plotter.camera_position = [(low + high) / 2.0 + np.array([1.9, -2.5, 1.5]), (low + high) / 2.0, (0, 0, 1)]
    plotter.reset_camera()
    plotter.camera.zoom(0.9)
    pixels = plotter.screenshot(None, return_img=True)
    used = (pixels < 250).any(axis=2)
    rows, columns = (np.flatnonzero(used.any(axis=axis)) for axis in (1, 0))
    if rows[0] == 0 or columns[0] == 0 or rows[-1] == len(pixels) - 1 or columns[-1] == len(pixels[0]) - 1:
        sys.exit("a picture is cropped")
    return pixels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def save(pictures: list[np.ndarray], path: Path, height: int) -> None:
    """Write pictures side by side, equally high, with 128 colours: a third of the bytes, and the eye sees no difference."""
    images = [Image.fromarray(pixels) for pixels in pictures]
    images = [image.resize((round(image.width * height / image.height), height), Image.Resampling.LANCZOS) for image in images]
    gap = height // 10
    whole = Image.new("RGB", (sum(image.width for image in images) + gap * len(images), height + gap), "white")
    left = gap // 2
    for image in images:
        whole.paste(image, (left, gap // 2))
        left += image.width + gap
    whole.quantize(128).save(path, optimize=True)


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
