#!/usr/bin/env bash
# iso2mesh 0.6.7: volclose() and fillholes3d() with a gap take voxels away where the body meets the border of the image.
# A closing adds voxels and takes none; fillholes3d() is documented to close gaps of the size and to fill holes.
# Seen: a full image of 6 x 6 x 6 voxels, which has neither gap nor hole, comes back with 64 of 216 for one layer and with 8
# for two. A ball away from the border keeps all its voxels, and fillholes3d() without a gap is right.
# A specimen that fills its image loses its outer layers in this way. The erosion of the second step takes what is beyond
# the border for empty; volshrink() of the same module takes it for full.
# Fix: pad the image by as many voxels as layers, by repeating its edge, and crop the result.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps iso2mesh==0.6.7 jdata==0.9.5 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from iso2mesh.volume import fillholes3d, volclose

full = np.ones((6, 6, 6))
ball = np.sum((np.indices((15, 15, 15)) - 7) ** 2, axis=0) <= 16


def padded(image, layers):
    inner = (slice(layers, -layers),) * 3
    return volclose(np.pad(image, layers, mode="edge"), layers)[inner]


seen = [int(f(full, layers).sum()) for layers in (1, 2) for f in (volclose, fillholes3d)]
print("iso2mesh", importlib.metadata.version("iso2mesh"), "of", full.size, "voxels are left:", seen)
print("padded:", [int(padded(full, n).sum()) for n in (1, 2)], "ball:", int(ball.sum()), int((volclose(ball) * ball).sum()))
assert seen == [64, 64, 8, 8]
assert fillholes3d(full).sum() == full.size and padded(full, 1).sum() == padded(full, 2).sum() == full.size
assert np.all(volclose(ball)[ball] == 1)
PYTHON
