#!/usr/bin/env bash
# Builds the release preset, runs the benchmarks and keeps the result under the name of this
# processor; update_results.py then updates the pages of docs and README.md. Arguments are passed to
# palpate_benchmarks. By default it measures spheres of 20 thousand to 5.2 million triangles and the
# cost of accuracy, in a minute or two and 3 GB of memory; --subdivisions=5,7 --accuracy=quick is
# shorter. Measure on an idle machine: other programs change the times.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../setup.sh"
install_missing_packages
build_preset release palpate palpate_benchmarks write_contour_angles work_prices

cpu_field() { sed -n "s/^$1[[:space:]]*: //p" /proc/cpuinfo | head -n 1; }

# Google Benchmark splits its context at commas and equals signs.
cpu=$(cpu_field 'model name' | tr ',=' '  ' | tr -s ' ')
cpu="${cpu:-$(uname -m)} (family $(cpu_field 'cpu family') model $(cpu_field model))"
slug=$(printf '%s' "$cpu" | tr '[:upper:]' '[:lower:]' | tr -cs 'a-z0-9' '-' | sed 's/^-//; s/-$//')

# A change of these files marks the commit as modified: they can change a time. Results and documents
# cannot.
sources=(CMakeLists.txt CMakePresets.json engine geometry haptics io models benchmarks
  ':!benchmarks/results' ':!*.md' ':!*.sh' ':!*.py')
commit=$(git -C "$palpate_root" rev-parse --short=12 HEAD 2>/dev/null || echo unknown)
if [ -n "$(git -C "$palpate_root" status --porcelain -- "${sources[@]}" 2>/dev/null)" ]; then
  commit+=-modified
fi

result=$palpate_root/benchmarks/results/$slug.json
fresh=$(mktemp)
trap 'rm -f "$fresh"' EXIT
say "measuring for $slug (a minute or two)"
cd "$palpate_root/build/release"
./palpate_benchmarks --benchmark_out="$fresh" --benchmark_out_format=json \
  --benchmark_context="cpu=$cpu,commit=$commit" "$@"
if grep -q '"error_occurred": true' "$fresh"; then
  say "a benchmark failed, so no result was kept; its message is above"
  exit 1
fi
mkdir -p "$palpate_root/benchmarks/results/work"
./work_prices --csv="$palpate_root/benchmarks/results/work/$slug.csv" --cpu="$cpu"
# The host's name does not affect a time and is private.
mkdir -p "${result%/*}"
grep -v '"host_name":' "$fresh" >"$result"
"$palpate_root/benchmarks/measure_objects.py" "$palpate_root/build/release/palpate"
"$palpate_root/benchmarks/measure_contour_angles.py" "$palpate_root/build/release/write_contour_angles"
say "wrote benchmarks/results/$slug.json; run benchmarks/update_results.py to update docs and README.md"
