#!/usr/bin/env bash
# santex 1.2.3: get_voigt_reuss_hill() adds up the stiffness of all grains of a phase rather than their mean.
# Each of the n grains is weighted by the share of its phase, n of all, and not by 1 of all. The compliance for "reuss" is
# np.linalg.inv() of a 3 x 3 x 3 x 3 tensor, which inverts 3 x 3 blocks one by one; that is no compliance, and is singular for
# a crystal along its axes.
# Seen: grains of a cubic crystal with a bulk modulus of 98 GPa, which no rotation changes, have 98, 196, 980 and 4900 GPa
# for 1, 2, 10 and 50 grains by "voigt", and 98, 48, 9.6 and 1.9 by "reuss"; two phases of 30 and 10 grains of it have 2450.
# The density is right, and so is get_anisotropy_for_ebsd() with its default.
# Fix: get_anisotropy_for_ebsd() for Voigt; an own mean of inverted 6 x 6 matrices for Reuss.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile santex==1.2.3 vtk==9.7.2 orix==0.15.0 scikit-learn==1.9.1 plotly==7.1.0 tabulate==0.10.0 joblib==1.6.0 tqdm==4.70.1 matplotlib==3.11.2 pandas==3.1.1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'PYTHON'
import importlib.metadata

import numpy as np
import pandas
from santex.ebsd import EBSD

crystal = np.zeros((6, 6))
crystal[:3, :3] = 64.0
crystal[range(3), range(3)] = 166.0
crystal[range(3, 6), range(3, 6)] = 80.0
header = "Channel Text File\n"  # the angles are given below, so that the file has no points
open("rock.ctf", "w").write(header)
rock, random = EBSD("rock.ctf"), np.random.default_rng(1)


def grains(count):
    return pandas.DataFrame(random.uniform(0, 360, (count, 3)), columns=["Euler1", "Euler2", "Euler3"])


def bulk(stiffness):
    return float(np.asarray(stiffness)[:3, :3].sum() / 9)


right = bulk(crystal)
print("santex", importlib.metadata.version("santex"), "bulk modulus of the crystal:", right)
for count in (1, 2, 10, 50):
    angles = [grains(count)]
    seen, density = rock.get_voigt_reuss_hill([crystal], angles, [2.65], method="voigt")
    plain = bulk(rock.get_anisotropy_for_ebsd([crystal], angles, [2.65])[0])
    reuss = bulk(rock.get_voigt_reuss_hill([crystal], angles, [2.65], method="reuss")[0])
    print(f"  {count} grains: voigt {bulk(seen):.1f}, reuss {reuss:.1f}, by get_anisotropy_for_ebsd() {plain:.1f}")
    assert count == 1 or reuss < right / (0.9 * count)
    assert np.isclose(bulk(seen), count * right) and np.isclose(plain, right) and np.isclose(density, 2.65)
two = bulk(rock.get_voigt_reuss_hill([crystal, crystal], [grains(30), grains(10)], [2.65, 2.65], method="voigt")[0])
print(f"  30 and 10 grains in two phases: {two:.1f}")
assert np.isclose(two, right * (30**2 + 10**2) / 40)
PYTHON
