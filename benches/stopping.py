"""How long Ctrl-C takes to end all work, stage by stage, from the command and from Python; and what kills leave behind.

On a busy machine the seconds of wall time grow with the load; the processor time after Ctrl-C (`cpu_s`) does not.

    python3 benches/stopping.py                  # with the wheel installed; enters benches/results/stopping.csv
    python3 benches/stopping.py --kills 500      # 500 random moments; enters benches/results/kills.csv

`--quick` strikes every stage once, or seven moments, and enters nothing. `--command` names another build of the command. On
Linux alone: threads and processes are looked up in /proc.
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests" / "python"), str(ROOT / "benches")]

from kills import campaign, session  # noqa: E402
from origin import RESULTS, origin  # noqa: E402

# When Ctrl-C comes, s after the start.
DELAYS = [0.5, 1.5, 3.0]
LARGE = "fraction = 0.55\nspecimen = { kind = 'cube', side_mm = 150 }\n"
GAPS = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 60 }\nplacement = { min_gap_mm = 0.3, wall_gap_mm = 0.3 }\n"
STUDY = "spec = 'large.toml'\n[over]\nseed = [1, 2, 3]\n"

# Every stage takes far longer than the last delay on one core.
COMMANDS = {
    "pack": ["pack", "large.toml", "-o", "x.json"],
    "mesh": ["mesh", "gaps.json", "-o", "x.vtu", "--method", "lattice", "--element-size-mm", "0.5"],
    "conforming": ["mesh", "gaps.json", "-o", "x.vtu", "--method", "conforming", "--element-size-mm", "1"],
    "check": ["check", "many.json"],
    "statistics": ["report", "many.json", "-o", "x.html"],
    "voxelize": ["image", "many.json", "-o", "x.npy", "--what", "share", "--voxel-size-mm", "0.25"],
    "solve": ["solve", "gaps.json", "-o", "x", "--element-size-mm", "2"],
    "study": ["study", "study.toml", "-o", "x"],
}
PYTHON = {
    "pack": "mc.pack('large.toml')",
    "mesh": "mc.load('gaps.json').mesh(method='lattice', element_size=0.5)",
    "conforming": "mc.load('gaps.json').mesh(method='conforming', element_size=1.0)",
    "check": "mc.load('many.json').check()",
    "statistics": "mc.load('many.json').statistics()",
    "voxelize": "mc.load('many.json').voxelize(0.25, 'share')",
    "solve": "mc.load('gaps.json').mesh(method='lattice', element_size=2.0, itz='none').solve()",
    "study": "mc.study('large.toml', over={'seed': [1, 2, 3]}, out='x')",
}
SCRIPT = """
import os, signal, threading, time
import mesocrete as mc
signal.signal(signal.SIGINT, signal.default_int_handler)
sent = []
def send():
    sent.append((time.monotonic(), time.process_time()))
    os.kill(os.getpid(), signal.SIGINT)
timer = threading.Timer(DELAY, send)
timer.start()
def workers():
    names = []
    for task in os.listdir("/proc/self/task"):
        try:
            names.append(open(f"/proc/self/task/{task}/comm").read().strip())
        except OSError:
            pass
    return [name for name in names if name.startswith("mesocrete")]
try:
    WORK
except KeyboardInterrupt:
    (wall, cpu), heard = sent[0], time.monotonic()
    while workers() and time.monotonic() - wall < 120:
        time.sleep(0.005)
    print(heard - wall, time.monotonic() - wall, time.process_time() - cpu)
timer.cancel()
"""


def main() -> int:
    """Measure, print, and enter the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", default=shutil.which("mesocrete"))
    parser.add_argument("--kills", type=int, metavar="N")
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if args.kills is not None or args.quick:
            enter_kills(args, Path(folder))
        if args.kills is None:
            enter_times(args, Path(folder))
    return 0


def enter_kills(args: argparse.Namespace, folder: Path) -> None:
    """End commands at random moments and count what is wrong."""
    place = folder / "kills"
    place.mkdir()
    tally = campaign(args.command, place, 7 if args.quick else args.kills)
    print("\n".join(tally.faults() + tally.between_names))
    counts = [tally.moments, tally.before_the_end, *(len(found) for found in (tally.torn, tally.mixed + tally.between_names, tally.left_over, tally.children))]
    header = "moments,before_the_end,torn,mixed,left_over_after_int_and_term,children,machine,date,commit"
    enter("kills.csv", header, [",".join(map(str, counts))], args.quick)


def enter_times(args: argparse.Namespace, folder: Path) -> None:
    """Press Ctrl-C in every stage of both fronts."""
    (folder / "large.toml").write_text(LARGE, encoding="utf-8")
    (folder / "gaps.toml").write_text(GAPS, encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    for words in (["pack", "gaps.toml", "-q", "-o", "gaps.json"], ["pack", "-q", "-o", "many.json"]):
        subprocess.run([args.command, *words], cwd=folder, check=True)
    rows = []
    for stage in COMMANDS:
        for delay in DELAYS[:1] if args.quick else DELAYS:
            for front, stopped in (("command", stop_command), ("python", stop_python)):
                measured = stopped(args.command, stage, delay, folder)
                rows.append(f"{front},{stage},{delay},{measured}")
                print(rows[-1], flush=True)
                shutil.rmtree(folder / "x", ignore_errors=True)
    enter("stopping.csv", "front,stage,after_s,heard_s,all_ended_s,cpu_s,machine,date,commit", rows, args.quick)


def stop_command(command: str, stage: str, delay: float, folder: Path) -> str:
    """Interrupt the command; seconds to its exit, and to that of its last child."""
    process = subprocess.Popen(
        [command, *COMMANDS[stage], "-f"] if stage not in ("check", "study") else [command, *COMMANDS[stage]],
        cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
    time.sleep(delay)
    if process.poll() is not None:
        return "done before,,"
    sent, used = time.monotonic(), cpu_seconds(process.pid)
    process.send_signal(signal.SIGINT)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode, heard = status, time.monotonic() - sent
    left = session(process.pid, patience=60.0)
    ended = f"{left} goes on" if left else f"{time.monotonic() - sent:.3f}"
    return f"{heard:.3f},{ended},{usage.ru_utime + usage.ru_stime - used:.3f}"


def cpu_seconds(pid: int) -> float:
    """Processor time of a process and the children it has waited for."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def stop_python(_: str, stage: str, delay: float, folder: Path) -> str:
    """Interrupt Python; seconds to the exception, and to the end of the last worker."""
    script = SCRIPT.replace("WORK", PYTHON[stage]).replace("DELAY", str(delay))
    done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False)
    return ",".join(f"{float(word):.3f}" for word in done.stdout.split()) or f"done before,,{done.stderr[-60:]!r}"


def enter(name: str, header: str, rows: list[str], quick: bool) -> None:
    """Print the rows and, unless it was a look only, put them into the table."""
    lines = [header, *(f"{row},{origin()}" for row in rows)]
    if quick:
        print("\n".join(lines))
    else:
        (RESULTS / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
