"""Does a process that goes on for hours keep its memory and its results? Packs, meshes and tests tiny specimens, one after another.

    python3 benches/long_run.py              # 1,000 specimens, then 1 to 64 threads; enters benches/results/long_run.csv

`--quick` takes 60 specimens and 1, 2 and 64 threads, and enters nothing. It ends with 1 where memory grew, or where a number of
threads changed a byte. Resident memory is read from /proc, so on Linux alone.
"""

import argparse
import hashlib
import sys
import tempfile
from pathlib import Path

import mesocrete as mc
from origin import RESULTS, origin

SPEC = {"specimen": {"kind": "cube", "side_mm": 25.0}, "fraction": 0.2, "grading": {"d_max_mm": 10.0}}
LARGER = {"specimen": {"kind": "cube", "side_mm": 60.0}, "fraction": 0.4}
# Memory is compared with what it was after so many specimens: caches and arenas are full by then.
SETTLED = 100
# The allocator keeps pages of its own; more than this is growth, MB.
ALLOWED_MB = 8.0
THREADS = [1, 2, 3, 4, 8, 16, 32, 64]


def main() -> int:
    """Run, print and enter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    count = 60 if args.quick else 1000
    settled, end = memory(count, min(SETTLED, count // 3))
    threads = [1, 2, 64] if args.quick else THREADS
    digests = {number: digest(number) for number in threads}
    same = len(set(digests.values())) == 1
    row = f"{count},{settled:.1f},{end:.1f},{threads[0]} to {threads[-1]},{same}"
    print(f"specimens,rss_mb_settled,rss_mb_end,threads,same_bytes\n{row}")
    if not args.quick:
        header = "specimens,rss_mb_after_100,rss_mb_end,threads,same_bytes,machine,date,commit"
        (RESULTS / "long_run.csv").write_text(f"{header}\n{row},{origin()}\n", encoding="utf-8")
    return 0 if same and end - settled <= ALLOWED_MB else 1


def memory(count: int, settled: int) -> tuple[float, float]:
    """Resident memory after `settled` specimens and after all, MB."""
    after = 0.0
    for seed in range(count):
        one(seed)
        if seed + 1 == settled:
            after = resident_mb()
    return after, resident_mb()


def one(seed: int) -> None:
    """Pack a specimen, mesh it in two ways, measure and check it, and test it for a moment."""
    packing = mc.pack(SPEC, seed=seed)
    packing.mesh(element_size=2.5, accept_phase_error=True)
    mesh = packing.mesh(method="lattice", element_size=5.0, itz="none", accept_phase_error=True)
    packing.statistics(lines=200, points=200)
    assert packing.check()["sound"]
    mesh.solve(strain=0.0004, frames=1)


def digest(threads: int) -> str:
    """What a packing on so many threads is, byte for byte."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.json"
        mc.pack(LARGER, seed=1, threads=threads).write(path)
        return hashlib.sha256(path.read_bytes()).hexdigest()


def resident_mb() -> float:
    """Resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * 4096 / 2**20


if __name__ == "__main__":
    sys.exit(main())
