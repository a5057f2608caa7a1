#!/usr/bin/env python3
"""What grows with size, and how: user CPU seconds and peak memory of eight works over two decades of their sizes.

    python3 benches/growth.py [PROGRAM]     # enters benches/results/growth.csv, draws growth.svg, prints the table
    python3 benches/growth.py --quick       # the two smallest sizes of each; enters nothing

One process at a time, one thread each, 500 CPU seconds together. Cubes of 40 % with grains of 4 to 10 mm are meshed, tested and
made into images, so that a larger one has more grains of the same sizes. PROGRAM is `mesocrete` by default. A row that
stands in the table is kept.
"""

import csv
import functools
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from origin import RESULTS, origin

TABLE, PICTURE = RESULTS / "growth.csv", RESULTS / "growth.svg"
HEADER = "work,unit,side_mm_or_divisions,size,user_s,peak_mb,machine,date,commit"
CUBES = (25, 38, 57, 80, 116)
# Works, what is counted, and the sides of their cubes in mm, or how often the triangles of a scan are divided.
WORKS = {"packing": ("grains", (60, 80, 110, 150, 200, 270)), "reduction": ("triangles", (5, 6, 7, 8, 9))}
WORKS |= {work: ("tetrahedra", CUBES) for work in ("fitted lattice", "1000 steps")}
WORKS |= {work: ("voxels", CUBES) for work in ("image", "diffusivity", "stiffness", "import")}
# Edges of a voxel, mm, and durations, s, of the two tests whose difference is a number of steps.
VOXELS = {"image": 0.2, "diffusivity": 0.5, "stiffness": 1.0, "import": 0.5}
DURATIONS = (2e-5, 1.2e-4)
LATTICE = ["--method", "lattice", "--element-size-mm", 2, "--accept-phase-error"]
SPEC = "seed = 1\nfraction = {}\nspecimen = {{ kind = 'cube', side_mm = {:.1f} }}\n{}\n"
# Fits leave shorter times out, which are those of a start and of files; bytes leave out the command's own memory.
SHORT_S, OWN_MB, LIMIT_MB = 0.2, 8.0, 24e3


def run(program: str, folder: Path, *words: object) -> tuple[float, float]:
    """User seconds and peak MB of a command, which writes its files even where it warns of a fast test."""
    # The memory of this process would count: it stays small.
    process = subprocess.Popen([program, *map(str, words), "--quiet", "--force", "--threads", "1"], cwd=folder, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status != 0 and words[0] != "solve":
        sys.exit(f"{words} failed")
    return used.ru_utime, used.ru_maxrss * 1024 / 1e6


def measured(program: str, folder: Path, work: str, size: int) -> tuple[int, float, float]:
    """How many of its units a work has, its user seconds and peak MB."""
    command = functools.partial(run, program, folder)

    def pack(fraction: float, side: int, of: str) -> tuple[float, float]:
        (folder / "s.toml").write_text(SPEC.format(fraction, side, of))
        return command("pack", "s.toml", "-o", "packed.json", "--summary-json", "summary.json")

    def of(path: str, name: str) -> int:
        return json.loads((folder / path).read_text())[name]

    if work == "packing":
        cost = pack(0.5, size, "grading = { d_min_mm = 5, d_max_mm = 20 }")
        return of("summary.json", "aggregates"), *cost
    if work == "reduction":
        multiprocessing.get_context("spawn").Pool(1).apply(stone, (folder / "grains", size))
        return 8 * 4**size, *pack(0.2, 60, f"shape = {{ library = '{folder / 'grains'}', tolerance = 0.005 }}")
    pack(0.4, size, "grading = { d_min_mm = 4, d_max_mm = 10 }")
    if work == "fitted lattice":
        cost = command("mesh", "packed.json", "-o", "mesh.vtu", *LATTICE, "--itz", "none", "--summary-json", "mesh.json")
        return of("mesh.json", "elements"), *cost
    if work == "1000 steps":
        flags = ["packed.json", "-o", "test", *LATTICE, "--control", "steady", "--strain", 1e-5, "--frames", 0, "--duration"]
        costs = [(*command("solve", *flags, duration), of("test/result.json", "steps")) for duration in DURATIONS]
        (short, _, few), (long, peak, many) = costs
        return of("test/result.json", "elements"), (long - short) * 1000 / (many - few), peak
    voxel = VOXELS[work]
    edges, what = ["--voxel-size-mm", voxel], "grain" if work == "import" else "phase"
    cost = command("image", "packed.json", "--what", what, *edges, "-o", "i.npy")
    if work == "import":
        cost = command("import", "i.npy", "--mortar=-1", *edges, "-o", "import.json")
    elif work != "image":
        cost = command("effective", "i.npy", "--what", work, *edges, "--no-fields", "--tolerance", 1e-6, "-o", "e")
    return round(size / voxel) ** 3, *cost


def stone(folder: Path, divisions: int) -> None:
    """A bumpy and rough stone in a file: an octahedron whose triangles are divided."""
    import numpy as np

    signs = [(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    triangles = np.array([[[x, 0, 0], [0, y, 0], [0, 0, z]][:: x * y * z] for x, y, z in signs], float)
    for _ in range(divisions):
        a, b, c = triangles.swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        triangles = np.concatenate([np.stack(part, 1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    u = triangles / np.linalg.norm(triangles, axis=2, keepdims=True)
    # Roughness is a function of the place, too, so that neighbours share their corners.
    waves, radius = np.random.default_rng(1).normal(size=(24, 3)) * 4, 1 + 6e-4 * np.sin((u * [1e4, 2e4, 3e4]).sum(axis=2))
    radius += sum(np.sin((u * wave).sum(axis=2) + number) for number, wave in enumerate(waves)) / 120
    stl = np.zeros(len(u), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("own", "<u2")])
    stl["corners"] = 10 * u * radius[..., None]
    folder.mkdir(exist_ok=True)
    (folder / "stone.stl").write_bytes(bytes(80) + np.uint32(len(u)).tobytes() + stl.tobytes())


def draw(rows: list[list[str]]) -> None:
    """Draw times and memory over size; print the exponents, and where 24 GB end at the bytes of the largest."""
    import numpy as np
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.2))
    panels = figure.subplots(1, 2)
    for number, (work, (unit, _)) in enumerate(WORKS.items()):
        size, user, peak = np.array(sorted([float(cell) for cell in row[3:6]] for row in rows if row[0] == work)).T
        kept, held = user > SHORT_S, (peak - OWN_MB) / size * 1e6
        slope, log = np.polyfit(np.log(size[kept]), np.log(user[kept]), 1)
        panels[0].loglog(size, user, f"C{number}o", ms=4)
        panels[0].loglog(size[kept], np.exp(log) * size[kept] ** slope, f"C{number}-", lw=0.8, label=f"{work}, {unit}: {slope:.2f}")
        panels[1].loglog(size, peak, f"C{number}o-", ms=4, lw=0.8)
        each = f"{user[-1] / size[-1] * 1e6:.3g} us | {slope:.2f} | {held[-1]:.3g} B | {LIMIT_MB * 1e6 / held[-1]:.2g}"
        print(f"| {work} | {size[0]:,.0f} to {size[-1]:,.0f} {unit} | {each} |")
    for axes, title in zip(panels, ("user CPU seconds, and their exponents", "peak memory, MB")):
        axes.set(title=title, xlabel="size")
        axes.grid(alpha=0.3)
    panels[1].legend(*panels[0].get_legend_handles_labels(), fontsize=7, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.savefig(PICTURE, bbox_inches="tight", metadata={"Date": None})
    with PICTURE.open("a") as file:
        file.write(f"<!-- {origin()} -->\n")


def main() -> None:
    """Measure what is missing, and draw it."""
    quick = "--quick" in sys.argv
    program = next((word for word in sys.argv[1:] if word != "--quick"), "mesocrete")
    rows = [] if quick or not TABLE.exists() else list(csv.reader(TABLE.read_text().splitlines()))[1:]
    with tempfile.TemporaryDirectory() as name:
        for work, unit, size in ((work, unit, size) for work, (unit, sizes) in WORKS.items() for size in sizes[: 2 if quick else None]):
            if not any(row[:3] == [work, unit, str(size)] for row in rows):
                count, user, peak = measured(program, Path(name), work, size)
                rows.append([work, unit, str(size), str(count), f"{user:.3f}", f"{peak:.1f}", *origin().split(",")])
                print(*rows[-1][:6], flush=True)
            if not quick:
                rows.sort(key=lambda row: ([*WORKS].index(row[0]), int(row[3])))
                TABLE.write_text("\n".join([HEADER, *map(",".join, rows)]) + "\n")
    if not quick:
        draw(rows)


if __name__ == "__main__":
    main()
