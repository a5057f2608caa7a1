#!/usr/bin/env python3
"""Computes the properties that stand beside experiments in docs/measured/properties.md, and prints its tables.

    python3 docs/validation/properties.py            (with the package installed; some two minutes)

Each scale is a periodic packing: sand in paste, then gravel in that mortar. The points are in the `.csv` files here.
"""

import csv
from pathlib import Path
from statistics import mean

import numpy as np

import mesocrete as mc

HERE = Path(__file__).parent
# Young's modulus of the aggregates, MPa: quartzite and basalt lie on both sides. An assumption: the source states none.
STONES = (50_000, 60_000, 70_000)
SEEDS = (1, 2)
SCALE = {"specimen": {"kind": "cube", "side_mm": 30, "periodic": ["x", "y", "z"]}, "grading": {"d_min_mm": 5, "d_max_mm": 12}}


def rows(name: str) -> list[dict[str, str]]:
    """Read a table without its comments."""
    text = (HERE / name).read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in text if not line.startswith("#")))


def packings(fraction: float) -> list[mc.Packing]:
    """Pack grains without an ITZ; a scale has no size, so one grading stands for sand and gravel."""
    return [mc.pack({**SCALE, "fraction": fraction, "itz": {"thickness_mm": [0, 0]}}, seed=seed) for seed in SEEDS]


def modulus(packed: list[mc.Packing], matrix: float, stone: float) -> float:
    """Return Young's modulus of grains in a matrix, MPa."""
    phases = {name: {"youngs_modulus_mpa": value} for name, value in (("mortar", matrix), ("itz", matrix), ("aggregate", stone))}
    found = [one.effective("stiffness", voxel_size=0.75, phases=phases, tolerance=1e-8) for one in packed]
    return mean(one.isotropic["youngs_modulus_mpa"] for one in found)


def concrete(scales: list[list[mc.Packing]], paste: float, stone: float) -> float:
    """Return the modulus of sand in paste, and of gravel in that, MPa."""
    sand, gravel = scales
    return modulus(gravel, modulus(sand, paste, stone), stone)


def moduli() -> None:
    """Print the moduli of KIT's concretes: the paste fits the first one, the others are predicted."""
    mixes = rows("kit_2023_modulus_over_aggregate.csv")
    scales = []
    for mix in mixes:
        whole, gravel = float(mix["aggregate_fraction"]), float(mix["coarse_fraction"])
        scales.append([packings((whole - gravel) / (1 - gravel)), packings(gravel)])
    measured = [mean(float(mix[f"e{k}_mpa"]) for k in (1, 2, 3)) for mix in mixes]
    print("| aggregates | measured, GPa | " + " | ".join(f"stone of {stone / 1e3:.0f} GPa" for stone in STONES) + " |")
    print("|---|---|" + "---|" * len(STONES))
    columns, pastes = [], []
    for stone in STONES:
        # The secant's steps on the first mix.
        paste, before = 15_000.0, (12_000.0, concrete(scales[0], 12_000.0, stone))
        for _ in range(4):
            found = concrete(scales[0], paste, stone)
            slope = (found - before[1]) / (paste - before[0])
            before, paste = (paste, found), paste + (measured[0] - found) / slope
            if abs(measured[0] - found) < 5:
                break
        pastes.append(paste)
        columns.append([concrete(own, paste, stone) for own in scales])
    for number, mix in enumerate(mixes):
        values = [f"{column[number] / 1e3:.1f}" + (" (input)" if number == 0 else "") for column in columns]
        print(f"| {mix['aggregate_fraction']} | {measured[number] / 1e3:.1f} | " + " | ".join(values) + " |")
    print("paste:", ", ".join(f"{paste / 1e3:.1f}" for paste in pastes))


def chloride() -> None:
    """Print the diffusivity of mortar and concrete over that of the paste, times the measured pastes."""
    factors = [mean(np.trace(one.effective(voxel_size=0.75).tensor) / 3 for one in packings(share)) for share in (0.5, 0.4)]
    mortar, of_concrete = factors[0], factors[0] * factors[1]
    print(f"\nsand 0.5 in paste {mortar:.3f}, gravel 0.4 in that {of_concrete:.3f}")
    print("| w/c | pastes | mean of the pastes, least, largest | mortar | concrete |\n|---|---|---|---|---|")
    for ratio in ("0.4", "0.5", "0.6", "0.7"):
        values = [float(row["d_1e12_m2_s"]) for row in rows("chloride_paste_over_wc.csv") if row["w_c"] == ratio]
        low, middle, high = min(values), mean(values), max(values)
        print(f"| {ratio} | {len(values)} | {middle:.1f}, {low:.1f}, {high:.1f} | {middle * mortar:.2f} | {middle * of_concrete:.2f} |")


if __name__ == "__main__":
    moduli()
    chloride()
