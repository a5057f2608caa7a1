#!/usr/bin/env python3
"""Small specimens of asphalt, soil with rock, mortar of sand and dam concrete under load.

    python3 benches/materials_other.py --command target/release/mesocrete >> benches/results/materials_other.csv
    python3 benches/materials_other.py --quick    asphalt alone, coarse elements

Each is the recipe of its material with a smaller specimen and without its finest stones. All values of materials are chosen:
none is of a source. The matrix's modulus, compressive strength and K_c stand in each row.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from origin import origin

SPECS = {
    "asphalt": """fraction = 0.84
specimen = {{ kind = "cube", side_mm = 40 }}
grading = {{ curve = {{ kind = "fuller", exponent = 0.45 }}, d_min_mm = 4.75, d_max_mm = 16, form = "raw", size = "sieve" }}
voids = {{ fraction = 0.04, diameter_mm = [3, 5] }}
placement.min_gap_mm = 1.25
""",
    "rock-soil": """fraction = 0.4
specimen = {{ kind = "cylinder", diameter_mm = 60, height_mm = 120 }}
grading = {{ curve = {{ kind = "fuller", exponent = 0.5 }}, d_min_mm = 10, d_max_mm = 20, size = "sieve" }}
placement.min_gap_mm = 2
""",
    "sand": """fraction = 0.58
specimen = {{ kind = "cube", side_mm = 8 }}
grading = {{ curve = {{ kind = "sieves", sieves_mm = [0.08, 0.16, 0.5, 1, 1.6, 2], passing_percent = [1, 13, 33, 67, 93, 100] }}, d_min_mm = 0.8, d_max_mm = 2, form = "raw" }}
placement.min_gap_mm = 0.2
""",
    "dam": """fraction = 0.47
specimen = {{ kind = "cube", side_mm = 150 }}
grading = {{ curve = {{ kind = "sieves", sieves_mm = [5, 20, 40], passing_percent = [0, 50, 100] }}, d_min_mm = 15, d_max_mm = 40, form = "raw" }}
placement.min_gap_mm = 3
""",
}
STRENGTHS = {
    "asphalt": {"peak_strain": 0.006, "tensile_mpa": 3.0, "fracture_energy_n_per_mm": 0.1, "crushing_energy_n_per_mm": 5.0},
    "rock-soil": {"peak_strain": 0.02, "tensile_mpa": 0.03, "fracture_energy_n_per_mm": 0.005, "crushing_energy_n_per_mm": 1.0},
}
# Material, its elements' size in mm, Poisson's ratio of the matrix, and a test's strain at the end.
ELEMENTS = {"asphalt": "2.5", "rock-soil": "5", "sand": "0.4", "dam": "6"}
POISSON = {"asphalt": 0.3, "rock-soil": 0.3}
# Material, test, lateral pressure, seed, and the matrix: modulus, compressive strength, K_c.
CASES = [
    *(("asphalt", test, 0, seed, 6000, 18, 0.72) for seed in (1, 2, 3) for test in ("compression", "tension")),
    ("rock-soil", "compression", 0, 1, 50, 0.2, 0.72),
    *(("rock-soil", "triaxial", pressure, 1, 50, 0.2, 0.72) for pressure in (0.05, 0.1, 0.2, 0.4)),
    ("sand", "compression", 0, 1, 20000, 33, 0.72),
    ("dam", "compression", 0, 1, 20000, 33, 0.72),
]


def case(program: str, folder: Path, number: int, size: str | None, *given) -> list[object]:
    """Run a test; its elements, stones, strength and their strain, modulus, stress at the end and kinetic share."""
    material, test, pressure, seed, modulus, strength, kc = given
    spec, materials, out = folder / "spec.toml", folder / "materials.toml", folder / f"out-{number}"
    spec.write_text(f"seed = {seed}\nitz.thickness_mm = [0, 0]\n" + SPECS[material].format(), encoding="utf-8")
    own = dict(STRENGTHS.get(material, {}))
    if own:
        # The curve must rise from its elastic strain.
        own["peak_strain"] = max(own["peak_strain"], 1.2 * strength / modulus)
    lines = [f"mortar.youngs_modulus_mpa = {modulus}", f"meso.meridian_ratio = {kc}"]
    lines += [f"mortar.poisson_ratio = {POISSON[material]}", "mortar.density_t_per_mm3 = 2.0e-9"] if own else []
    lines += [f"mortar_strength.{key} = {value}" for key, value in (own | {"compressive_mpa": strength}).items()]
    lines += ["aggregate.youngs_modulus_mpa = 30000", "meso.meridian_bend = 0.0"] if material == "rock-soil" else []
    materials.write_text("[materials]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    strain = {"asphalt": 0.012, "rock-soil": 0.06}.get(material, 0.005) if test != "tension" else 0.002
    flags = ["--test", test, "--strain", strain, "--element-size-mm", size or ELEMENTS[material], "--frames", 0, "--quiet"]
    flags += ["--pressure-mpa", pressure] if pressure else []
    flags += ["--accept-phase-error"] if size else []
    command = [program, "solve", spec, "-o", out, "--materials", materials, "--itz", "none", *flags]
    subprocess.run([str(word) for word in command], check=True)
    result = json.loads((out / "result.json").read_text(encoding="utf-8"))
    stones = next(phase["volume_fraction"] for phase in result["phases"] if phase["name"] == "aggregate")
    figures = ["peak_mpa", "peak_strain", "modulus_mpa", "stress_at_end_mpa", "kinetic_over_internal_to_half_peak"]
    return [*given, result["elements"], round(stones, 4), *(float(f"{result[key]:.5g}") for key in figures)]


def main() -> None:
    """Print a row for each case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", default="target/release/mesocrete")
    parser.add_argument("--quick", action="store_true", help="asphalt alone, coarse elements")
    given = parser.parse_args()
    print(
        "material,test,pressure_mpa,seed,matrix_modulus_mpa,matrix_strength_mpa,matrix_kc,elements,stones_in_mesh,peak_mpa,"
        "peak_strain,modulus_mpa,stress_at_end_mpa,kinetic_over_internal,machine,date,commit"
    )
    with tempfile.TemporaryDirectory() as folder:
        for number, row in enumerate(CASES[:1] if given.quick else CASES):
            size = "5" if given.quick else None
            print(*case(given.command, Path(folder), number, size, *row), origin(), sep=",", flush=True)


if __name__ == "__main__":
    main()
