#!/usr/bin/env bash
# Builds the renderer with its CUDA engine, runs the tests that need a device and measures, on a machine that has
# CUDA 13, CMake 3.31 or later, Ninja, Protobuf and GoogleTest, and perhaps nothing else (docs/gpu.md).
#   HEADERS  folder with include/{tl,nlohmann,CLI}, where the machine lacks them (tools/gpu/headers.sh)
#   CRANIUM  the scene's volume (tools/gpu/cranium_volume.py); without it nothing is measured
#   OUT      where logs, pictures and figures.json go; default out/
#   STEPS    of "build unit gpu memcheck measure"; default all
set -uo pipefail
cd "$(dirname "$0")/../.."
OUT=${OUT:-$PWD/out}
STEPS=${STEPS:-build unit gpu memcheck measure}
BUILD=${BUILD:-build/remote}
CRANIUM=${CRANIUM:-}
mkdir -p "$OUT"
failed=0
wants() { [[ " $STEPS " == *" $1 "* ]]; }
step() { # name, command...: runs it, keeps its output, says how it went
  local name=$1 start=$SECONDS
  shift
  if "$@" > "$OUT/$name.log" 2>&1; then
    echo "ok      $name ($((SECONDS - start)) s)"
  else
    echo "FAILED  $name ($((SECONDS - start)) s)"
    tail -n 40 "$OUT/$name.log"
    failed=1
    return 1
  fi
}

if wants build; then
  headers=()
  if [[ -n ${HEADERS:-} ]]; then headers=(-DCMAKE_INCLUDE_PATH="$(readlink -f "$HEADERS")/include"); fi
  step configure cmake -G Ninja -S . -B "$BUILD" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DDIAPHANE_API=OFF \
    -DDIAPHANE_RENDERD=OFF -DDIAPHANE_INGEST=OFF -DDIAPHANE_CUDA=ON "${headers[@]}" || exit 1
  grep -i 'CUDA engine' "$OUT/configure.log"
  step build ninja -C "$BUILD" || exit 1
fi
nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader
if wants unit; then step unit ctest --test-dir "$BUILD" -LE gpu --output-on-failure; fi
if wants gpu; then
  step gpu "$BUILD/bin/render_cuda_test"
  grep -E '^\[  (PASSED|FAILED|SKIPPED)|tests ran' "$OUT/gpu.log"
fi
if wants memcheck; then
  for tool in memcheck racecheck initcheck; do
    step "$tool" compute-sanitizer --tool $tool --error-exitcode 9 "$BUILD/bin/render_cuda_test" \
      --gtest_filter='CudaFilmTest.*:CudaEngineTest.TheSame*:CudaEngineTest.ABadScene*:CudaEngineTest.ANewScene*'
    grep -E 'ERROR SUMMARY|RACECHECK SUMMARY' "$OUT/$tool.log"
  done
fi
if wants measure && [[ -n $CRANIUM ]]; then
  render=("$BUILD/bin/diaphane-render" "$CRANIUM" --scene tests/scenes/cranium.json --quiet)
  # Five runs each: median and spread over runs that each start the device anew.
  for run in 1 2 3 4 5; do
    "${render[@]}" --engine cuda --samples 2048 --seed $run --out "$OUT/cuda.ppm" --json "$OUT/cuda-512-$run.json"
    "${render[@]}" --engine cuda --samples 512 --size 1920x1080 --seed $run --out "$OUT/cuda-hd.ppm" \
      --json "$OUT/cuda-1080-$run.json"
  done
  "${render[@]}" --engine cpu --samples 256 --out "$OUT/cpu.ppm" --json "$OUT/cpu-512-1.json"
  python3 tools/gpu/compare_ppm.py "$OUT/cuda.ppm" "$OUT/cpu.ppm"
  "${render[@]}" --engine cuda --samples 2048 --out "$OUT/cranium.png" || true  # where libpng is
  python3 - "$OUT" <<'EOF'
import glob, json, statistics, sys
out = sys.argv[1]
figures = {}
for name in ("cuda-512", "cuda-1080", "cpu-512"):
    runs = [json.load(open(f)) for f in glob.glob(f"{out}/{name}-?.json")]
    if not runs:
        continue
    per_sample = sorted(r["milliseconds"] / r["samples"] for r in runs)
    ms = statistics.median(per_sample)
    one = runs[0]
    # The error falls as the square root of the samples.
    to_5_percent = one["samples"] * (one["estimated_error"] / 0.05) ** 2
    figures[name] = {"device": one["device"], "ms_per_sample": ms, "spread": per_sample[-1] - per_sample[0],
                     "samples_per_second": one["width"] * one["height"] * 1e3 / ms,
                     "samples_to_rmse_0.05": to_5_percent, "ms_to_rmse_0.05": to_5_percent * ms, "runs": runs}
json.dump(figures, open(f"{out}/figures.json", "w"), indent=2)
for name, f in figures.items():
    print(f"{name:10} {f['device']:28} {f['ms_per_sample']:.4f} ms a sample (+-{f['spread'] / 2:.4f}), "
          f"{f['samples_per_second'] / 1e6:.1f} M samples/s, RMSE 0.05 after {f['samples_to_rmse_0.05']:.0f} samples, "
          f"{f['ms_to_rmse_0.05']:.1f} ms")
EOF
  rm -f "$OUT"/*.ppm "$OUT"/c*-?.json
fi
exit $failed
