#!/usr/bin/env bash
# python-fcl 0.7.0.11: collide() of convex bodies that overlap deeply reports a depth that is not the smallest.
# The signed distance() of the same two bodies is right, and so is collide() of its own boxes.
# Seen: two cubes of 2 mm, shifted by 0.5 mm along each axis, have a depth of 2.598 mm along (1, 1, 1); 1.5 mm part them.
# Mends it: distance() with enable_signed_distance=True.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile python-fcl==0.7.0.11 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import itertools

import fcl
import numpy as np

corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
faces = np.array([n for q in quads for n in (4, *q)])
convex = lambda: fcl.Convex(corners, len(quads), faces)


def depth(shape, shift):
    bodies = [fcl.CollisionObject(shape(), fcl.Transform(np.array(t))) for t in ((0.0, 0.0, 0.0), shift)]
    result = fcl.CollisionResult()
    fcl.collide(*bodies, fcl.CollisionRequest(enable_contact=True, num_max_contacts=8), result)
    signed = fcl.distance(*bodies, fcl.DistanceRequest(enable_signed_distance=True), fcl.DistanceResult())
    return round(max(c.penetration_depth for c in result.contacts), 4), round(float(signed), 4)


seen = {}
for shift in ((0.5, 0.5, 0.5), (1.5, 1.2, 0.3)):
    hull, box = depth(convex, shift), depth(lambda: fcl.Box(2, 2, 2), shift)
    seen[shift] = hull[0], hull[1], box[0], 2 - max(shift)
print("python-fcl", importlib.metadata.version("python-fcl"), "depth of hulls, signed distance, depth of boxes, right:", seen)
assert seen[0.5, 0.5, 0.5] == (2.5981, -1.5, 1.5, 1.5)
assert seen[1.5, 1.2, 0.3] == (0.5, -0.5, 0.5, 0.5)
PYTHON
