#!/usr/bin/env bash
# Packs `./diaphane bench load` for a GPU machine without Diaphane: stripped programs, redis-server, the libraries that a
# minimal Ubuntu or Debian lacks, and a volume (docs/gpu.md).
#
#   tools/gpu/load_bundle.sh BUILD VOLUME FOLDER     here; BUILD contains renderd with CUDA, VOLUME is from the volume store
#   tar c -C FOLDER . | xz > FOLDER.tar.xz           54 MB, because FFmpeg loads many libraries
#   FOLDER/run --sessions 200 --find                 on the GPU machine, with the options of `diaphane-load bench`
set -euo pipefail
build=${1:?usage: tools/gpu/load_bundle.sh BUILD VOLUME FOLDER}
volume=${2:?usage: tools/gpu/load_bundle.sh BUILD VOLUME FOLDER}
folder=${3:?usage: tools/gpu/load_bundle.sh BUILD VOLUME FOLDER}

mkdir -p "$folder/bin" "$folder/lib" "$folder/volume"
rm -f "$folder"/lib/*
for program in "$build/bin/diaphane-renderd" "$build/bin/diaphane-load" "$(command -v redis-server)"; do
  strip -o "$folder/bin/$(basename "$program")" "$(readlink -f "$program")"
done
cp "$volume/volume.json" "$volume/voxels.i16" "$folder/volume/"

# Includes the C++ library, because the one of the GPU machine may be too old for these programs.
"$(dirname "${BASH_SOURCE[0]}")/libraries.sh" "$folder/lib" "$folder"/bin/*

cat > "$folder/run" <<'RUN'
#!/usr/bin/env bash
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
export DIAPHANE_NVRTC="${DIAPHANE_NVRTC:-/usr/local/cuda/lib64}"
export DIAPHANE_KERNEL_CACHE="${DIAPHANE_KERNEL_CACHE:-${TMPDIR:-/tmp}/diaphane-kernels}"
chmod +x "$here"/bin/*
nvidia-smi --query-gpu=name,driver_version,memory.used --format=csv,noheader 2>/dev/null || true
echo "$(nproc) cores, $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1)"
# The library path is set only for these programs, so that the tools of the shell use the machine's
# libraries.
LD_LIBRARY_PATH="$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" exec "$here/bin/diaphane-load" bench --bin-dir "$here/bin" --volume "$here/volume" --engine "${ENGINE:-cuda}" "$@"
RUN
chmod +x "$folder/run"
du -sh "$folder" | cut -f 1
