#!/usr/bin/env bash
# pygradations 0.1.1: get_characteristic_sizes() of a share below the finest sieve is the size of the coarsest one.
# A share above all others is that of the finest sieve; the two are the wrong way round. No message.
# D10 divides in the coefficients of uniformity and of curvature, so that 10 % of fines below the last sieve spoil both.
# Seen: an aggregate of 0 to 31.5 mm, of which 12 % pass the last sieve of 0.25 mm, has D10 of 31.5 mm and a coefficient of
# uniformity of 0.24, which cannot be below 1; it is above 29.9. One sieve more, 0.125 mm, gives D10 of 0.19 mm and 39.8.
# An aggregate whose first sieve holds back 15 % has D90 of 0.125 mm.
# Fix: a sieve below which less than 10 % pass, and one that 100 % pass.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps pygradations==0.1.1 scipy==1.17.1 pandas==3.1.1 python-dateutil==4.0.0 six==1.17.0 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
import pandas
from pygradations import utils

sieves, retained = [31.5, 16, 8, 4, 2, 1, 0.5, 0.25, 0.125], [0, 20, 18, 15, 13, 10, 7, 5, 4]


def sizes(of, shares):
    table = utils.calculate_cumulative_percentages(pandas.DataFrame({"sieve": of, "p": shares}))
    found = {name: float(size) for name, size in utils.get_characteristic_sizes(table).items()}
    return found, float(utils.calculate_uniformity_coefficient(table)), table["wp"].to_numpy()


print("pygradations", importlib.metadata.version("pygradations"))
short, uniformity, passing = sizes(sieves[:-1], retained[:-1])
print("  up to 0.25 mm, which", passing[-1], "% pass:", short, "uniformity:", round(uniformity, 3))
whole, right, passed = sizes(sieves, retained)
print("  up to 0.125 mm, which", passed[-1], "% pass:", whole, "uniformity:", round(right, 3))
coarse, _, first = sizes(sieves, [15, 20, 18, 15, 10, 7, 5, 4, 2])
print("  the first sieve holds back 15 %:", coarse)
assert passing[-1] == 12 and passed[-1] == 8 and first[0] == 85
assert short["D10"] == 31.5 and np.isclose(uniformity, short["D60"] / 31.5) and uniformity < 1 < right
assert np.isclose(whole["D10"], np.interp(10, passed[::-1], sieves[::-1])) and whole["D60"] == short["D60"]
assert right > short["D60"] / 0.25 > 29.8
assert coarse["D90"] == 0.125 < coarse["D60"]
PYTHON
