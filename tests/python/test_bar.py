"""The bar of the command on a terminal: one line, as wide as the terminal, gone at the end."""

import os
import re
import sys

import pytest

pty = pytest.importorskip("pty")


def on_terminal(command, args, columns, cwd):
    """Run the command with stderr on a terminal of so many columns; everything it wrote there."""
    import fcntl
    import struct
    import subprocess
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


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
@pytest.mark.parametrize("columns", [40, 100])
def test_the_bar_stays_on_one_line_and_never_falls(command, tmp_path, columns):
    """Every drawing fits the terminal; percentages rise; the stages come in their order."""
    text = on_terminal(command, ["pack", "--fraction", "0.5", "-o", "model.json"], columns, tmp_path)
    drawings = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", part) for part in re.split(r"[\r\n]", text)]
    bars = [drawing for drawing in drawings if re.match(r"(take|place|prove|measure|write) ", drawing)]
    assert bars, text[:500]
    assert max(map(len, bars)) <= columns
    percent = [int(re.search(r"(\d+) %", bar).group(1)) for bar in bars]
    assert percent == sorted(percent) and percent[-1] > 50
    order = list(dict.fromkeys(bar.split()[0] for bar in bars))
    assert order == [stage for stage in ("take", "place", "prove", "measure", "write") if stage in order]
    assert "Ctrl-C keeps what is placed" in text or columns < 72
    assert "\x1b[3" not in text, "there is no colour"


def test_a_pipe_gets_plain_lines_alone(run):
    """No control characters where nobody sees them."""
    done = run("pack", "--fraction", "0.3", "-o", "model.json")
    assert done.returncode == 0 and "\x1b" not in done.stderr and "\r" not in done.stderr
