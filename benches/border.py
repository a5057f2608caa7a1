"""Random files of others at the border, judged without mesocrete: nothing wrong passes in silence, and nothing aborts.

Each kind of case draws its files from the case's number; a row of `benches/results/border.csv` counts the outcomes of a run.

    volumes    label volumes (air, cores, phases, flat, grey, touching, nanometres): grains by an own flood fill, volumes by the
               divergence theorem, `check`
    cores      drilled cores for `import --outside`: diameter, grains within, volumes, `check`
    surfaces   specimens and library grains of STL, PLY, OBJ and OFF, sound and damaged: volumes by the divergence theorem
    lies       one false number in a saved model of a label volume: `check` finds it, unless the volume alone shows it
    writers    TIFF, .vti and .npy files of thirteen other programs, judged by the array and the voxel that the writer knows
    contradictions    TEST.toml with and without contradictions, judged by rules from docs/tests.md
    packed     compressed or shared data that opens to far more than 1 GB, under a limit of 1 GB: an error, no abort

    python benches/border.py volumes --command target/release/mesocrete --cases 500 [--from 0]
    python benches/border.py --quick    two cases of each kind but the last, kept nowhere
"""

import argparse
import base64
import collections
import csv
import gzip
import json
import resource
import struct
import subprocess
import tempfile
import zlib
from pathlib import Path

import numpy as np

from judges.contradictions import contradicted
from judges.writers import writers
from origin import RESULTS, origin

HEAD = ["kind", "first", "cases", "wrong", "outcomes", "machine", "date", "commit"]
GB = 10**9


def run(command, *arguments, limit=None):
    def limited():
        if limit:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    arguments = [str(part) for part in (command, *arguments)]
    return subprocess.run(arguments, capture_output=True, text=True, errors="replace", preexec_fn=limited, check=False)


def volume(vertices, faces):
    """Volume by the divergence theorem."""
    v = np.asarray(vertices, float)
    v = v - v.mean(axis=0)
    fans = [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]
    a, b, c = (v[[fan[k] for fan in fans]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def parts(labels, mortar):
    """Connected parts of equal labels, by a flood fill: label and number of voxels."""
    seen = np.isin(labels, mortar)
    found = []
    for start in zip(*np.nonzero(~seen)):
        if seen[start]:
            continue
        stack, count = [start], 0
        seen[start] = True
        while stack:
            at = stack.pop()
            count += 1
            for axis in range(3):
                for step in (-1, 1):
                    to = list(at)
                    to[axis] += step
                    to = tuple(to)
                    inside = 0 <= to[axis] < labels.shape[axis]
                    if inside and not seen[to] and labels[to] == labels[at]:
                        seen[to] = True
                        stack.append(to)
        found.append((int(labels[start]), count))
    return found


def ellipsoids(rng, grid, count, low, high):
    """Indicators of ellipsoids and boxes at random places."""
    size = grid[0].shape
    for _ in range(count):
        centre, half = [rng.uniform(0.1, 0.9) * n for n in size], rng.uniform(low, high, 3)
        scaled = [abs(x - c) / r for x, c, r in zip(grid, centre, half)]
        yield sum(x**2 for x in scaled) < 1 if rng.random() < 0.5 else np.max(scaled, axis=0) < 1


def judged(command, said, model, labels, mortar, cell_mm3, specimen_mm3):
    """Compare a model with its labels: an iterable of faults."""
    saved = json.loads(model.read_text())
    of = saved["report"]["labels"]
    bodies = [volume(grain["vertices"], grain["faces"]) for grain in saved["aggregates"]]
    whole = of["core"]["voxels"] if "core" in of else labels.size
    if abs(sum(bodies) / specimen_mm3(saved) - saved["report"]["fraction"]) > 1e-9:
        yield "fraction"
    grains = sum(count for _, count in parts(labels, mortar))
    told = (of["fraction"] + of["dropped_fraction"] - of["filled_fraction"]) * whole
    if of["filled_fraction"] == 0 and "core" not in of and abs(told - grains) > 1e-6 * labels.size:
        yield f"{told} voxels of {grains} accounted for"
    if "core" in of and abs(told / grains - 1) > 0.05 + of["core"]["off_fraction"]:
        yield f"{told} voxels of {grains} accounted for"
    had = of["fraction"] + of["dropped_fraction"]
    lost = max(0.0, had - sum(bodies) / (whole * cell_mm3))
    if abs(lost - of["lost_fraction"]) > 1e-9:
        yield f"lost {lost}, told {of['lost_fraction']}"
    warned = "less volume than the labels" in said
    if abs(lost / had - 0.02) > 1e-9 and warned != (lost / had > 0.02):
        yield f"lost {lost / had} of the grains, warned: {warned}"
    if sum(bodies) > 1.01 * (of["fraction"] * whole * cell_mm3):
        yield f"bodies of {sum(bodies)} for {of['fraction'] * whole * cell_mm3}"
    check = run(command, "check", model)
    if check.returncode:
        yield f"check: {(check.stdout + check.stderr)[-300:]}"


def volumes(command, number, folder):
    rng = np.random.default_rng([1, number])
    kind = rng.choice(["grains", "air", "core", "phase", "flat", "grey", "touching", "nano"])
    n = rng.integers(14, 30, 3)
    if kind == "flat":
        n[rng.integers(3)] = rng.integers(4, 8)
    h = float(rng.choice([1e-4, 3e-4] if kind == "nano" else [0.05, 0.5, 1.0, 2.0]))
    grid = np.meshgrid(*[np.arange(k) + 0.5 for k in n], indexing="ij")
    labels, has_air = np.zeros(n, np.int16), kind in ("air", "core")
    if kind == "air":
        margin = rng.integers(1, 4)
        labels[tuple(slice(margin, k - margin) for k in n)] = 1
    if kind == "core":
        labels[np.hypot(grid[1] - n[1] / 2, grid[2] - n[2] / 2) < min(n[1], n[2]) / 2 - 0.5] = 1
    low = 3.0 if kind == "touching" else 1.2
    for k, inside in enumerate(ellipsoids(rng, grid, int(rng.integers(2, 9)), low, 5.0)):
        labels[inside & (labels >= int(has_air))] = 1 if kind == "phase" else 1 + k + int(has_air)
    if kind == "grey":
        labels = rng.integers(0, 255, n).astype(np.uint8)
    file, model = folder / "v.npy", folder / "m.json"
    np.save(file, labels)
    arguments = ["import", file, "--voxel-size-mm", h, "-qfo", model]
    found, mortar, faults = run(command, *arguments), [0], []
    state = "made" if found.returncode == 0 else "refused"
    if has_air and (labels == 1).any():
        is_grain = found.returncode == 0 and 1 in json.loads(model.read_text())["report"]["labels"]["labels"]
        if is_grain and "less volume than the labels" not in found.stderr:
            faults.append("the mortar became a grain without a warning")
        state = "warned" if is_grain else state
        asked = [word for word in found.stderr.split() if word.startswith("--mortar=")]
        if asked:
            mortar = [int(label) for label in asked[0].removeprefix("--mortar=").split(",")]
            faults += ["wrong advice"] * (sorted(mortar) != [0, 1])
            found = run(command, *arguments, asked[0])
            state = "asked, made" if found.returncode == 0 else "asked, refused"
    if found.returncode not in (0, 1):
        faults.append(f"exit code {found.returncode}: {found.stderr[-200:]}")
    if kind == "grey" and found.returncode == 0:
        faults.append("a grey image was taken")
    if found.returncode == 0:
        box = lambda _: labels.size * h**3  # noqa: E731
        faults += judged(command, found.stderr, model, labels, mortar, h**3, box)
    return f"{kind} {state}", faults


def cores(command, number, folder):
    rng = np.random.default_rng([2, number])
    n, nz, h = int(rng.integers(24, 44)), int(rng.integers(16, 36)), [float(rng.choice([0.1, 0.5, 1.0]))] * 3
    if rng.random() < 0.3:
        h[2] *= 2
    grid = np.meshgrid(np.arange(nz) + 0.5, np.arange(n) + 0.5, np.arange(n) + 0.5, indexing="ij")
    z, y, x = grid
    middle, radius, lean = n / 2 + rng.uniform(-1, 1, 2), rng.uniform(0.30, 0.46) * n, rng.choice([0, 0, 0.03])
    core = np.hypot(x - middle[0] - lean * (z - nz / 2), y - middle[1]) < radius
    if rng.random() < 0.4:
        core[:2] = False
    labels = core.astype(np.uint8)
    for k, inside in enumerate(ellipsoids(rng, grid, int(rng.integers(3, 12)), 2.5, 7.0)):
        labels[inside & core] = 2 + k
    for inside in ellipsoids(rng, grid, int(rng.integers(0, 4)), 1.0, 2.5):
        labels[inside & core] = 0
    if rng.random() < 0.3:
        labels[nz // 2, 1, 1] = 9
    file, model = folder / "v.npy", folder / "m.json"
    np.save(file, labels)
    flags = ["--gap-mm", 2 * h[0]] if rng.random() < 0.4 else []
    flags += ["--itz-thickness-mm", 0.3 * h[0]] if rng.random() < 0.4 else []
    size = ",".join(map(str, h))
    found = run(command, "import", file, "--voxel-size-mm", size, "-fo", model, "--outside", 0, "--mortar", 1, *flags)
    if found.returncode:
        return "refused", [] if found.returncode == 1 else [f"exit code {found.returncode}: {found.stderr[-200:]}"]
    saved, faults = json.loads(model.read_text()), []
    diameter = saved["specimen"]["diameter_mm"]
    if abs(diameter / (2 * radius * h[0]) - 1) > 0.03:
        faults.append(f"diameter {diameter} for {2 * radius * h[0]}")
    reach = max(np.hypot(*(np.array(grain["vertices"])[:, :2] - diameter / 2).T).max() for grain in saved["aggregates"])
    if reach > diameter / 2:
        faults.append(f"a grain reaches {reach - diameter / 2} mm beyond the core")
    labels[nz // 2, 1, 1] = 0
    cylinder = lambda saved: np.pi / 4 * diameter**2 * saved["specimen"]["height_mm"]  # noqa: E731
    faults += judged(command, found.stderr, model, labels, [0, 1], np.prod(h), cylinder)
    return "made with a gap" if "--gap-mm" in flags else "made", faults


def sphere(rng, rings):
    """Vertices and triangles of a rough ball, turned outwards."""
    count = int(rng.integers(6, 12))
    vertices = [[0, 0, 1.0]]
    for ring in range(1, rings):
        theta = np.pi * ring / rings
        vertices += [[np.sin(theta) * np.cos(p), np.sin(theta) * np.sin(p), np.cos(theta)] for p in 2 * np.pi * np.arange(count) / count]
    vertices.append([0, 0, -1.0])
    at = lambda ring, k: 1 + (ring - 1) * count + k % count  # noqa: E731
    faces = [[0, at(1, k), at(1, k + 1)] for k in range(count)]
    for ring in range(1, rings - 1):
        for k in range(count):
            faces += [[at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)], [at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]]
    last = len(vertices) - 1
    faces += [[last, at(rings - 1, k + 1), at(rings - 1, k)] for k in range(count)]
    return np.array(vertices) * rng.uniform(0.9, 1.1, (len(vertices), 1)) * rng.uniform(0.7, 1.3, 3), faces


def text_of(ending, vertices, faces, rng):
    """A file of another program: endings, orders and blanks as they are found."""
    v = [" ".join(f"{x:.9g}" for x in vertex) for vertex in vertices]
    if ending == "stl":
        tri = [[vertices[i] for i in face] for face in faces]
        if rng.random() < 0.5:
            body = b"".join(struct.pack("<12fH", *([0.0] * 3), *np.ravel(t), 0) for t in tri)
            return b"x" * 80 + struct.pack("<I", len(tri)) + body
        lines = ["solid x"]
        for t in tri:
            lines += ["facet normal 0 0 0", "outer loop", *["vertex " + " ".join(f"{x:.9g}" for x in p) for p in t], "endloop", "endfacet"]
        return "\n".join([*lines, "endsolid x", ""]).encode()
    if ending == "obj":
        negative = rng.random() < 0.4
        index = [[i - len(v) if negative else i + 1 for i in face] for face in faces]
        blank = "\r\n" if rng.random() < 0.3 else "\n"
        return blank.join(["# x", *["v " + x for x in v], *["f " + " ".join(map(str, f)) for f in index], ""]).encode()
    if ending == "off":
        head = rng.choice([f"OFF\n{len(v)} {len(faces)} 0", f"OFF{len(v)} {len(faces)} 0", f"OFF {len(v)} {len(faces)} 0"])
        glue = " " if rng.random() < 0.3 else "\n"
        return (head + "\n" + glue.join(v) + "\n" + "\n".join(f"{len(f)} " + " ".join(map(str, f)) for f in faces) + "\n").encode()
    head = f"element vertex {len(v)}\nproperty double x\nproperty double y\nproperty double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    if rng.random() < 0.5:
        order = rng.choice(["little", "big"])
        mark = "<" if order == "little" else ">"
        body = b"".join(struct.pack(mark + "3d", *vertex) for vertex in vertices)
        body += b"".join(struct.pack(mark + f"B{len(f)}i", len(f), *f) for f in faces)
        return f"ply\nformat binary_{order}_endian 1.0\n{head}".encode() + body
    return (f"ply\nformat ascii 1.0\n{head}" + "\n".join(v) + "\n" + "\n".join(f"{len(f)} " + " ".join(map(str, f)) for f in faces) + "\n").encode()


def surfaces(command, number, folder):
    rng = np.random.default_rng([3, number])
    vertices, faces = sphere(rng, int(rng.integers(4, 9)))
    vertices = vertices * 20.0 + rng.uniform(-100, 100, 3)
    ending = str(rng.choice(["stl", "ply", "obj", "off"]))
    damage = str(rng.choice(["none", "none", "none", "inward", "hole", "doubled face", "turned face", "nan", "speck", "two", "nested", "cut", "index"]))
    right, refused = volume(vertices, faces), False
    if damage == "inward":
        faces = [face[::-1] for face in faces]
    elif damage == "hole":
        faces, refused = faces[:-1], True
    elif damage == "doubled face":
        faces, refused = [*faces, faces[0]], None
    elif damage == "turned face":
        faces, refused = [faces[0][::-1], *faces[1:]], None
    elif damage == "nan":
        vertices, refused = vertices.copy(), True
        vertices[3, 1] = np.nan
    elif damage == "index" and ending != "stl":
        faces, refused = [*faces[:-1], [0, 1, len(vertices)]], True
    elif damage in ("speck", "two", "nested"):
        other, more = sphere(rng, 4)
        scale, shift = {"speck": (0.05, 60), "two": (15, 60), "nested": (5, 0)}[damage]
        other = other * scale + vertices.mean(axis=0) + [shift, 0, 0]
        faces = [*faces, *[[i + len(vertices) for i in face] for face in more]]
        vertices, refused = np.vstack([vertices, other]), damage == "nested"
        right += volume(other, more) if damage == "two" else 0.0
    data = text_of(ending, vertices, faces, rng)
    if damage == "cut":
        data, refused = data[: int(len(data) * rng.uniform(0.2, 0.95))], True
    (folder / f"s.{ending}").write_bytes(data)
    spec = f'seed = 1\nfraction = 0.02\nspecimen = {{ kind = "mesh", file = "s.{ending}" }}\ngrading = {{ d_min_mm = 4, d_max_mm = 6 }}\nitz = {{ thickness_mm = [0, 0] }}\n'
    (folder / "spec.toml").write_text(spec)
    found = run(command, "pack", folder / "spec.toml", "-qfo", folder / "m.json", "--time-limit", 20, "--summary-json", folder / "s.json")
    if found.returncode not in (0, 1, 2):
        return damage, [f"{ending}: exit code {found.returncode}: {found.stderr[-200:]}"]
    if found.returncode:
        wrong = refused is False
        return f"{damage} refused", [f"{ending}: refused: {found.stderr[-300:]}"] if wrong else []
    told = json.loads((folder / "s.json").read_text())["specimen"]["volume_mm3"]
    if refused:
        return f"{damage} taken", [f"{ending}: taken with {told} mm3 for {right}"]
    near = 1e-5 if ending == "stl" else 1e-6
    wrong = abs(told / right - 1) > near
    return f"{damage} taken", [f"{ending}: {told} mm3 for {right}"] if wrong else []


def zeros(count):
    """So many zeros, packed by zlib."""
    packing, block = zlib.compressobj(9), bytes(1 << 24)
    data = b"".join(packing.compress(block[: min(len(block), count - at)]) for at in range(0, count, len(block)))
    return data + packing.flush()


def packed(command, number, folder):
    rng = np.random.default_rng([4, number])
    kind = ["vti zlib", "vti base64", "tif pages", "tif deflate", "json.gz", "npy head", "vti head", "tif head", "csv", "stl"][number % 10]
    size = int(rng.integers(15, 26)) * GB // 10
    act, name = "import", "v"
    if kind.startswith("vti"):
        n = int(round((size if kind == "vti head" else rng.integers(16, 40) ** 3) ** (1 / 3)))
        block = zeros(64 if kind == "vti head" else size)
        head = struct.pack("<4I", 1, min(size, 2**32 - 1), 0, len(block))
        data = (base64.b64encode(head) + base64.b64encode(block)).decode()
        e = f"0 {n} 0 {n} 0 {n}"
        text = f'<?xml version="1.0"?><VTKFile type="ImageData" version="0.1" byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><ImageData WholeExtent="{e}" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="{e}"><CellData Scalars="l"><DataArray type="UInt8" Name="l" format="binary">{data}</DataArray></CellData></Piece></ImageData></VTKFile>'
        (folder / "v.vti").write_text(text)
        name = "v.vti"
    elif kind.startswith("tif"):
        side = int(rng.integers(8000, 16000))
        pages = 1 if kind == "tif head" else int(size // side**2) + 1
        strip = zeros(side * side) if kind != "tif head" else b"\x78\x9c"
        if kind == "tif head":
            side = 2**31
        out, offset = bytearray(b"II*\x00" + struct.pack("<I", 8 + len(strip)) + strip), 8 + len(strip)
        for page in range(pages):
            entries = [(256, 4, side), (257, 4, side), (258, 3, 8), (259, 3, 8), (262, 3, 1), (273, 4, 8), (277, 3, 1), (278, 4, side), (279, 4, len(strip))]
            offset += 2 + 12 * len(entries) + 4
            out += struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", tag, of, 1, value) for tag, of, value in entries)
            out += struct.pack("<I", offset if page + 1 < pages else 0)
        (folder / "v.tif").write_bytes(out)
        name = "v.tif"
    elif kind == "npy head":
        n = int(round((size * 4) ** (1 / 3)))
        header = f"{{'descr': '|u1', 'fortran_order': {bool(rng.integers(2))}, 'shape': ({n}, {n}, {n}), }}"
        (folder / "v.npy").write_bytes(b"\x93NUMPY\x01\x00\x76\x00" + f"{header:117}\n".encode() + bytes(1000))
        name = "v.npy"
    elif kind == "json.gz":
        begin = rng.choice([b'{"mesocrete":"', b'{"aggregates":[', b"{", b"["])
        with gzip.open(folder / "v.json.gz", "wb", compresslevel=9) as file:
            file.write(begin)
            for _ in range(size // (1 << 24)):
                file.write(bytes([rng.choice([32, 48, 91, 44])]) * (1 << 24))
        name, act = "v.json.gz", "check"
    elif kind == "csv":
        rows = "\n".join(["sieve_mm,passing"] + ["1" * int(rng.integers(10, 10**6))] * 5)
        (folder / "t.csv").write_text(rows)
        (folder / "v.toml").write_text('grading = { curve = { kind = "sieves", file = "t.csv" } }\n')
        name, act = "v.toml", "pack"
    else:
        (folder / "s.stl").write_bytes(b"x" * 80 + struct.pack("<I", 2**32 - 1) + bytes(500))
        (folder / "v.toml").write_text('specimen = { kind = "mesh", file = "s.stl" }\n')
        name, act = "v.toml", "pack"
    command_line = [act, folder / name] + ([] if act == "check" else ["-qfo", folder / "m.json"])
    found = run(command, *command_line, limit=GB)
    # 128 and more, or less than 0: killed by a signal.
    wrong = found.returncode not in (1, 2) or "panicked" in found.stderr or "backtrace" in found.stderr
    return f"{kind} {found.returncode}", [f"{kind}: exit code {found.returncode}: {found.stderr[-300:]}"] if wrong else []


# What the label volume alone shows: `check` says that it does not.
OF_THE_VOLUME = {"dropped", "separated_pairs", "farthest_mm", "labels"}


def numbers_of(tree, path=()):
    """The places of numbers in a tree, of lists the first three."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree[:3]):
        if isinstance(value, (dict, list)):
            yield from numbers_of(value, (*path, key))
        elif isinstance(value, (bool, int, float)):
            yield (*path, key)


def is_convex(body):
    points = np.array(body["vertices"], float)
    corners = points[np.array([face[:3] for face in body["faces"]])]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.einsum("fk,fvk->fv", normals, points[None] - corners[:, :1])
    return heights.max() <= 1e-12 * np.ptp(points) ** 3


def lies(command, number, folder):
    rng = np.random.default_rng([5, number])
    n = int(rng.integers(22, 34))
    labels, at = np.zeros((n,) * 3, np.int32), np.indices((n,) * 3)
    centres = [(x, y, z) for x in (n / 4, 3 * n / 4) for y in (n / 4, 3 * n / 4) for z in (n / 4, 3 * n / 4)]
    for label, centre in enumerate(centres[: int(rng.integers(3, 9))], 1):
        radii = rng.uniform(n / 8, n / 4.6, 3)
        labels[(((at - np.array(centre)[:, None, None, None]) / radii[:, None, None, None]) ** 2).sum(0) < 1] = label
    np.save(folder / "v.npy", labels)
    made = run(command, "import", folder / "v.npy", "--itz-thickness-mm", rng.choice(["0", "0.1"]), "-qo", folder / "m.json")
    model = json.loads((folder / "m.json").read_text())
    model.pop("crc32")
    true = folder / "true.json"
    true.write_text(json.dumps(model))
    faults = [] if made.returncode == 0 and run(command, "check", true).returncode == 0 else ["the model itself is refused"]
    # How long it took, and which earlier build made it, no file shows.
    places = [path for path in numbers_of(model) if "seconds" not in path]
    path = places[int(rng.integers(len(places)))]
    told = ".".join(map(str, path))
    node = model
    for key in path[:-1]:
        node = node[key]
    was = node[path[-1]]
    node[path[-1]] = (not was) if isinstance(was, bool) else was + max(1, abs(was) // 4) if isinstance(was, int) else was * 1.3 + 0.05
    lie = folder / "lie.json"
    lie.write_text(json.dumps(model))
    found = run(command, "check", lie).returncode != 0
    # Without dents is what a convex body is.
    is_true = path[-1] == "dents" and is_convex(model["aggregates"][path[1]])
    if not found and not is_true and not OF_THE_VOLUME.intersection(path):
        faults.append(f"{told} is {node[path[-1]]} for {was}, and passes")
    return "found" if found else "of the volume alone", faults


def written(command, number, folder):
    return writers(run, command, number, folder)


def contradictions(command, number, folder):
    return contradicted(run, command, number, folder)


KINDS = {
    "volumes": volumes,
    "cores": cores,
    "surfaces": surfaces,
    "lies": lies,
    "writers": written,
    "contradictions": contradictions,
    "packed": packed,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", nargs="?", choices=list(KINDS), default="volumes")
    parser.add_argument("--command", default="mesocrete")
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--from", dest="first", type=int, default=0)
    parser.add_argument("--results", type=Path, default=RESULTS / "border.csv")
    parser.add_argument("--quick", action="store_true", help="two cases of each kind but the last, kept nowhere")
    given = parser.parse_args()
    if given.quick:
        return sum(measure(kind, given.command, range(2))[0] for kind in list(KINDS)[:-1])
    wrong, told = measure(given.kind, given.command, range(given.first, given.first + given.cases))
    is_new = not given.results.exists()
    with given.results.open("a", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerows([HEAD] if is_new else [])
        rows.writerow([given.kind, given.first, given.cases, wrong, told, *origin().split(",")])
    return wrong


def measure(kind, command, numbers):
    """Judge some cases: the number of wrong ones, and the outcomes in words."""
    outcomes, wrong = collections.Counter(), 0
    for number in numbers:
        with tempfile.TemporaryDirectory() as folder:
            outcome, faults = KINDS[kind](command, number, Path(folder))
        outcomes[outcome] += 1
        wrong += bool(faults)
        for fault in faults:
            print(f"{kind} {number}: {fault}", flush=True)
    told = "; ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))
    print(f"{len(numbers)} cases of {kind}, {wrong} wrong: {told}", flush=True)
    return wrong, told


if __name__ == "__main__":
    raise SystemExit(1 if main() else 0)
