#!/usr/bin/env bash
# nanoshot-stamp 0.1.0a6: saltykov() does not divide a class by the share of its spheres' sections that fall in that class.
# Its documentation names the unfolding by Saltykov with Wicksell's probability, which it applies to larger classes only.
# With 10 classes 32 % of the sections of the largest spheres fall in the largest class, which is taken for all of them.
# Seen: sections of spheres that all have a diameter of 1 mm come back as 73 % spheres of the largest of 10 classes and 27 %
# smaller ones. Divided by its own share, each class fits: 96 % are of the largest class.
# Fix: divide the rest of each class by its own probability before it is taken off the smaller classes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps nanoshot-stamp==0.1.0a6 scipy==1.17.1 pandas==3.1.1 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 numpy==2.4.6 openpyxl==3.1.5 et-xmlfile==2.0.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from stamp import MeasurementData
from stamp.stereo import saltykov

# A plane cuts a sphere of diameter 1 at a distance that is uniform in 0..1/2: the quantiles of its sections.
sections = np.sqrt(1 - ((np.arange(20000) + 0.5) / 20000) ** 2)
result = saltykov(MeasurementData(values=sections, unit="mm", label="sections"), n_bins=10)
seen = result.freq3d * result.bin_width
middle, edges = result.bin_midpoints, result.bin_edges


def share(diameter, low, high):
    low, high = min(low, diameter), min(high, diameter)
    return (np.sqrt(diameter**2 - low**2) - np.sqrt(diameter**2 - high**2)) / diameter


counts = np.histogram(sections, edges)[0].astype(float)
own = np.array([share(middle[i], edges[i], edges[i + 1]) for i in range(10)])


def unfold(divisors):
    spheres = np.zeros(10)
    for i in reversed(range(10)):
        larger = sum(spheres[j] * share(middle[j], edges[i], edges[i + 1]) for j in range(i + 1, 10))
        spheres[i] = (counts[i] - larger) / divisors[i]
    spheres = np.clip(spheres, 0, None)
    return spheres / spheres.sum()


print("nanoshot-stamp", importlib.metadata.version("nanoshot-stamp"), "share of each class:", seen.round(3))
print("divided by its own probability:", unfold(own).round(3), "own probabilities:", own.round(3))
assert np.allclose(seen, unfold(np.ones(10)), atol=1e-9)
assert 0.72 < seen[-1] < 0.73
assert unfold(own)[-1] > 0.96
PYTHON
