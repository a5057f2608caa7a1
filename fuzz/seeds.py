#!/usr/bin/env python3
"""Fills fuzz/corpus/ with good files, so that the fuzzer starts behind the first checks."""

import json
import struct
import subprocess
from pathlib import Path

FUZZ = Path(__file__).resolve().parent
CORPUS = FUZZ / "corpus"
CORNERS = [(0, 0, 0), (30, 0, 0), (0, 30, 0), (0, 0, 30)]
COMMAND_LINES = [
    "pack --fraction 0.4 --seed 1 --strategy rearrange --time-limit 10 -o a.json -o b.vtu",
    "pack --method lattice --element-size-mm 2 --itz cohesive --analysis compression -o a.inp",
    "mesh m.json --method conforming --element-size-mm 2 --slabs 3 --order 2 -o a.msh",
    "solve m.json --test tension --law cdp --strain 0.001 --itz solid --frames 3 -o out",
    "image m.json --what share --of itz --section z=75 --voxel-size-mm 0.5 -o a.png",
    "image m.json --box 0,0,0,50,50,50 -o a.npy --threads 2",
    "convert m.json -o a.step --mortar --images cut",
    "study s.toml --jobs 2 -o out --retry-failed",
    "check m.json --json",
    "report m.json -o a.html",
    "completions bash",
]
STUDIES = [
    "recipe = 'rve-60'\noutputs = ['a.csv', 'b.vtu']\n[over]\nseed = { from = 1, to = 9, step = 2 }\n",
    "[spec]\nfraction = 0.2\n[over]\nspecimen.side_mm = [30, 40]\nmesh.itz = ['none', 'cohesive']\n[mesh]\noutput = ['m.inp', 'm.pvtu']\n",
    "[solve]\nfriction = 0.1\nmethod = 'voxel'\nframes = 2\n[over]\nsolve.test = ['compression', 'tension']\n",
    "[over]\nspecimen = [{ kind = 'sphere', diameter_mm = 30 }, { side_mm = 40 }]\n\"grading.d_max_mm\" = [16, 20]\n",
    "outputs = ['frame_0001.vtu']\n[mesh]\noutput = 'm.inp'\nanalysis = 'compression'\n[solve]\n",
]
TESTS = [
    "kind = 'compression'\nfriction = 0.1\nlaw = 'cdp'\n[[gauges]]\nkind = 'lvdt'\nname = 'lvdt'\naxis = 'z'\nfrom_mm = 4\nto_mm = 16\n",
    "kind = 'triaxial'\npressure_mpa = 5\nstrain = 0.001\n[[gauges]]\nkind = 'lateral-strain'\nname = 'lateral_strain'\n",
    "kind = 'cyclic'\nturns = [{ at = 0.001 }, { at = 1, of = 'stress' }, { at = 0.002 }]\n",
    "kind = 'expansion'\n[expansion]\naggregate = 1e-4\nmortar = 0.0\n",
    "strain = 0.001\n[[supports]]\nname = 'a'\non = 'z-min'\nmoves = 0.5\nstrip = { axis = 'x', at_mm = 0, width_mm = 5 }\n[[supports]]\nname = 'b'\non = 'z-max'\nrule = 'glued'\n",
]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def keep(target: str, name: str, content: bytes) -> None:
    """Put one seed into a target's corpus."""
    folder = CORPUS / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)


def text_stl() -> bytes:
    """Write a tetrahedron as text."""
    facets = ("".join("vertex {} {} {}\n".format(*CORNERS[i]) for i in face) for face in FACES)
    return ("solid a\n" + "".join(f"facet normal 0 0 0\nouter loop\n{f}endloop\nendfacet\n" for f in facets)).encode()


def binary_stl() -> bytes:
    """Write it as records."""
    records = (struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in CORNERS[i]), 0) for face in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + b"".join(records)


def off() -> bytes:
    """Write it as OFF."""
    rows = [" ".join(map(str, corner)) for corner in CORNERS] + [f"3 {a} {b} {c}" for a, b, c in FACES]
    return "\n".join(["OFF", "4 4 6", *rows, ""]).encode()


def obj() -> bytes:
    """Write it as OBJ."""
    rows = ["v {} {} {}".format(*corner) for corner in CORNERS] + [f"f {a + 1} {b + 1}/1 {c - 4}" for a, b, c in FACES]
    return "\n".join(["o a", *rows, ""]).encode()


def ply(binary: bool) -> bytes:
    """Write it as PLY."""
    form = "binary_big_endian" if binary else "ascii"
    head = f"ply\nformat {form} 1.0\nelement vertex 4\n" + "".join(f"property float {axis}\n" for axis in "xyz")
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    if not binary:
        return head.encode() + off().split(b"\n", 2)[2]
    corners = b"".join(struct.pack(">3f", *corner) for corner in CORNERS)
    return head.encode() + corners + b"".join(struct.pack(">B3i", 3, *face) for face in FACES)


def saved_model() -> bytes:
    """Pack a small specimen with the command that was built last."""
    spec = b"fraction = 0.2\nspecimen = { kind = 'cube', side_mm = 25 }\ngrading = { d_max_mm = 10 }\n"
    command = ["cargo", "run", "--quiet", "--bin", "mesocrete", "--", "pack", "-", "-o", "-", "--quiet"]
    model = subprocess.run(command, input=spec, capture_output=True, check=True, cwd=FUZZ.parent).stdout
    return json.dumps(json.loads(model)).encode()


def main() -> None:
    """Fill all corpora."""
    for recipe in sorted((FUZZ.parent / "crates/meso-pack/src/recipes").glob("*.toml")):
        keep("spec", recipe.name, recipe.read_bytes())
    keep("saved-model", "small.json", saved_model())
    keep("stl", "text.stl", text_stl())
    for name, content in {"a.off": off(), "a.obj": obj(), "a.ply": ply(binary=False), "b.ply": ply(binary=True)}.items():
        keep("stl", name, content)
    keep("stl", "binary.stl", binary_stl())
    keep("sieve-table", "comma.csv", b"sieve_mm,passing\n4,0.1\n8,0.45\n16,1\n")
    keep("sieve-table", "semicolon.csv", b"sieve_mm;passing_percent\n4;10\n8;45,5\n16;100\n")
    header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2), }\n"
    keep("volume", "a.npy", b"\x93NUMPY\x01\0" + struct.pack("<H", len(header)) + header + bytes([0, 1, 2, 1, 0, 0, 1, 2]))
    head = '<VTKFile type="ImageData"><ImageData WholeExtent="0 2 0 2 0 1" Spacing="1 1 1"><CellData>'
    keep("volume", "a.vti", f'{head}<DataArray type="UInt8" Name="a" format="ascii">0 1 2 1</DataArray></CellData></ImageData></VTKFile>'.encode())
    keep("materials", "mortar.toml", b"[mortar]\nyoungs_modulus_mpa = 25000\npoisson_ratio = 0.2\n")
    for number, line in enumerate(COMMAND_LINES):
        keep("command-line", str(number), line.replace(" ", "\n").encode())
    for number, text in enumerate(STUDIES):
        keep("study", str(number), text.encode())
    for number, text in enumerate(TESTS):
        keep("test-file", str(number), text.encode())
    for target in ["checkpoint", "hull", "offset", "collision", "tiny-mesh"]:
        for seed in range(8):
            keep(target, str(seed), bytes((i * 37 + seed * 11) % 256 for i in range(200)))


if __name__ == "__main__":
    main()
