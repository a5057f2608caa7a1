#!/usr/bin/env bash
# trimesh 5.2.0: Scene.volume leaves out the scale of a scene's nodes; the volume of the joined mesh has it.
# Seen: a unit cube in a node of scale 0.001 has a scene volume of 1 and a mesh volume of 1e-9; extents are right.
# Mends it: scene.to_mesh().volume.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile trimesh==5.2.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import trimesh

scene = trimesh.Scene()
scene.add_geometry(trimesh.creation.box((1, 1, 1)), transform=np.diag([1e-3, 1e-3, 1e-3, 1.0]))
joined = scene.to_mesh().volume if hasattr(scene, "to_mesh") else scene.dump(concatenate=True).volume
print("trimesh", trimesh.__version__, "scene", scene.volume, "joined", joined, "extents", scene.extents)
assert abs(scene.volume - 1) < 1e-9 and abs(joined / 1e-9 - 1) < 1e-6 and np.allclose(scene.extents, 1e-3)
PYTHON
