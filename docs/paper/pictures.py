"""Pictures of the compression tests that run.py has run: curves, sections of damage and of stress."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path

import matplotlib
import numpy as np
import pyvista
from matplotlib import pyplot

matplotlib.use("Agg")
# Points of the curve, as the paper names them: share of the peak, and where.
POINTS = {"A": (0.3, "before"), "B": (0.8, "before"), "C": (1.0, "at the peak"), "D": (0.8, "after"), "E": (0.0, "at the end")}
# Points whose stress in the aggregates is drawn, too.
STRESSED = "DE"
# What `phase` holds in a cell of an aggregate.
AGGREGATE = 2


def draw(done: list[tuple], out: Path) -> None:
    """Draw the curves of every group of `done`, pairs of a case and its folder, and sections of the frictions."""
    for group in dict.fromkeys(case.group for case, _ in done):
        draw_curves([(case, folder) for case, folder in done if case.group == group], out / f"{group}.png")
    for case, folder in done:
        if case.group == "friction":
            frames = read_frames(folder)
            tell_damage(case.name, frames["E"])
            if case.seed == 1:
                tell_stress(case.name, frames)
                draw_sections(case.label, frames, out / f"damage-{case.label}.png")


def read_curve(folder: Path) -> tuple[list[float], list[float]]:
    """Read strain and stress of a case."""
    with (folder / "curve.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [float(r["strain"]) for r in rows], [float(r["stress_mpa"]) for r in rows]


def draw_curves(group: list[tuple], path: Path) -> None:
    """All curves of a group, one colour a label."""
    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    labels = list(dict.fromkeys(case.label for case, _ in group))
    named = set()
    for case, folder in group:
        strain, stress = read_curve(folder)
        name = None if case.label in named else case.label
        axes.plot([100 * x for x in strain], stress, f"C{labels.index(case.label)}", lw=1, label=name)
        named.add(case.label)
    if group[0][0].group == "friction":
        axes.axhline(35.6, color="black", lw=0.8, ls="--", label="peak in Vonk's test")
    axes.set(xlabel="strain, %", ylabel="stress, MPa", title=group[0][0].group, ylim=(0, None))
    axes.legend()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def frames_at_points(folder: Path) -> dict[str, str]:
    """Find the frame of each of the points A to E: the one of the nearest stress on its side of the peak."""
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    frames, strain, stress = (result[key] for key in ("frames", "peak_strain", "peak_mpa"))
    peak = min(range(len(frames)), key=lambda i: abs(frames[i]["strain"] - strain))
    places = {"before": frames[: peak + 1], "at the peak": [frames[peak]], "after": frames[peak:], "at the end": frames[-1:]}
    return {
        point: min(places[place], key=lambda frame: abs(frame["stress_mpa"] - share * stress))["file"]
        for point, (share, place) in POINTS.items()
    }


def read_frames(folder: Path) -> dict:
    """Read the frames at the points A to E, by their points; a frame at two points is read once."""
    files = frames_at_points(folder)
    meshes = {file: pyvista.read(folder / file) for file in dict.fromkeys(files.values())}
    return {point: meshes[file] for point, file in files.items()}


def draw_sections(label: str, frames: dict, path: Path) -> None:
    """Damage at half depth at the points A to E, and the least principal stress of the aggregates at D and E."""
    figure, axes = pyplot.subplots(1, len(POINTS) + len(STRESSED), figsize=(19, 3.1), layout="constrained")
    stressed = iter(axes[len(POINTS) :])
    for axis, (point, mesh) in zip(axes, frames.items(), strict=False):
        cut = mesh.slice(normal="y").triangulate()
        aggregate = cut["phase"] == AGGREGATE
        paint(axis, cut, np.where(aggregate, np.nan, cut["damage"]), cmap="inferno_r", vmin=0, vmax=1)
        axis.set(title=point)
        if point in STRESSED:
            stress, beside = np.where(aggregate, least_principal(cut["stress_mpa"]), np.nan), next(stressed)
            colours = paint(beside, cut, stress, cmap="viridis", vmin=-95, vmax=0)
            beside.set(title=f"{point}, aggregates")
    figure.colorbar(colours, ax=axes[-1], label="least principal stress, MPa")
    figure.suptitle(f"damage, friction {label}")
    figure.savefig(path, dpi=80)
    pyplot.close(figure)


def paint(axis: pyplot.Axes, cut, values: np.ndarray, **colours):
    """Fill the triangles of a section, seen along y."""
    faces = cut.faces.reshape(-1, 4)[:, 1:]
    axis.set(aspect="equal", xticks=[], yticks=[], facecolor="0.7")
    axis.margins(0)
    values = np.ma.masked_invalid(values)
    return axis.tripcolor(cut.points[:, 0], cut.points[:, 2], faces, facecolors=values, **colours)


def least_principal(tensors: Iterable) -> np.ndarray:
    """Least principal value of symmetric tensors xx, yy, zz, xy, yz, xz, one a row."""
    xx, yy, zz, xy, yz, xz = np.asarray(tensors, dtype=float).T
    rows = [np.stack(row, -1) for row in ([xx, xy, xz], [xy, yy, yz], [xz, yz, zz])]
    return np.linalg.eigvalsh(np.stack(rows, -2))[:, 0]


def tell_stress(name: str, frames: dict) -> None:
    """Print what stress the aggregates carry at the peak, after it and at the end."""
    for point in "CDE":
        mesh = frames[point]
        least = least_principal(mesh["stress_mpa"][mesh["phase"] == AGGREGATE])
        percentiles = ", ".join(f"{np.percentile(least, p):.0f}" for p in (1, 50, 99))
        print(f"{name}: least principal stress in the aggregates at {point}, percentiles 1, 50, 99: {percentiles} MPa")


def tell_damage(name: str, mesh) -> None:
    """Print how much is damaged near the plates and between in the last frame."""
    sizes = mesh.compute_cell_sizes(length=False, area=False)["Volume"]
    low, high = mesh.bounds[4:]
    height = (mesh.cell_centers().points[:, 2] - low) / (high - low)
    matrix = mesh["phase"] != AGGREGATE
    near, middle = matrix & (np.abs(height - 0.5) > 0.4), matrix & (np.abs(height - 0.5) < 0.1)
    broken = (mesh["damage"] > 0.9) * sizes
    shares = [broken[part].sum() / sizes[part].sum() for part in (near, middle)]
    print(f"{name}: {shares[0]:.0%} of mortar and ITZ broken in the tenths at the plates, {shares[1]:.0%} in the middle fifth")
