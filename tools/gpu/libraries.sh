#!/usr/bin/env bash
# Copies all libraries that the given files load, and strips them. Excludes those of glibc, which must match the loader of
# the machine that runs the programs.
#
#   tools/gpu/libraries.sh FOLDER FILE...
set -euo pipefail
folder=${1:?usage: tools/gpu/libraries.sh FOLDER FILE...}
shift
# ldd fails for a file that is not a program.
{ ldd "$@" 2>/dev/null || true; } | awk '$2 == "=>" && $3 ~ /^\// { print $3 }' | sort -u \
  | grep -vE '/(libc|libm|libdl|librt|libpthread|libresolv|libutil|ld-linux[^/]*)\.so' | while read -r library; do
  strip -o "$folder/$(basename "$library")" "$(readlink -f "$library")" 2>/dev/null \
    || cp -L "$library" "$folder/$(basename "$library")"
done
