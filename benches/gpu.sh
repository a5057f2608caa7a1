#!/usr/bin/env bash
# Measures a GPU in four minutes: the bytes beside the processor's, and nanoseconds a tetrahedron and step.
#
#     benches/gpu.sh MESOCRETE CUBE LARGE OUT
#
# MESOCRETE is the command, built with `cargo build --release -p meso-cli --features gpu`. CUBE and LARGE are saved models:
# a cube of 24 mm, and the 150 mm cube of `mesocrete pack --fraction 0.4 --min-gap-mm 1`. OUT gets gpu.csv, one row a run,
# written as soon as it is known, and the logs. Every stage has a time limit of its own, and one that fails does not end
# the others. DEVICE (cuda:0), COMMIT (a note in gpu.csv) and PROFILE=1 (ncu) may be set.
set -u
mesocrete=$(realpath "$1") cube=$(realpath "$2") large=$(realpath "$3") out=$4
device=${DEVICE:-cuda:0}
work=$(mktemp -d)
mkdir -p "$out"
rows="$out/gpu.csv"
card=$(nvidia-smi --query-gpu=name --format=csv,noheader 2>/dev/null | head -1)
echo "case,device,elements,steps,loop_seconds,whole_seconds,ns_per_tetrahedron_step,peak_mpa,curve_sha256,machine,date,commit" >"$rows"

say() { echo "[$SECONDS s] $*"; }

# NVRTC lies in CUDA's folder or in NVIDIA's Python packages.
nvrtc=$(find /usr/local/cuda*/ /opt /usr/lib -name 'libnvrtc.so.1*' 2>/dev/null | head -1)
[ -z "$nvrtc" ] || export LD_LIBRARY_PATH="$(dirname "$nvrtc"):${LD_LIBRARY_PATH:-}"

# run NAME LIMIT DEVICE MODEL FLAGS...: a test; the limit ends it as Ctrl-C does, and its curve until then counts.
run() {
    local name=$1 limit=$2 on=$3 model=$4
    shift 4
    timeout -s INT -k 20 "$limit" "$mesocrete" solve "$model" -o "$work/$name" --device "$on" --force "$@" 2>&1 >/dev/null |
        while IFS= read -r line; do echo "$(date +%s.%N) $line"; done >"$out/$name.log"
    python3 - "$work/$name" "$out/$name.log" "$name" "$on" "$rows" "${card:-no card}" "${COMMIT:-unknown}" <<'PY'
import datetime, hashlib, json, pathlib, sys
folder, log, name, on, rows, card, commit = sys.argv[1:]
stamps = [line.split(" ", 1) for line in pathlib.Path(log).read_text().splitlines()]
at = lambda word: next((float(s) for s, text in stamps if word in text and not text.startswith("warning")), None)
try:
    result = json.loads((pathlib.Path(folder) / "result.json").read_text())
    curve = hashlib.sha256((pathlib.Path(folder) / "curve.csv").read_bytes()).hexdigest()[:16]
except OSError as error:
    print(f"  {name} on {on}: no result ({error}); its log ends:")
    print("   ", *[text for _, text in stamps][-4:], sep="\n    ")
    sys.exit()
begun, ended = at(f"on {on.split(':')[0]}:") or at("to a strain of"), at("peak ")
loop = ended - begun if begun and ended else float("nan")
ns = loop * 1e9 / result["elements"] / max(result["steps"], 1)
row = [name, on, result["elements"], result["steps"], f"{loop:.3f}", f"{result['seconds']['total']:.2f}", f"{ns:.4f}", result["peak_mpa"], curve, card, datetime.date.today().isoformat(), commit]
with open(rows, "a") as file:
    file.write(",".join(map(str, row)) + "\n")
print(f"  {name} on {on}: {result['elements']} tetrahedra, {result['steps']} steps, {loop:.2f} s in the loop, {ns:.4f} ns a tetrahedron and step, curve {curve}")
PY
}

# same A B: whether the curves (as far as the shorter one goes) and the frames of two runs are equal.
same() {
    local a=$work/$1 b=$work/$2 rows
    rows=$(($(wc -l <"$a/curve.csv") < $(wc -l <"$b/curve.csv") ? $(wc -l <"$a/curve.csv") : $(wc -l <"$b/curve.csv")))
    # The last row of a stopped run may be cut short.
    if cmp -s <(head -n "$rows" "$a/curve.csv") <(head -n "$rows" "$b/curve.csv"); then
        say "same curve in $rows lines: $1 $2"
    else
        say "CURVES DIFFER: $1 $2"
        diff <(head -n "$rows" "$a/curve.csv") <(head -n "$rows" "$b/curve.csv") | head -4
    fi
    for file in "$a"/*.vtu; do
        [ -e "$file" ] || continue
        cmp -s "$file" "$b/$(basename "$file")" && say "same frame $(basename "$file")" || say "FRAME DIFFERS: $(basename "$file")"
    done
}

say "machine"
nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv 2>&1 | tee "$out/card.txt"
nproc | sed 's/$/ cores/'
timeout 60 "$mesocrete" devices --check 2>&1 | tee -a "$out/card.txt"

say "cube of 24 mm, whole test, processor and device"
run cube-cpu 60 cpu "$cube" --element-size-mm 2 --frames 3
run cube-gpu 60 "$device" "$cube" --element-size-mm 2 --frames 3
same cube-cpu cube-gpu
run cube-cdpm2-cpu 60 cpu "$cube" --element-size-mm 2 --frames 0 --law cdpm2 --test tension
run cube-cdpm2-gpu 60 "$device" "$cube" --element-size-mm 2 --frames 0 --law cdpm2 --test tension
same cube-cdpm2-cpu cube-cdpm2-gpu

# Their paths and supports are the processor's: each step waits for it.
say "named tests on the cube"
for test in triaxial biaxial cyclic; do
    run "$test-cpu" 15 cpu "$cube" --element-size-mm 2 --frames 1 --strain 0.002 --test "$test"
    run "$test-gpu" 15 "$device" "$cube" --element-size-mm 2 --frames 1 --strain 0.002 --test "$test"
    same "$test-cpu" "$test-gpu"
done

say "150 mm at 4 mm: 0.8 million tetrahedra"
for threads in 128 256 64; do
    run "large4-$threads" 40 "$device:$threads" "$large" --element-size-mm 4 --frames 0
done

say "150 mm at 2 mm: 8.1 million tetrahedra"
run large2-gpu "${LARGE_LIMIT:-100}" "$device" "$large" --element-size-mm 2 --narrow-gaps split --frames 0
say "races"
if command -v compute-sanitizer >/dev/null; then
    timeout -k 5 45 compute-sanitizer --tool racecheck "$mesocrete" solve "$cube" -o "$work/race" --device "$device" \
        --element-size-mm 4 --frames 0 --quiet --duration 1e-5 --time-step 4e-7 >"$out/racecheck.txt" 2>&1
    tail -3 "$out/racecheck.txt"
fi
say "processor beside: 4 mm"
run large4-cpu 40 cpu "$large" --element-size-mm 4 --frames 0
same large4-cpu large4-128
if [ -n "${PROFILE:-}" ] && command -v ncu >/dev/null; then
    say "profile"
    timeout -s INT 30 ncu --clock-control none --set full -k 'regex:elements|nodes|sums|scalars' --launch-skip 40 --launch-count 4 \
        "$mesocrete" solve "$large" -o "$work/ncu" --device "$device" --element-size-mm 4 --frames 0 --quiet >"$out/ncu.txt" 2>&1
    grep -E "elements|nodes|sums|scalars|Duration|DRAM Throughput|Memory Throughput|Registers Per|Achieved Occ|L1/TEX Hit|L2 Hit" "$out/ncu.txt" | head -40
fi
say "processor beside: the first steps at 2 mm"
run large2-cpu "${CPU_LIMIT:-60}" cpu "$large" --element-size-mm 2 --narrow-gaps split --frames 0
same large2-cpu large2-gpu
cp "$work"/large2-gpu/curve.csv "$out/large2-gpu-curve.csv" 2>/dev/null
rm -rf "$work"
say "done"
cat "$rows"
