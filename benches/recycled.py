#!/usr/bin/env python3
"""Concrete of recycled aggregates: modulus, strength and strain at the peak over the replacement.

    python3 benches/recycled.py --program target/release/mesocrete >> benches/results/recycled.csv

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
FLAGS = ["--element-size-mm", "1", "--itz", "smeared", "--strain", "0.0032", "--frames", "0", "--quiet"]


def case(program: str, folder: Path, share: float, seed: int) -> list[object]:
    """Run a test; its attached mortar, in the packing and in the mesh, and its figures."""
    spec, materials, out = folder / "spec.toml", folder / "materials.toml", folder / f"out-{share}-{seed}"
    spec.write_text((SPEC + (OWN if share else "")).format(seed=seed, share=share), encoding="utf-8")
    materials.write_text("[materials]\n" + (MATERIALS if share else ""), encoding="utf-8")
    subprocess.run([program, "solve", spec, "-o", out, "--materials", materials, *FLAGS], check=True)
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
    parser.add_argument("--program", default="target/release/mesocrete")
    program = parser.parse_args().program
    print("replacement,seed,attached,attached_in_mesh,peak_mpa,peak_strain,modulus_mpa,machine,date,commit")
    with tempfile.TemporaryDirectory() as folder:
        for seed in (1, 2, 3):
            for share in (0, 0.3, 0.65, 1):
                print(*case(program, Path(folder), share, seed), origin(), sep=",", flush=True)


if __name__ == "__main__":
    main()
