#!/bin/sh
# A compiler for ccache that checks a file *.cpp with clang-tidy instead of compiling it (tidy.py). All paths are relative to
# build/PRESET, so that checkouts share results.
set -eu
if [ -n "${DIAPHANE_ONLY_CACHED-}" ]; then exit 1; fi
config="$(dirname "$0")/../../.clang-tidy"
for word; do
  if [ "${before-}" = -o ]; then object="$word"; fi
  case "$word" in *.cpp) file="$word" ;; esac
  before="$word"
done
clang-tidy --quiet --config-file="$config" --header-filter='^(\.\./)+(api|common|directory|ingest|operator|renderd|volume)/' \
  --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-ignored-optimization-argument "$file" -- "$@"
clang++-14 -w "$@" -M    # tells ccache which headers were read
echo passed > "$object"    # ccache keeps no empty file
