#!/usr/bin/env python3
"""Concrete of recycled aggregates: modulus, strength and strain at the peak over the replacement.

    python3 benches/recycled.py --command target/release/mesocrete >> benches/results/recycled.csv
    python3 benches/recycled.py --quick    one packing, two replacements, elements of 3 mm

Cubes of 36 mm with 35 % of stones of 8 to 16 mm, elements of 1 mm, plates of friction 0.1, three packings. A share of the
stones carries 30 % of old mortar with 0.7 of the mortar's strengths. The grains are the same at every replacement.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from origin import origin

SPEC = """seed = {seed}
fraction = 0.35
specimen = {{ kind = "box", size_mm = [36, 36, 36] }}
grading = {{ d_min_mm = 8, d_max_mm = 16 }}
itz.thickness_mm = [0, 0]
"""
# A share of 0 is no phase.
OWN = """phases = [{{ name = "recycled", share = {share} }}]
shape.shells = [{{ name = "old_mortar", volume_share = 0.3, of = "recycled" }}]
"""
MATERIALS = """recycled = { youngs_modulus_mpa = 60000, poisson_ratio = 0.2, density_t_per_mm3 = 2.7e-9 }
old_mortar = { youngs_modulus_mpa = 15000, poisson_ratio = 0.2, density_t_per_mm3 = 2.1e-9, strength_ratio = 0.7 }
"""
FLAGS = ["--itz", "smeared", "--strain", "0.0032", "--frames", "0", "--quiet"]


def case(program: str, folder: Path, share: float, seed: int, *mesh: str) -> list[object]:
    """Run a test; its attached mortar, in the packing and in the mesh, and its figures."""
    spec, materials, out = folder / "spec.toml", folder / "materials.toml", folder / f"out-{share}-{seed}"
    spec.write_text((SPEC + (OWN if share else "")).format(seed=seed, share=share), encoding="utf-8")
    materials.write_text("[materials]\n" + (MATERIALS if share else ""), encoding="utf-8")
    subprocess.run([program, "solve", spec, "-o", out, "--materials", materials, *mesh, *FLAGS], check=True)
    result = json.loads((out / "result.json").read_text(encoding="utf-8"))
    phases = {phase["name"]: phase for phase in result["phases"]}
    attached = []
    for key in ("exact_fraction", "volume_fraction"):
        old, stone = (phases[name][key] if name in phases else 0.0 for name in ("old_mortar", "recycled"))
        attached.append(round(old / (old + stone), 4) if share else 0)
    return [share, seed, *attached, result["peak_mpa"], result["peak_strain"], result["modulus_mpa"]]


def main() -> None:
    """Print a row for each case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", default="target/release/mesocrete")
    parser.add_argument("--quick", action="store_true", help="one packing, two replacements, coarse elements")
    given = parser.parse_args()
    seeds, shares = ((1,), (0, 1)) if given.quick else ((1, 2, 3), (0, 0.3, 0.65, 1))
    mesh = ("--element-size-mm", *(["3", "--accept-phase-error"] if given.quick else ["1"]))
    print("replacement,seed,attached,attached_in_mesh,peak_mpa,peak_strain,modulus_mpa,machine,date,commit")
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            for share in shares:
                print(*case(given.command, Path(folder), share, seed, *mesh), origin(), sep=",", flush=True)


if __name__ == "__main__":
    main()
