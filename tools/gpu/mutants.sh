#!/usr/bin/env bash
# Runs ./diaphane mutants on a machine that has only a compiler, CMake, Ninja, Protobuf and GoogleTest, for the areas that
# build there. Environment variables:
#   HEADERS  folder with include/{tl,nlohmann,CLI}, if the machine lacks them (tools/gpu/headers.sh)
#   OUT      folder for mutants.json and mutants.log (default: out/)
#   COUNT    number of mutants (default: 300)
#   SEED     seed of the random draw (default: 1)
#   MINUTES  start no more mutants after this time (default: 6)
#   AREAS    areas to draw from (default: "renderer scheduler operator")
set -uo pipefail
cd "$(dirname "$0")/../.."
OUT=${OUT:-$PWD/out}
mkdir -p "$OUT"
areas=()
for area in ${AREAS:-renderer scheduler operator}; do areas+=(--area "$area"); done
options="-DDIAPHANE_API=OFF -DDIAPHANE_RENDERD=OFF -DDIAPHANE_INGEST=OFF -DDIAPHANE_BENCHMARKS=OFF"
if [[ -n ${HEADERS:-} ]]; then options+=" -DCMAKE_INCLUDE_PATH=$(readlink -f "$HEADERS")/include"; fi
PYTHONUNBUFFERED=1 DIAPHANE_MUTANTS_CMAKE="$options" python3 tools/devtool mutants --count "${COUNT:-300}" --seed "${SEED:-1}" \
  --minutes "${MINUTES:-6}" --json "$OUT/mutants.json" "${areas[@]}" ${JOBS:+--jobs "$JOBS"} 2>&1 | tee "$OUT/mutants.log"
