"""The bar of the command on a terminal: one line, as wide as the terminal, gone at the end."""

import itertools
import os
import re
import subprocess
import sys

import numpy as np
import pytest

pty = pytest.importorskip("pty")


def on_terminal(command, args, columns, cwd):
    """Run the command with stderr on a terminal of so many columns; everything it wrote there."""
    import fcntl
    import struct
    import termios

    main, side = pty.openpty()
    fcntl.ioctl(side, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    environment = os.environ | {"TERM": "xterm", "NO_COLOR": "1"}
    environment.pop("COLUMNS", None)
    process = subprocess.Popen([command, *args], cwd=cwd, stderr=side, stdout=subprocess.DEVNULL, env=environment)
    os.close(side)
    text = b""
    while True:
        try:
            part = os.read(main, 65536)
        except OSError:
            break
        if not part:
            break
        text += part
    os.close(main)
    assert process.wait(timeout=120) == 0
    return text.decode()


def drawn(text, stages):
    """The bars in what a command wrote, which rise and have their stages in this order."""
    drawings = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", part) for part in re.split(r"[\r\n]", text)]
    bars = [drawing for drawing in drawings if re.match(rf"({'|'.join(stages)}) ", drawing)]
    assert bars, text[:500]
    percent = [percent_of(bar) for bar in bars]
    assert percent == sorted(percent)
    order = list(dict.fromkeys(bar.split()[0] for bar in bars))
    assert order == [stage for stage in stages if stage in order]
    return bars


def percent_of(bar):
    return int(re.search(r"(\d+) %", bar).group(1))


@pytest.fixture(scope="session")
def large_surface(command, tmp_path_factory):
    """A folder with a packing in a ball of 120,000 triangles: each face of a cube in 100 x 100 squares, drawn to the sphere."""
    folder = tmp_path_factory.mktemp("surface")
    grid = np.tan(np.linspace(-1, 1, 101) * np.pi / 4)
    u, v = np.meshgrid(grid, grid, indexing="ij")
    triangles = []
    for axis, side in itertools.product(range(3), (-1, 1)):
        points = np.empty((*u.shape, 3))
        points[..., axis], points[..., axis - 2], points[..., axis - 1] = side, u, v
        points = np.round(20 * points / np.linalg.norm(points, axis=-1, keepdims=True), 9).astype(np.float32)
        corners = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
        for three in ((0, 1, 2), (0, 2, 3)):
            triangles.append(np.stack([corners[k] for k in three[::side]], -2).reshape(-1, 3, 3))
    triangles = np.concatenate(triangles)
    records = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = triangles
    (folder / "ball.stl").write_bytes(bytes(80) + np.uint32(len(triangles)).tobytes() + records.tobytes())
    spec = "fraction = 0.1\n[specimen]\nkind = \"mesh\"\nfile = \"ball.stl\"\n[grading]\nd_min_mm = 5\nd_max_mm = 8\n"
    (folder / "spec.toml").write_text(spec)
    subprocess.run([command, "pack", "spec.toml", "-q", "-o", "model.json"], cwd=folder, check=True)
    return folder


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
@pytest.mark.parametrize(("args", "stages"), [
    (["check", "model.json"], ("read", "prove")),
    (["convert", "model.json", "-fo", "model.csv"], ("read",)),
    (["image", "model.json", "--voxel-size-mm", "2", "-fo", "model.npy"], ("read", "image")),
    (["mesh", "model.json", "--method", "voxel", "--element-size-mm", "4", "--accept-phase-error", "-fo", "model.vtu"], ("read", "mesh")),
])
def test_who_reads_a_model_shows_the_proof_of_its_surface(command, large_surface, args, stages):
    """The bar stands there from the start of the proof, which is most of the time of these commands."""
    bars = drawn(on_terminal(command, args, 100, large_surface), stages)
    assert bars[0].startswith("read ") and percent_of(bars[0]) < 50, bars


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
@pytest.mark.parametrize("columns", [40, 100])
def test_the_bar_stays_on_one_line_and_never_falls(command, tmp_path, columns):
    """Every drawing fits the terminal; percentages rise; the stages come in their order."""
    text = on_terminal(command, ["pack", "--fraction", "0.5", "-o", "model.json"], columns, tmp_path)
    bars = drawn(text, ("take", "place", "prove", "write", "statistics"))
    assert max(map(len, bars)) <= columns
    assert percent_of(bars[-1]) > 50
    assert "Ctrl-C keeps what is placed" in text or columns < 72
    assert "\x1b[3" not in text, "there is no colour"


def test_a_pipe_gets_plain_lines_alone(run):
    """No control characters where nobody sees them."""
    done = run("pack", "--fraction", "0.3", "-o", "model.json")
    assert done.returncode == 0 and "\x1b" not in done.stderr and "\r" not in done.stderr
