#!/usr/bin/env bash
# hashin-shtrikman-mp 0.1.2: bounds of the shear modulus are too high, by the fractions of other phases, or no bounds at all.
# The term of the reference phase has 3 (K + G) where 6 (K + 2 G) belongs (Hashin and Shtrikman, 1963; Walpole, 1966). Shear
# moduli are sorted on their own and take the fractions in the order of the bulk moduli. Phases of one bulk modulus have the
# least and the largest shear modulus as bounds. Those of the bulk modulus are right.
# Seen in GPa: 60 % of stone (45, 30) in mortar (14, 10) has 20.52 to 21.39, right are 18.58 to 20.03; the lower is above the
# right upper one. Quartz (37, 44) with 20 % of calcite (76.8, 32), which has the larger bulk and smaller shear modulus, has
# 34.28 to 34.31, right are 41.25 to 41.31. Halves of (40, 20) and (40, 35) have 20 to 35, right are 26.36 to 26.58.
# The client of the web database that it searches is an empty module here, since nothing is searched.
# Fix: own bounds as here.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps hashin-shtrikman-mp==0.1.2 pydantic==2.14.4 pydantic_core==2.50.5 annotated-types==0.8.0 typing-inspection==0.4.5 typing_extensions==4.16.0 monty==2026.10.21 PyYAML==6.0.4 ruamel.yaml==0.19.1 plotly==7.1.0 narwhals==2.29.0 packaging==26.4 pandas==3.1.1 python-dateutil==2.9.0.post0 six==1.17.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
mkdir mp_api
touch mp_api/__init__.py
echo "MPRester = None" > mp_api/client.py
cat > bounds.py <<'PYTHON'
import importlib.metadata

import numpy as np
from hashin_shtrikman_mp.core.genetic_algorithm import GeneticAlgorithmParams, Member, OptimizationParams


def seen(bulk, shear, fractions, side):
    properties = {"bulk_modulus": "vrh", "shear_modulus": "vrh", "universal_anisotropy": None}
    options = OptimizationParams(
        property_categories=["elastic"], property_docs={"elastic": properties}, num_materials=len(bulk), num_properties=4
    )
    phases = [value for i, pair in enumerate(zip(bulk, shear)) for value in (*pair, 0.1 + 0.1 * i)]
    member = Member(GeneticAlgorithmParams(mixing_param=float(side)), options, np.array([*phases, *fractions]))
    return tuple(float(value) for value in member.get_effective_properties()[:2])


def right(bulk, shear, fractions, side):
    k, g = (np.max(bulk), np.max(shear)) if side else (np.min(bulk), np.min(shear))
    fractions, z = np.array(fractions), g / 6 * (9 * k + 8 * g) / (k + 2 * g)
    return 1 / np.sum(fractions / (np.array(bulk) + 4 / 3 * g)) - 4 / 3 * g, 1 / np.sum(fractions / (np.array(shear) + z)) - z


def explained(bulk, shear, fractions, side):
    if len(set(bulk)) == 1:
        return np.max(shear) if side else np.min(shear)
    fractions, shear = np.array(fractions)[np.argsort(bulk)], np.sort(shear)
    k, g = (np.max(bulk), shear[-1]) if side else (np.min(bulk), shear[0])
    weak = 3 * (k + g) / (5 * g * (3 * k + 4 * g))
    sums = sum(f / (1 / (s - g) + weak) for f, s in zip(fractions, shear) if s != g)
    return g + sums / (1 - weak * sums)


def main():
    print("hashin-shtrikman-mp", importlib.metadata.version("hashin-shtrikman-mp"))
    mixtures = {
        "mortar and stone": ((14, 45), (10, 30), (0.4, 0.6)),
        "quartz and calcite": ((37, 76.8), (44, 32), (0.8, 0.2)),
        "one bulk modulus": ((40, 40), (20, 35), (0.5, 0.5)),
    }
    shears = {}
    for name, mixture in mixtures.items():
        for side in (0, 1):
            own, true = seen(*mixture, side), right(*mixture, side)
            print("  {}: shear {:.2f}, right {:.2f}; bulk {:.2f}, right {:.2f}".format(name, own[1], true[1], own[0], true[0]))
            assert np.isclose(own[0], true[0]) and np.isclose(own[1], explained(*mixture, side))
            shears[name, side] = own[1], true[1]
    assert shears["mortar and stone", 0][0] > shears["mortar and stone", 1][1]
    assert shears["quartz and calcite", 1][0] < 34.4 and shears["quartz and calcite", 0][1] > 41.2
    assert shears["one bulk modulus", 0][0] == 20 and shears["one bulk modulus", 1][0] == 35


if __name__ == "__main__":
    main()
PYTHON
"$folder/venv/bin/python" bounds.py
