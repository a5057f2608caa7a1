#!/usr/bin/env bash
# grainpy 0.1.0: folk_skew() calls a grading with a tail of fines "coarse skewed", and one with a tail of coarse grains "fine".
# By Folk and Ward (1957), whom it names, a positive skewness in phi units, which grow as grains get finer, is fine skewed.
# datast() computes it in phi with the right sign and then takes the name.
# Seen: a grading around 4 phi (1/16 mm) that spreads by 2 phi to the fine side and 0.6 phi to the coarse one has a skewness of
# 0.21, a mean finer than the median and the class "coarse skewed"; its mirror has -0.21 and "fine skewed".
# Sorting, kurtosis and Wentworth's names of sizes are right.
# Fix: folk_skew(-skewness).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile grainpy==0.1.0 pandas==1.5.3 openpyxl==3.1.5 matplotlib==3.11.2 scipy==1.17.1 numpy==1.26.4
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'PYTHON'
import importlib.metadata

import numpy as np
import pandas
from grainpy.classify import folk_skew
from grainpy.grainsize import GrainSizeDist

microns = 0.375198 * 2 ** (np.arange(93) / 6)  # the lower bounds of channels, the first as it is looked for by default
phi = -np.log2(microns / 1000)
for name, finer, coarser in (("fines", 2.0, 0.6), ("coarse", 0.6, 2.0)):
    share = np.exp(-0.5 * ((phi - 4) / np.where(phi > 4, finer, coarser)) ** 2)
    pandas.DataFrame({"size": microns, "share": 100 * share / share.sum()}).to_excel(f"{name}.xlsx", header=False, index=False)
table = GrainSizeDist(["fines.xlsx", "coarse.xlsx"]).datast()
print("grainpy", importlib.metadata.version("grainpy"))
rows = ["median", "mean_folk", "skewness_folk", "skewness_folk_class"]
print(table.loc[rows, ["fines", "coarse"]].to_string())
fines, coarse = table["fines"], table["coarse"]
assert fines["mean_folk"] > fines["median"] and coarse["mean_folk"] < coarse["median"]
assert 0.2 < fines["skewness_folk"] < 0.25 and -0.25 < coarse["skewness_folk"] < -0.2
assert fines["skewness_folk_class"] == "coarse skewed" and coarse["skewness_folk_class"] == "fine skewed"
assert folk_skew(0.5) == "strongly coarse skewed" and folk_skew(-0.5) == "strongly fine skewed"
PYTHON
