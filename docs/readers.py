#!/usr/bin/env python3
"""Writes docs/measured/readers.md: what other programs see in the files of mesocrete. Every row is a run.

    python3 docs/readers.py [--only NAME] [--folder FOLDER]

Needs mesocrete in the Python that runs it. It installs pinned programs into environments of their own, makes the files,
and has every program read its file with the lines that the table prints. What is there already is not done again; a row
that could not be run is left out and named. It takes minutes and a network, so it is no part of the tests.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).resolve().parent

# Environments: programs that install beside each other.
PINS = {
    "meshes": "meshio==5.3.5 scikit-fem==12.0.2 felupe==11.3.0 trimesh==5.2.0 pyvista==0.49.1 vtk==9.7.2 gmsh==4.15.2 "
    "lsdyna-mesh-reader==0.2.1 mapdl-archive==0.4.2 ngsolve==6.2.2608 akantu==5.0.7.post1 h5py==3.16.0 dynars==1.1.0 "
    "mfem==4.10.0.1 numpy==2.4.6",
    "others": "SimpleITK==2.5.7 tifffile==2026.3.3 scikit-image==0.26.0 pymeshlab==2025.7.post1 manifold3d==3.5.4 "
    "numpy-stl==4.1.1 ansys-dyna-core==0.12.1 imageio==2.38.1 pillow==13.0.0 opencv-python-headless==5.0.0.93 pyvips==3.2.0 "
    "pyvips-binary==8.18.7",
    # Of Debian 12, by `apt install python3-dolfinx-real python3-h5py`; its Python also finds the gmsh of the first environment.
    "debian": "dolfinx==0.5.2",
}


@dataclass(frozen=True)
class Row:
    """A program and a file."""

    program: str
    package: str
    file: str
    code: str
    """Sets `seen`, a text of what arrives."""
    lost: str = "nothing"
    mend: str = ""
    """The line that mends it; the code runs it where `seen` ends in "once mended"."""
    env: str = "meshes"


ROWS = [
    Row("meshio", "meshio", "mesh.msh", "import meshio; m = meshio.read(F); seen = f'{len(m.points)} points, {sum(len(c.data) for c in m.cells if c.dim == 3)} cells, groups {sorted(m.field_data)}'"),
    Row("meshio", "meshio", "mesh.vtu", "import meshio; m = meshio.read(F); seen = f'{len(m.points)} points, {sum(len(c.data) for c in m.cells)} cells, arrays {sorted(m.cell_data)}'", "names of phases"),
    Row("meshio", "meshio", "mesh.xdmf", "import meshio; m = meshio.read(F); seen = f'{len(m.points)} points, {sum(len(c.data) for c in m.cells)} cells, arrays {sorted(m.cell_data)}'", "names of phases"),
    Row("meshio", "meshio", "mesh.inp", "import meshio; m = meshio.read(F); seen = f'{len(m.points)} points, {sum(len(c.data) for c in m.cells)} cells, sets {sorted(m.cell_sets)} and {len(m.point_sets)} of points'", "surfaces, materials, step"),
    Row("gmsh", "gmsh", "mesh.msh", "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); gmsh.open(F); g = gmsh.model; seen = f'{len(g.mesh.getNodes()[0])} points, {sum(map(len, g.mesh.getElements(3)[1]))} cells, groups {sorted(g.getPhysicalName(*x) for x in g.getPhysicalGroups())}'"),
    Row("PyVista", "pyvista", "mesh.vtu", "import pyvista; g = pyvista.read(F); seen = f'{g.n_points} points, {g.n_cells} cells, volume {g.volume:.1f}, arrays {sorted(g.cell_data.keys())}'", "names of phases"),
    Row("PyVista", "pyvista", "mesh.msh", "import pyvista; g = pyvista.read(F); seen = f'{g.n_points} points, {g.n_cells} cells with the triangles of the sides, arrays {sorted(g.cell_data.keys())}'", "names of groups"),
    Row("PyVista", "pyvista", "mesh.inp", "import pyvista; import meshio; a = pyvista.read(F); assert a.n_cells == 0; g = pyvista.from_meshio(meshio.read(F)); seen = f'{g.n_points} points, {g.n_cells} cells once mended'", "all: an empty grid and no message, since `.inp` is taken for AVS UCD", "pyvista.from_meshio(meshio.read(F))"),
    Row("VTK", "vtk", "mesh.xdmf", "from vtkmodules.vtkIOXdmf2 import vtkXdmfReader as R; r = R(); r.SetFileName(F); r.Update(); g = r.GetOutputDataObject(0); seen = f'{g.GetNumberOfPoints()} points, {g.GetNumberOfCells()} cells'", "names of phases"),
    Row("scikit-fem", "scikit-fem", "mesh.msh", "import skfem; m = skfem.Mesh.load(F); seen = f'{m.t.shape[1]} cells, subdomains {sorted(m.subdomains)}, boundaries {sorted(m.boundaries)}'"),
    Row("scikit-fem", "scikit-fem", "quadratic.msh", "import skfem; m = skfem.Mesh.load(F); assert not m.boundaries; seen = f'{m.t.shape[1]} cells of {type(m).__name__}, subdomains {sorted(m.subdomains)}'", "sides of second-order meshes", "m.with_boundaries({'ZMIN': lambda x: x[2] < 1e-9})"),
    Row("FElupe", "felupe", "mesh.inp", "import felupe, numpy as np; read = lambda **k: [set(np.unique(m.cells)) for m in felupe.mesh.read(F, **k).meshes]; a, b = read(), read(merge=True); assert not set.intersection(*a); seen = f'{len(a)} blocks; nodes shared by them: 0, once mended {len(set.intersection(*b))}'", "the phases share no node", "felupe.mesh.read(F, merge=True)"),
    Row("NGSolve", "ngsolve", "mesh.msh", "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); gmsh.open(F); gmsh.option.setNumber('Mesh.MshFileVersion', 2.2); gmsh.write('v2.msh')\nfrom netgen.read_gmsh import ReadGmsh\nfailed = False\ntry: ReadGmsh(F)\nexcept UnicodeDecodeError: failed = True\nassert failed\nimport ngsolve; m = ngsolve.Mesh(ReadGmsh('v2.msh')); seen = f'{m.ne} cells, materials {sorted(set(m.GetMaterials()))}, boundaries {sorted(set(m.GetBoundaries()))} once mended'", "all: UnicodeDecodeError on binary 4.1", "gmsh mesh.msh -save -format msh22 -o v2.msh"),
    Row("akantu", "akantu", "mesh.msh", "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); gmsh.open(F); gmsh.option.setNumber('Mesh.Binary', 0); gmsh.write('ascii.msh')\nimport akantu; m = akantu.Mesh(3); m.read('ascii.msh'); n = [g.getName() if hasattr(g, 'getName') else str(g) for g in m.iterateElementGroups()] if hasattr(m, 'iterateElementGroups') else []\nc = m.getConnectivity(akantu._tetrahedron_4)\nseen = f'{len(c)} cells, groups {sorted(n)} once mended'", "all: it reads ASCII only", "gmsh mesh.msh -save -format msh41 -setnumber Mesh.Binary 0 -o ascii.msh"),
    Row("MFEM", "mfem", "mesh.msh", "import mfem.ser as mfem; m = mfem.Mesh(F, 1, 0); assert all(m.attribute_sets.AttributeSetExists(n) for n in ('MORTAR', 'AGGREGATE')); seen = f'{m.GetNV()} points, {m.GetNE()} cells, attributes {m.attributes.ToList()}, boundaries {m.bdr_attributes.ToList()}, sets by name'"),
    Row("MFEM", "mfem", "mesh.vtu", "import mfem.ser as mfem, pyvista; m = mfem.Mesh(F, 1, 0); assert m.attributes.ToList() == [1]; g = pyvista.read(F); p = g['phase'] + 1; g.clear_data(); g.cell_data['attribute'] = p; g.save('mfem.vtu'); m = mfem.Mesh('mfem.vtu', 1, 0); seen = f'{m.GetNV()} points, {m.GetNE()} cells, attributes {m.attributes.ToList()} once mended'", "phases: every cell has attribute 1", "p = g['phase'] + 1; g.clear_data(); g.cell_data['attribute'] = p"),
    Row("DOLFINx", "dolfinx", "mesh.xdmf", "from mpi4py import MPI; from dolfinx.io import XDMFFile; import numpy as np; f = XDMFFile(MPI.COMM_WORLD, F, 'r'); m = f.read_mesh(name='Grid'); t = f.read_meshtags(m, name='Grid'); seen = f'{len(m.geometry.x)} points, {m.topology.index_map(3).size_local} cells, tags {np.unique(t.values).tolist()}'", "names of phases; the command's file of text is the grid `mesocrete`, with `XDMFFile(..., encoding=XDMFFile.Encoding.ASCII)`", env="debian"),
    Row("DOLFINx", "dolfinx", "mesh.msh", "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); gmsh.open(F)\nfrom mpi4py import MPI; from dolfinx.io import gmshio; import numpy as np; m, t, s = gmshio.model_to_mesh(gmsh.model, MPI.COMM_WORLD, 0); seen = f'{len(m.geometry.x)} points, {m.topology.index_map(3).size_local} cells, tags {np.unique(t.values).tolist()}, of sides {np.unique(s.values).tolist()} once mended'", "all: `read_from_msh` of 0.5.2 ends with a NameError", "gmsh.open(F); gmshio.model_to_mesh(gmsh.model, comm, 0)", env="debian"),
    Row("lsdyna-mesh-reader", "lsdyna-mesh-reader", "mesh.k", "import lsdyna_mesh_reader as r; g = r.Deck(F).to_grid(); seen = f'{g.n_points} points, {g.n_cells} cells'", "sets; names of parts; ten-node elements raise IndexError"),
    Row("dynars", "dynars", "mesh.k", "import dynars; d = dynars.parse_deck(F); t = d.table('ELEMENT_SOLID'); assert len(set(t['EID'])) == len(t['EID']); seen = f'{len(d.table(\"NODE\")[\"nid\"])} points, {len(t[\"EID\"])} elements, parts {sorted(set(t[\"PID\"].tolist()))}'", "sets; a ten-node element, of two lines, becomes two"),
    Row("mapdl-archive", "mapdl-archive", "cohesive.cdb", "import mapdl_archive as r; a = r.Archive(F); seen = f'{len(a.nodes)} points, {len(a.elem)} elements, {a.grid.n_cells} of them in the grid, components {sorted(a.element_components)}'", "the cohesive elements (INTER205) in `grid`; `elem` has them"),
    Row("trimesh", "trimesh", "model.stl", "import trimesh; m = trimesh.load(F); b = m.split() if hasattr(m, 'split') else m.dump(); seen = f'{len(b)} bodies, watertight {all(x.is_watertight for x in b)}, volume {sum(x.volume for x in b):.2f}'", "ids"),
    Row("trimesh", "trimesh", "model.obj", "import trimesh; m = trimesh.load(F, force='mesh'); seen = f'{m.body_count} bodies, volume {m.volume:.2f}'", "names of bodies"),
    Row("trimesh", "trimesh", "model.ply", "import trimesh; m = trimesh.load(F); seen = f'{m.body_count} bodies, volume {m.volume:.2f}'", "ids"),
    Row("trimesh", "trimesh", "model.glb", "import trimesh; s = trimesh.load(F); v = s.to_mesh().volume * 1e9; assert abs(s.volume / v - 1) < 1e-6; seen = f'{len(s.geometry)} named bodies, volume {v:.2f} mm3 once mended'", "`Scene.volume` leaves out the scale from mm to m", "scene.to_mesh().volume"),
    Row("PyVista", "pyvista", "model.vtp", "import pyvista; g = pyvista.read(F); seen = f'{g.n_cells} polygons, volume {g.volume:.2f}, arrays {sorted(g.cell_data.keys())}'"),
    Row("PyVista", "pyvista", "labels.vti", "import pyvista, numpy as np; g = pyvista.read(F); d = g.dimensions; seen = f'points {d}, so voxels {tuple(x - 1 for x in d)}; array[z, y, x] is {list(g.cell_data.keys())} reshaped to the reverse'", "", "grid['phase'].reshape(voxels[::-1])"),
    Row("PyVista", "pyvista", "labels.tif", "import pyvista, numpy as np; g = pyvista.read(F); a = g.active_scalars.reshape(g.dimensions[::-1]); stored = np.load('labels.npy'); assert np.array_equal(a[:, ::-1], stored) and not np.array_equal(a, stored); seen = f'points {g.dimensions}, values {np.unique(a).tolist()}, as stored once mended'", "each slice is upside down; labels stand on points", "array[:, ::-1]"),
    Row("NumPy", "numpy", "labels.npy", "import numpy as np; a = np.load(F); seen = f'{a.shape} {a.dtype}, values {np.unique(a).tolist()}'", "voxel size"),
    Row("tifffile", "tifffile", "labels.tif", "import tifffile; a = tifffile.imread(F); seen = f'{a.shape} {a.dtype}, values {sorted(set(a.ravel().tolist()))}'", "", env="others"),
    Row("scikit-image", "scikit-image", "labels.tif", "import skimage.io; a = skimage.io.imread(F); seen = f'{a.shape} {a.dtype}'", "voxel size", env="others"),
    Row("SimpleITK", "SimpleITK", "labels.tif", "import SimpleITK as s; i = s.ReadImage(F); seen = f'size {i.GetSize()}, spacing {tuple(round(x, 6) for x in i.GetSpacing())}'", "spacing across the slices, where it reads 1", "image.SetSpacing([h] * 3)", env="others"),
    Row("imageio", "imageio", "labels.tif", "import imageio.v3 as i; a = i.imread(F); seen = f'{a.shape} {a.dtype}'", "voxel size", env="others"),
    Row("Pillow", "pillow", "labels.tif", "from PIL import Image, ImageSequence; import numpy as np; i = Image.open(F); a = np.stack([np.array(p) for p in ImageSequence.Iterator(i)]); assert np.array_equal(a, np.load('labels.npy')); seen = f'{a.shape} {a.dtype}, as stored once mended'", "the pages behind the first, unless asked for; voxel size", "np.stack([np.array(p) for p in ImageSequence.Iterator(image)])", env="others"),
    Row("OpenCV", "opencv-python-headless", "labels.tif", "import cv2, numpy as np; assert cv2.imread(F).shape[2] == 3; a = np.stack(cv2.imreadmulti(F, flags=cv2.IMREAD_UNCHANGED)[1]); assert np.array_equal(a, np.load('labels.npy')); seen = f'{a.shape} {a.dtype}, as stored once mended'", "`imread` reads one page, as three colours; voxel size", "cv2.imreadmulti(F, flags=cv2.IMREAD_UNCHANGED)[1]", env="others"),
    Row("libvips", "pyvips-binary", "labels.tif", "import pyvips, numpy as np; i = pyvips.Image.new_from_file(F, n=-1); h = i.get('page-height'); a = i.numpy().reshape(-1, h, i.width); assert np.array_equal(a, np.load('labels.npy')); seen = f'{a.shape} {a.dtype}, {1 / i.xres:g} mm a pixel, as stored once mended'", "the pages behind the first; distance of the slices", "Image.new_from_file(F, n=-1), pages below each other", env="others"),
    Row("MeshLab", "pymeshlab", "model.ply", "import pymeshlab as p; s = p.MeshSet(); s.load_new_mesh(F); m = s.get_geometric_measures(); seen = f'{s.current_mesh().face_number()} triangles, volume {m[\"mesh_volume\"]:.2f}'", "ids", env="others"),
    Row("Manifold", "manifold3d", "model.stl", "import manifold3d as m, numpy as np; from stl import mesh; t = mesh.Mesh.from_file(F).vectors.reshape(-1, 3); p, i = np.unique(t, axis=0, return_inverse=True); b = m.Manifold(m.Mesh(p.astype(np.float32), i.reshape(-1, 3).astype(np.uint32))); seen = f'{b.status()}, {len(b.decompose())} bodies, volume {b.volume():.2f}'", "", env="others"),
    Row("numpy-stl", "numpy-stl", "model.stl", "from stl import mesh; m = mesh.Mesh.from_file(F); seen = f'{len(m.vectors)} triangles, volume {m.get_mass_properties()[0]:.2f}'", "ids", env="others"),
    Row("PyDyna", "ansys-dyna-core", "mesh.k", "from ansys.dyna.core import Deck; d = Deck(); d.import_file(F); n = [k for k in d.keywords if k.get_title().startswith('*NODE')]; e = [k for k in d.keywords if k.get_title().startswith('*ELEMENT_SOLID')]; assert not d.string_keywords; seen = f'{sum(len(k.nodes) for k in n)} points, {sum(len(k.elements) for k in e)} elements, no card left over'", "its plot takes ten-node tetrahedra for bricks", env="others"),
]

# What no package index has.
UNTRIED = """\
**Untried**: OpenRadioss, LS-DYNA, Abaqus, ANSYS and MOOSE read none of these files here, since they need a licence or a
build of their own. What the manuals say of their formats is by those programs' documents.
"""

# Makes the files in the folder that it runs in.
FILES = '''
import mesocrete as mc
spec = {"specimen": mc.Specimen.cube(24), "fraction": 0.3, "placement": {"min_gap_mm": 1.0}, "grading": mc.Grading.fuller(6, 10)}
packing = mc.pack(spec, seed=2)
for end in ("stl", "obj", "ply", "glb", "vtp", "json"):
    packing.write(f"model.{end}")
make = lambda **options: packing.mesh(method="lattice", element_size=3.0, accept_phase_error=True, **options)
mesh = make(itz="none")
for end in ("msh", "vtu", "xdmf", "cdb"):
    mesh.write(f"mesh.{end}")
for end in ("inp", "k"):
    mesh.write(f"mesh.{end}", geometry_only=True)
make(itz="none", order=2).write("quadratic.msh")
make(itz="cohesive").write("cohesive.cdb")
print(len(mesh.points), "points", len(mesh.cells), "cells")
'''


def main() -> None:
    """Run every row, and write the table of those that ran."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", help="run the rows of this program; writes no table")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "mesocrete-readers")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    files = make_files(folder / "files")
    rows = [row for row in ROWS if arguments.only in (None, row.program)]
    found = [(row, run(row, folder)) for row in rows]
    for row, (done, text) in found:
        print(f"{'ok    ' if done else 'FAILED'} {row.program} {row.file}: {text}", flush=True)
    if arguments.only is None:
        (DOCS / "measured" / "readers.md").write_text(page(files, [(row, text) for row, (done, text) in found if done]), encoding="utf-8")
    sys.exit(any(not done for _, (done, _) in found))


def make_files(folder: Path) -> str:
    """Pack, mesh and write every file; return the counts of the mesh."""
    said = folder / "said.txt"
    if not said.exists():
        folder.mkdir(parents=True, exist_ok=True)
        text = subprocess.run([sys.executable, "-c", FILES], cwd=folder, check=True, capture_output=True, text=True).stdout
        image = [sys.executable, "-m", "mesocrete", "image", "model.json", "--voxel-size-mm", "0.5", *(word for end in ("npy", "tif", "vti") for word in ("-o", f"labels.{end}"))]
        subprocess.run(image, cwd=folder, check=True, capture_output=True)
        said.write_text(text, encoding="utf-8")
    return said.read_text(encoding="utf-8").strip()


def run(row: Row, folder: Path) -> tuple[bool, str]:
    """Have a program read its file, or take the answer of an earlier run."""
    key = hashlib.sha256(repr((row, PINS[row.env])).encode()).hexdigest()[:12]
    kept = folder / "rows" / f"{key}.json"
    if kept.exists():
        return True, json.loads(kept.read_text(encoding="utf-8"))
    program = f"F = {row.file!r}\n{row.code}\nprint()\nprint('SEEN', seen)\n"
    done = subprocess.run([str(environment(row.env, folder)), "-c", program], cwd=folder / "files", capture_output=True, text=True, timeout=600, check=False)
    seen = [line[5:] for line in done.stdout.splitlines() if line.startswith("SEEN ")]
    if done.returncode or not seen:
        return False, (done.stderr.strip().splitlines() or ["no answer"])[-1]
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(seen[0]), encoding="utf-8")
    return True, seen[0]


def environment(name: str, folder: Path) -> Path:
    """Make an environment with its pinned programs, once; Debian's is the system's Python, or that of the variable DEBIAN_PYTHON."""
    if name == "debian":
        return Path(os.environ.get("DEBIAN_PYTHON", "/usr/bin/python3"))
    place = folder / name
    python, stamp = place / "bin" / "python", place / "pins.txt"
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != PINS[name]:
        subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
        subprocess.run([str(python), "-m", "pip", "--disable-pip-version-check", "install", "--quiet", *PINS[name].split()], check=True)
        stamp.write_text(PINS[name], encoding="utf-8")
    return python


def page(files: str, rows: list[tuple[Row, str]]) -> str:
    """Return the document."""
    versions = dict(pin.split("==") for pins in PINS.values() for pin in pins.split())
    head = textwrap.dedent(f"""\
        # What other programs see

        `python3 docs/readers.py` writes this table: it installs each program at the version shown, makes the files, and has
        the program read them. Every row is a run. The mesh is a fitted lattice of a 24 mm cube, {files.replace(" points", " points and")}.
        `F` is the file's name. The last column's line was run where the third says "once mended".

        | program | file | arrives | lost or changed | the line that mends it |
        |---|---|---|---|---|
        """)
    lines = [f"| {row.program} {versions[row.package]} | `{row.file}` | {text} | {row.lost or '-'} | {f'`{row.mend}`' if row.mend else ''} |" for row, text in rows]
    count = len({row.program for row, _ in rows})
    return head + "\n".join(lines) + f"\n\n{count} programs, {len(rows)} rows.\n\n{UNTRIED}"


if __name__ == "__main__":
    main()
