"""Label volumes that other programs wrote, for `border.py writers`: the array and the voxel that the writer knows are the judge.

A writer is a function of (rng, file without ending, labels [z, y, x], edges of a voxel along x, y, z). It returns the path, and
what a reader can know: the edges (`None` where the format or the writer leaves them out), or a word if the file holds no single
volume, so that it must be refused. Writers: tifffile, imageio, Pillow, scikit-image, OpenCV, libvips, SimpleITK, VTK, PyVista,
pyevtk, uvw and NumPy; those that are not installed are counted as such.
"""

import json

import numpy as np

UNITS = {"mm": 1, "millimeter": 1, "cm": 10, "micron": 1e-3, "um": 1e-3, "nm": 1e-6, "m": 1e3, "inch": 25.4, "meters": 1e3}


def scene(rng):
    """Boxes of one label each, in octants of their own: labels, and of each box its label and its corners in voxels."""
    n = rng.integers(18, 31, 3)
    labels, boxes = np.zeros(n, np.int64), []
    octants = rng.permutation(8)[: rng.integers(2, 5)]
    for octant in octants:
        at = [(octant >> a & 1) * (n[a] // 2) for a in range(3)]
        size = [rng.integers(5, n[a] // 2 - 2) for a in range(3)]
        low = [at[a] + rng.integers(1, n[a] // 2 - size[a]) for a in range(3)]
        label = int(rng.choice(np.setdiff1d(np.arange(1, 120), [box[0] for box in boxes])))
        labels[tuple(slice(l, l + s) for l, s in zip(low, size))] = label
        boxes.append((label, np.array(low)[::-1], (np.array(low) + size)[::-1]))
    edges = [float(x) for x in rng.choice([0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0], 3 if rng.random() < 0.3 else 1)]
    edges = edges * (3 // len(edges)) if len(edges) == 1 else edges
    if rng.random() < 0.4:
        edges[2] = edges[0] * float(rng.choice([2, 3, 0.5]))
    return labels, boxes, edges


def any_of(rng, labels, kinds):
    """A type of numbers, and the labels of that type: large ones where there is room."""
    kind = np.dtype(str(rng.choice(kinds)))
    return labels.astype(kind)


def tifffile_plain(rng, name, labels, edges):
    import tifffile

    labels = any_of(rng, labels, ["u1", "u2", "u4", "i1", "i2", "i4", "f4", "f8", "u8", "i8"])
    how = {"byteorder": str(rng.choice(["<", ">"])), "bigtiff": bool(rng.random() < 0.3), "photometric": "minisblack"}
    how["compression"] = rng.choice([None, None, "zlib", "deflate", "lzw", "packbits", "zstd", "lzma"])
    how["compression"] = how["compression"] and str(how["compression"])
    if how["compression"] == "packbits":
        labels = labels.astype("u1")
    if how["compression"] in ("zlib", "lzw") and labels.dtype.kind != "f":
        how["predictor"] = bool(rng.random() < 0.5) and labels.dtype.itemsize < 8
    if rng.random() < 0.3:
        how["tile"] = (16, 16)
    elif rng.random() < 0.3:
        how["rowsperstrip"] = int(rng.integers(1, 9))
    if rng.random() < 0.3:
        how["metadata"] = None
    if rng.random() < 0.3:
        how.update(resolution=(10 / edges[0], 10 / edges[1]), resolutionunit="CENTIMETER")
    if rng.random() < 0.1:
        labels, refused = np.stack([labels] * 3, -1).astype("u1"), "colours"
        how.update(photometric="rgb", predictor=False, compression=None)
        tifffile.imwrite(f"{name}.tif", labels, **how)
        return f"{name}.tif", refused
    tifffile.imwrite(f"{name}.tif", labels, **how)
    return f"{name}.tif", None


def tifffile_imagej(rng, name, labels, edges):
    import tifffile

    labels = any_of(rng, labels, ["u1", "u2", "f4"])
    unit = str(rng.choice([*UNITS, "pixel", "none", "furlong"]))
    of = UNITS.get(unit)
    about = {} if unit == "none" else {"unit": unit}
    known = None
    if of:
        known = list(edges)
        x, y, z = (h / of for h in edges)
        about["spacing"] = z
        if rng.random() < 0.25:
            # ImageJ leaves out what is 1 of its unit.
            about.pop("spacing")
            known[2] = float(of)
    else:
        x, y = edges[:2]
    axes, draw = "ZYX", rng.random()
    if draw < 0.12:
        labels, axes, known = np.stack([labels, labels * 0], 1), "ZCYX", "channels"
    elif draw < 0.2:
        labels, axes, known = np.stack([labels, labels]), "TZYX", "frames"
    elif draw < 0.28:
        axes, known = "TYX", "frames"
    elif draw < 0.34:
        axes, known = "CYX", "channels"
    more = {"compression": str(rng.choice(["zlib", "lzw"]))} if rng.random() < 0.2 else {}
    if labels.dtype == np.uint8 and rng.random() < 0.2 and "C" not in axes:
        more["colormap"] = rng.integers(0, 65535, (3, 256)).astype("u2")
    tifffile.imwrite(f"{name}.tif", labels, imagej=True, resolution=(1 / x, 1 / y), metadata={**about, "axes": axes}, **more)
    return f"{name}.tif", known


def tifffile_ome(rng, name, labels, edges):
    import tifffile

    labels = any_of(rng, labels, ["u1", "u2", "i2", "i4", "f4"])
    unit = str(rng.choice(["mm", "µm", "um", "nm", "cm", "m", "none", "pixel"]))
    of, about, known = {"none": 1e-3, "µm": 1e-3, "pixel": None, **UNITS}.get(unit, UNITS.get(unit)), {}, None
    for axis, h in zip("XYZ", edges):
        about[f"PhysicalSize{axis}"] = h / (of or 1)
        if unit != "none":
            about[f"PhysicalSize{axis}Unit"] = unit
    known = list(edges) if of else None
    if rng.random() < 0.2:
        about.pop("PhysicalSizeZ"), about.pop("PhysicalSizeZUnit", None)
        known = None
    axes, draw = "ZYX", rng.random()
    if draw < 0.12:
        labels, axes, known = np.stack([labels, labels]), "CZYX", "channels"
    elif draw < 0.24:
        labels, axes, known = np.stack([labels, labels]), "TZYX", "frames"
    more = {"compression": "zlib"} if rng.random() < 0.3 else {}
    if rng.random() < 0.3 and axes == "ZYX":
        with tifffile.TiffWriter(f"{name}.ome.tif") as file:
            file.write(labels, subifds=1, metadata={**about, "axes": axes}, **more)
            file.write(np.ascontiguousarray(labels[:, ::2, ::2]), subfiletype=1, **more)
    else:
        tifffile.imwrite(f"{name}.ome.tif", labels, ome=True, metadata={**about, "axes": axes}, **more)
    return f"{name}.ome.tif", known


def imageio_stack(rng, name, labels, edges):
    import imageio.v2 as v2
    import imageio.v3 as v3

    labels = any_of(rng, labels, ["u1", "u2", "i4", "f4"])
    way = int(rng.integers(3))
    if way == 0:
        v3.imwrite(f"{name}.tiff", labels)
    elif way == 1:
        v2.volwrite(f"{name}.tiff", labels)
    else:
        v2.mimwrite(f"{name}.tiff", list(labels))
    return f"{name}.tiff", None


def pillow(rng, name, labels, edges):
    from PIL import Image

    mode = str(rng.choice(["L", "I;16", "I", "F", "P", "1", "RGB", "LA"]))
    kind = {"L": "u1", "P": "u1", "I;16": "u2", "I": "i4", "F": "f4", "1": "u1", "RGB": "u1", "LA": "u1"}[mode]
    pages = [Image.fromarray(page.astype(kind)) for page in (np.sign(labels) if mode == "1" else labels)]
    if mode == "1":
        pages = [Image.fromarray(page > 0) for page in labels]
    if mode in ("RGB", "LA"):
        pages = [page.convert(mode) for page in pages]
    if mode == "P":
        for page in pages:
            page.putpalette(list(rng.integers(0, 255, 768)))
    packing = str(rng.choice(["raw", "tiff_lzw", "tiff_deflate", "tiff_adobe_deflate", "packbits", "group4", "jpeg", "zstd"]))
    if packing == "group4" and mode != "1" or packing == "jpeg" and mode not in ("L", "RGB") or packing == "zstd" and mode == "P":
        packing = "raw"
    more = {"dpi": (300, 300)} if rng.random() < 0.3 else {}
    pages[0].save(f"{name}.tif", save_all=True, append_images=pages[1:], compression=packing, **more)
    if mode in ("RGB", "LA"):
        return f"{name}.tif", "colours"
    if packing == "jpeg":
        return f"{name}.tif", "lossy"
    return f"{name}.tif", ("mask", None) if mode == "1" else None


def skimage(rng, name, labels, edges):
    from skimage import io

    labels = any_of(rng, labels, ["u1", "u2", "i4", "f4"])
    io.imsave(f"{name}.tif", labels, check_contrast=False)
    return f"{name}.tif", None


def opencv(rng, name, labels, edges):
    import cv2

    labels = any_of(rng, labels, ["u1", "u2", "f4"])
    how = [] if rng.random() < 0.5 else [cv2.IMWRITE_TIFF_COMPRESSION, int(rng.choice([1, 5, 8, 32773]))]
    cv2.imwritemulti(f"{name}.tif", list(labels), how)
    return f"{name}.tif", None


def vips(rng, name, labels, edges):
    import pyvips

    labels = any_of(rng, labels, ["u1", "u2", "f4"])
    tall = pyvips.Image.new_from_array(np.ascontiguousarray(labels.reshape(-1, labels.shape[2])))
    tall = tall.copy(xres=1 / edges[0], yres=1 / edges[1])
    tall.set_type(pyvips.GValue.gint_type, "page-height", labels.shape[1])
    how = {"compression": str(rng.choice(["none", "deflate", "lzw", "packbits"]))}
    draw = rng.random()
    if draw < 0.2:
        how.update(tile=True, tile_width=16, tile_height=16)
    elif draw < 0.4 and labels.dtype == np.uint8:
        how.update(miniswhite=True)
    elif draw < 0.5 and labels.dtype == np.uint8:
        how.update(bigtiff=True)
    tall.tiffsave(f"{name}.tif", **how)
    return f"{name}.tif", None


def simpleitk(rng, name, labels, edges):
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(any_of(rng, labels, ["u1", "u2", "f4", "i2"]))
    image.SetSpacing([float(h) for h in edges])
    sitk.WriteImage(image, f"{name}.tif", useCompression=bool(rng.random() < 0.3))
    return f"{name}.tif", None


def vtk_image(rng, labels, edges, kinds, is_cells):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(any_of(rng, labels, kinds)).ravel(), deep=True)
    array.SetName(str(rng.choice(["labels", "phase", "a b", "x&y"])))
    image = vtk.vtkImageData()
    n = [count + is_cells for count in labels.shape[::-1]]
    first = rng.integers(-5, 6, 3) if rng.random() < 0.4 else [0, 0, 0]
    image.SetExtent(*[int(x) for f, c in zip(first, n) for x in (f, f + c - 1)])
    image.SetSpacing(*edges)
    image.SetOrigin(*rng.uniform(-9, 9, 3))
    return image, array


def vtk_tiff(rng, name, labels, edges):
    import vtk

    image, array = vtk_image(rng, labels, edges, ["u1", "u2", "f4"], 0)
    image.SetExtent(0, labels.shape[2] - 1, 0, labels.shape[1] - 1, 0, labels.shape[0] - 1)
    image.GetPointData().SetScalars(array)
    writer = vtk.vtkTIFFWriter()
    writer.SetFileName(f"{name}.tif")
    writer.SetInputData(image)
    [writer.SetCompressionToNoCompression, writer.SetCompressionToPackBits, writer.SetCompressionToDeflate][rng.integers(3)]()
    writer.Write()

    return f"{name}.tif", None


def vtk_vti(rng, name, labels, edges):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    is_cells = int(rng.random() < 0.6)
    image, array = vtk_image(rng, labels, edges, ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"], is_cells)
    data = image.GetCellData() if is_cells else image.GetPointData()
    known, decoys = list(edges), int(rng.integers(0, 3))
    for k in range(decoys):
        other = numpy_to_vtk(rng.random(array.GetNumberOfTuples() * (3 if k else 1)).reshape((-1, 3) if k else (-1,)), deep=True)
        other.SetName(f"decoy{k}")
        data.AddArray(other)
    if rng.random() < 0.4:
        ghost = numpy_to_vtk(np.zeros(array.GetNumberOfTuples(), np.uint8), deep=True)
        ghost.SetName("vtkGhostType")
        data.AddArray(ghost)
    if rng.random() < 0.5 or not decoys:
        data.SetScalars(array)
    else:
        data.AddArray(array)
        known = ("array", array.GetName(), list(edges))
    if rng.random() < 0.3:
        other = image.GetPointData() if is_cells else image.GetCellData()
        n = image.GetNumberOfPoints() if is_cells else image.GetNumberOfCells()
        extra = numpy_to_vtk(np.arange(n, dtype=np.int32) % 50, deep=True)
        extra.SetName("other")
        other.AddArray(extra)
        known = ("array", array.GetName(), list(edges))
    if rng.random() < 0.15:
        turn = [[0, -1, 0, 1, 0, 0, 0, 0, 1], [-1, 0, 0, 0, 1, 0, 0, 0, 1], [0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1]][rng.integers(3)]
        image.SetDirectionMatrix(turn)
        known = "turned"
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetFileName(f"{name}.vti")
    writer.SetInputData(image)
    [writer.SetDataModeToAscii, writer.SetDataModeToBinary, writer.SetDataModeToAppended][rng.integers(3)]()
    writer.SetEncodeAppendedData(int(rng.integers(2)))
    [writer.SetCompressorTypeToNone, writer.SetCompressorTypeToZLib, writer.SetCompressorTypeToZLib, writer.SetCompressorTypeToLZ4, writer.SetCompressorTypeToLZMA][rng.integers(5)]()
    [writer.SetByteOrderToBigEndian, writer.SetByteOrderToLittleEndian][rng.integers(2)]()
    [writer.SetHeaderTypeToUInt32, writer.SetHeaderTypeToUInt64][rng.integers(2)]()
    if rng.random() < 0.3:
        writer.SetBlockSize(4096)
    writer.Write()
    return f"{name}.vti", known


def pyvista(rng, name, labels, edges):
    import pyvista as pv

    is_cells = int(rng.random() < 0.6)
    grid = pv.ImageData(dimensions=[n + is_cells for n in labels.shape[::-1]], spacing=edges, origin=rng.uniform(-5, 5, 3))
    values = any_of(rng, labels, ["u1", "i2", "i4", "i8", "f4", "f8"]).ravel()
    (grid.cell_data if is_cells else grid.point_data)["labels"] = values
    grid.save(f"{name}.vti", binary=bool(rng.random() < 0.7))
    return f"{name}.vti", list(edges)


def evtk(rng, name, labels, edges):
    from pyevtk.hl import imageToVTK

    labels = np.asfortranarray(any_of(rng, labels, ["u1", "i2", "i4", "f4", "f8"]).transpose(2, 1, 0))
    data = {"cellData": {"labels": labels}} if rng.random() < 0.6 else {"pointData": {"labels": labels}}
    path = imageToVTK(name, origin=(0.0, 0.0, 0.0), spacing=tuple(edges), **data)
    return path, list(edges)


def uvw_grid(rng, name, labels, edges):
    from uvw import DataArray, ImageData

    # uvw takes the corners of the box.
    n = labels.shape[::-1]
    is_cells = bool(rng.random() < 0.6)
    points = [count + is_cells for count in n]
    with ImageData(f"{name}.vti", [(0.0, h * (p - 1)) for h, p in zip(edges, points)], points, compression=bool(rng.random() < 0.5)) as grid:
        array = DataArray(any_of(rng, labels, ["u1", "i4", "f8"]).transpose(2, 1, 0), range(3), "labels")
        (grid.addCellData if is_cells else grid.addPointData)(array)
    return f"{name}.vti", list(edges)


def numpy_array(rng, name, labels, edges):
    labels = any_of(rng, labels, ["u1", "i1", ">u2", "<i2", ">u4", "i4", ">i8", "u8", ">f4", "f8"])
    if rng.random() < 0.5:
        labels = np.asfortranarray(labels)
    with open(f"{name}.npy", "wb") as file:
        np.lib.format.write_array(file, labels, version=[(1, 0), (2, 0), (3, 0)][rng.integers(3)])
    return f"{name}.npy", None


WRITERS = [tifffile_plain, tifffile_imagej, tifffile_ome, imageio_stack, pillow, skimage, opencv, vips, simpleitk, vtk_tiff, vtk_vti, vtk_vti, pyvista, evtk, uvw_grid, numpy_array]


def writers(run, command, number, folder):
    """One file of one writer: the outcome in words, and the faults."""
    rng = np.random.default_rng([6, number])
    labels, boxes, edges = scene(rng)
    writer = WRITERS[number % len(WRITERS)]
    name = writer.__name__
    try:
        file, known = writer(rng, str(folder / "v"), labels, edges)
    except ImportError:
        return f"{name} not installed", []
    except Exception as error:  # noqa: BLE001
        print(f"writers {number}: {name} does not write this: {error!r}", flush=True)
        return f"{name} did not write", []
    flags, model = [], folder / "m.json"
    if isinstance(known, tuple) and known[0] == "array":
        flags, known = ["--array", known[1]], known[2]
    elif isinstance(known, tuple) and known[0] == "mirrored":
        n = labels.shape[1]
        boxes = [(label, np.array([a[0], n - b[1], a[2]]), np.array([b[0], n - a[1], b[2]])) for label, a, b in boxes]
        known = known[1]
    elif isinstance(known, tuple):
        boxes, known = [(1, a, b) for _, a, b in boxes], known[1]
    found = run(command, "import", file, "-fo", model, *flags)
    if found.returncode:
        if found.returncode not in (1, 2) or "panicked" in found.stderr:
            return f"{name} refused", [f"exit code {found.returncode}: {found.stderr[-300:]}"]
        is_told = isinstance(known, str) or any(word in found.stderr for word in ("is not read", "Direction"))
        return f"{name} refused", [] if is_told else [f"{file}: refused: {found.stderr[-300:]}"]
    if isinstance(known, str):
        return f"{name} taken", [f"{file}: taken, but it has {known}"]
    return f"{name} taken", list(faults(json.loads(model.read_text()), found.stderr, labels, boxes, known))


def faults(saved, said, labels, boxes, known):
    """What of the model contradicts the writer's array and voxel."""
    of = saved["report"]["labels"]
    if of["voxels"] != list(labels.shape[::-1]):
        yield f"{of['voxels']} voxels for {labels.shape[::-1]}"
        return
    h = np.array(of["voxel_size_mm"])
    is_asked = "so it is 1 mm" in said
    if known is None and not (is_asked and (h == 1).all()):
        yield f"a voxel of {h} that the file does not have; said: {said}"
    if known is not None and (is_asked or not np.allclose(h, known, rtol=2e-5, atol=0)):
        yield f"a voxel of {h} for {known}; said: {said}"
    if abs(of["fraction"] * labels.size - (labels > 0).sum()) > 1e-6:
        yield f"{of['fraction'] * labels.size} voxels of grains for {(labels > 0).sum()}"
    if sorted(of["labels"]) != sorted(box[0] for box in boxes):
        yield f"labels {of['labels']} for {sorted(box[0] for box in boxes)}"
        return
    left = list(boxes)
    for label, grain in zip(of["labels"], saved["aggregates"]):
        v = np.array(grain["vertices"]) / h
        near = [box for box in left if box[0] == label and max(abs(v.min(0) - box[1]).max(), abs(v.max(0) - box[2]).max()) < 1.5]
        if not near:
            yield f"label {label} lies from {v.min(0)} to {v.max(0)} voxels, in none of {left}"
            return
        left = [box for box in left if box is not near[0]]
