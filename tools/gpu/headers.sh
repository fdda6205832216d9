#!/usr/bin/env bash
# Copies the header-only libraries that the renderer needs into FOLDER/include, for a machine that lacks them (docs/gpu.md).
set -euo pipefail
folder=${1:?usage: tools/gpu/headers.sh FOLDER}
mkdir -p "$folder/include"
for library in tl nlohmann CLI; do
  cp -rL "/usr/include/$library" "$folder/include/"
done
