#!/usr/bin/env bash
# fabrictensor 1.0.2: compute_mil_all() shortens mean intercept lengths along diagonals, by 1 / sqrt(3) for (1, 1, 1).
# That is its default, the "dense vectors path-length correction". Steps along a ray already have the length of one voxel, so
# that the weight 1 / (|x| + |y| + |z|) of the direction has nothing to correct.
# Seen: a ball of radius 15 voxels has 19.9 along the axes and 9.4 along (1, 1, 1); the mean chord of a ball is 4 / 3 of its
# radius, 20, in each direction. Without the weight it is 16.3 there; the rest comes from voxels at the rim.
# Every quotient of the two is the weight of its direction.
# Fix: dense_vectors=False.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps fabrictensor==1.0.2 pillow==13.0.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import fabrictensor
import numpy as np

radius, size = 15, 41
ball = (np.sum((np.indices((size,) * 3) - size // 2) ** 2, axis=0) <= radius**2).astype(np.uint8)
directions = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1]], float)
directions /= np.linalg.norm(directions, axis=1)[:, None]
everything = np.ones(ball.shape, bool)
default = fabrictensor.compute_mil_all(ball, everything, directions, n_rays=3000)
plain = fabrictensor.compute_mil_all(ball, everything, directions, n_rays=3000, dense_vectors=False)
print("fabrictensor", importlib.metadata.version("fabrictensor"), default.round(2), "without the weight:", plain.round(2))
assert np.allclose(default[:3], 4 / 3 * radius, rtol=0.02)
assert default[4] < 10 < 16 < plain[4]
assert np.allclose(default / plain, 1 / np.abs(directions).sum(axis=1))
PYTHON
