#!/usr/bin/env bash
# Packs all programs of Diaphane, Postgres, Redis, nginx and `./diaphane bench` for a GPU machine without them
# (docs/gpu.md).
#
#   tools/gpu/stack_bundle.sh BUILD FOLDER    here; BUILD contains all programs and renderd with CUDA, and the page is built
#   tar c -C FOLDER . | xz -T0 > FOLDER.tar.xz
#   FOLDER/bench abuse                        on the GPU machine, as root in a disposable container, because it writes below /usr
set -euo pipefail
build=${1:?usage: tools/gpu/stack_bundle.sh BUILD FOLDER}
folder=${2:?usage: tools/gpu/stack_bundle.sh BUILD FOLDER}
repo=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
packages=$repo/.tools/venv/lib/python3.11/site-packages

rm -rf "$folder"
venv=$folder/app/.tools/venv
mkdir -p "$folder"/{root,lib,app/build/bin,app/frontend} "$venv"/{bin,lib/python3.11/site-packages}
git -C "$repo" archive HEAD api/edge api/proto migrations tools/devtool tests/scenes | tar x -C "$folder/app"
cp -r "$repo/frontend/dist" "$folder/app/frontend/"
for program in api gateway ingestd renderd sample; do
  strip -o "$folder/app/build/bin/diaphane-$program" "$build/bin/diaphane-$program"
done

# Files that the programs expect below /usr. Includes Python and its libraries, because the bench needs this version.
(cd / && tar ch --exclude=__pycache__ --exclude='llvmjit*' --exclude=bitcode --exclude=pgxs --exclude=test --exclude=config-3.11-* \
  usr/lib/postgresql/15/{bin/{postgres,initdb,psql,pg_isready},lib} usr/share/postgresql/15 usr/share/postgresql-common usr/sbin/nginx \
  usr/lib/nginx/modules/{ndk_http_module,ngx_http_lua_module}.so usr/share/lua usr/bin/redis-server \
  usr/bin/python3.11 usr/lib/python3.11 usr/share/doc/invesalius-examples/examples/Cranium.inv3) | tar x -C "$folder/root"
for name in httpx httpcore h11 anyio sniffio certifi idna websockets google typing_extensions.py; do
  [[ ! -e $packages/$name ]] || cp -r "$packages/$name" "$venv/lib/python3.11/site-packages/"
done
echo 'home = /usr/bin' > "$venv/pyvenv.cfg"
ln -s /usr/bin/python3.11 "$venv/bin/python"
find "$folder" -name __pycache__ -prune -exec rm -rf {} +

find "$folder"/app/build "$folder"/root "$venv" -type f \( -perm -u+x -o -name '*.so*' \) -print0 \
  | xargs -0 "$repo/tools/gpu/libraries.sh" "$folder/lib"
# Excludes the C++ library, because protoc of the GPU machine needs one that is as new as the compiler there.
rm -f "$folder"/lib/{libstdc++,libgcc_s}.so*

cat > "$folder/bench" <<'BENCH'
#!/usr/bin/env bash
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cp -a --update=none "$here/root/." /
# The libraries are appended to the search path, for programs that start with an empty environment.
echo "$here/lib" > /etc/ld.so.conf.d/zz-diaphane.conf
ldconfig
mkdir -p /var/lib/nginx /var/log/nginx
export DIAPHANE_BUILD=$here/app/build PYTHONDONTWRITEBYTECODE=1
export DIAPHANE_NVRTC="${DIAPHANE_NVRTC:-/usr/local/cuda/lib64}"
nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null || true
echo "$(nproc) cores, $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1)"
# The library path is set only for these programs, so that the tools of the shell use the machine's
# libraries.
export LD_LIBRARY_PATH="$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
exec "$here/app/.tools/venv/bin/python" "$here/app/tools/devtool" bench "$@"
BENCH
chmod +x "$folder/bench"
du -sh "$folder" | cut -f 1
