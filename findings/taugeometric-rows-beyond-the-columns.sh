#!/usr/bin/env bash
# taugeometric 1.0.2: tortuosity_geometric_2d() looks for starts and ends in as many rows as the image has columns.
# Paths run from the left side to the right one, so that the rows below that are no part of the mean in a tall image.
# Seen: of two channels through 40 x 20 pixels, one straight in row 30 and one that winds above it, only the upper counts:
# 1.728, not the mean 1.364. With the straight channel alone the tortuosity is nan; a square image with it has 1.
# A wide image raises IndexError. Square images agree with the shortest paths of scikit-image.
# Fix: rows of solid below a wide image; for a tall one the shortest paths of MCP_Geometric in scikit-image, as here.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile taugeometric==1.0.2 scikit-image==0.26.0 matplotlib==3.11.2 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'PYTHON'
import contextlib
import importlib.metadata
import io

import numpy as np
from skimage.graph import MCP_Geometric
from taugeometric.tortuosity import tortuosity_geometric_2d


def seen(solid):
    with contextlib.redirect_stdout(io.StringIO()):
        return float(tortuosity_geometric_2d(solid.copy()))


def right(solid):
    lengths = []
    for row in np.flatnonzero(solid[:, 0] == 0):
        costs = MCP_Geometric(np.where(solid == 0, 1.0, -1.0), fully_connected=True).find_costs([(row, 0)])[0][:, -1]
        lengths.append(costs.min())
    return float(np.mean(lengths) / (solid.shape[1] - 1))


straight = np.ones((40, 20), int)
straight[30] = 0
both = straight.copy()
both[2, :8] = both[2:18, 7] = both[17, 7:] = 0
square = np.ones((20, 20), int)
square[10] = 0
winding = both[:20]
images = {"both": both, "straight": straight, "straight, square": square, "winding, square": winding}
answers = {name: (seen(image), right(image)) for name, image in images.items()}
print("taugeometric", importlib.metadata.version("taugeometric"))
for name, (own, shortest) in answers.items():
    print(f"  {name} {images[name].shape}: {own:.4f}, shortest paths {shortest:.4f}")
assert np.isclose(*answers["winding, square"]) and answers["straight, square"] == (1, 1)
assert np.isclose(answers["both"][0], answers["winding, square"][0])
assert np.isclose(answers["both"][1], (1 + answers["winding, square"][1]) / 2)
assert np.isnan(answers["straight"][0]) and answers["straight"][1] == 1
try:
    seen(square[:12])
    raise SystemExit("a wide image is read")
except IndexError as error:
    print("  a wide image:", error)
PYTHON
