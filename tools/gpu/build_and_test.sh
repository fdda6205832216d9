#!/usr/bin/env bash
# Builds the renderer with its CUDA engine, runs the tests that need a device, and measures the renderer. The machine needs
# only CUDA 13, CMake 3.31 or later, Ninja, Protobuf and GoogleTest (docs/gpu.md). Environment variables:
#   HEADERS    folder with include/{tl,nlohmann,CLI}, if the machine lacks them (tools/gpu/headers.sh)
#   CRANIUM    volume to measure (tools/gpu/cranium_volume.py); if unset, nothing is measured
#   OUT        folder for logs, pictures and render.json (default: out/)
#   CONFIGURE  further arguments for CMake
#   TARGETS    targets to build (default: all)
#   STEPS      any of "build unit gpu memcheck engine measure convergence stability schedule growth" (default: the first six)
set -uo pipefail
cd "$(dirname "$0")/../.."
OUT=${OUT:-$PWD/out}
STEPS=${STEPS:-build unit gpu memcheck engine measure}
BUILD=${BUILD:-build/remote}
CRANIUM=${CRANIUM:-}
mkdir -p "$OUT"
failed=0
wants() { [[ " $STEPS " == *" $1 "* ]]; }
step() { # name, command...: runs the command, stores its output and prints the outcome
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
    -DDIAPHANE_RENDERD=OFF -DDIAPHANE_INGEST=OFF -DDIAPHANE_CUDA=ON "${headers[@]}" ${CONFIGURE:-} || exit 1
  grep -i 'CUDA engine' "$OUT/configure.log"
  step build ninja -C "$BUILD" ${TARGETS:-} || exit 1
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
      --gtest_filter='CudaFilmTest.*:AccelerationTest.*:CudaEngineTest.SameSeed*:CudaEngineTest.RefusesInvalidScene*:CudaEngineTest.NewScene*'
    grep -E 'ERROR SUMMARY|RACECHECK SUMMARY' "$OUT/$tool.log"
  done
fi
if wants engine; then
  step engine "$BUILD/bin/diaphane-cuda-measure"
  cp "$OUT/engine.log" "$OUT/engine.json"
  if [[ -n $CRANIUM ]]; then
    python3 tools/gpu/kernels.py "$BUILD/bin/diaphane-render" "$CRANIUM" "$OUT/kernels.json" \
      tests/scenes/{cranium,surface}.json || failed=1
  fi
fi
if wants measure && [[ -n $CRANIUM ]]; then
  render=("$BUILD/bin/diaphane-render" "$CRANIUM" --scene tests/scenes/cranium.json --quiet)
  "${render[@]}" --engine cuda --samples 2048 --out "$OUT/cuda.ppm"
  "${render[@]}" --engine cpu --samples 256 --out "$OUT/cpu.ppm"
  python3 tools/gpu/compare_ppm.py "$OUT/cuda.ppm" "$OUT/cpu.ppm"
  rm "$OUT"/cuda.ppm "$OUT"/cpu.ppm
  "${render[@]}" --engine cuda --samples 2048 --out "$OUT/cranium.png" || true  # fails without libpng
  DIAPHANE_CRANIUM=$CRANIUM python3 tools/gpu/bench.py "$BUILD" "$OUT/render.json" || failed=1
fi
# Error over time for all scenes: convergence-cuda.json and .csv. docs/error-vs-time.md describes how to plot them.
# CONVERGENCE: options of `./diaphane bench convergence`.
if wants convergence; then
  DIAPHANE_CRANIUM=$CRANIUM step convergence python3 tools/gpu/bench.py "$BUILD" "$OUT/convergence.json" convergence \
    --engine cuda --no-plots --out "$OUT" ${CONVERGENCE:-}
fi
if wants stability; then
  step stability python3 tools/gpu/bench.py "$BUILD" "$OUT/stability.json" stability --engine cuda --out "$OUT"
fi
# Scheduling policies on the device, then in a simulation with the costs measured there. SCHEDULE: options of `./diaphane
# bench schedule`.
if wants schedule; then
  DIAPHANE_CRANIUM=$CRANIUM step schedule-real python3 tools/gpu/bench.py "$BUILD" "$OUT/schedule-real-results.json" schedule \
    --real --engine cuda --no-plots --out "$OUT/schedule" ${SCHEDULE:-}
  step schedule-simulated python3 tools/gpu/bench.py "$BUILD" "$OUT/schedule-simulated-results.json" schedule \
    --simulate --no-plots --costs "$OUT/schedule/costs.json" --out "$OUT/schedule" ${SCHEDULE:-}
fi
# Growth of the cost: growth-cuda.json and .csv. GROWTH: options of `./diaphane bench growth`.
if wants growth; then
  DIAPHANE_CRANIUM=$CRANIUM step growth python3 tools/gpu/bench.py "$BUILD" "$OUT/growth.json" growth --engine cuda \
    --out "$OUT" ${GROWTH:-}
  cat "$OUT/growth.log"
fi
cat "$OUT"/*.log > "$OUT/all.log" && rm "$OUT"/{configure,build,unit,gpu,memcheck,racecheck,initcheck,engine,convergence,stability,schedule-real,schedule-simulated,growth}.log 2> /dev/null
exit $failed
