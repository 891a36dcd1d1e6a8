#!/usr/bin/env bash
# Installs the packages, builds the tests and runs the whole suite. Arguments are passed to ctest.
# PRESET=debug ./test.sh uses the debug build. PRESET=asan builds and runs only the tests labelled
# memory, which cover all code that processes files or device input from outside. PRESET=tsan builds
# and runs only the tests labelled rt, which cover all code that uses threads. PRESET=fuzz fuzzes the
# glTF reader for 30 s, or for PALPATE_FUZZ_SECONDS; arguments are then passed to libFuzzer. It also
# fuzzes what a page of `view` sends, for 15 s or for PALPATE_FUZZ_PAGE_SECONDS.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# Starts fuzzing with the seeds of the project and the corpus of earlier runs.
fuzz_gltf() {
  local build=$palpate_root/build/fuzz
  "$build/make_fuzz_seeds" "$build/seeds"
  mkdir -p "$build/corpus"
  say "fuzzing; inputs that fail are saved in $build as crash-..., timeout-... and so on"
  "$build/fuzz_gltf" -max_total_time="${PALPATE_FUZZ_SECONDS:-30}" -timeout=5 -rss_limit_mb=2048 \
    -max_len=16384 -dict="$palpate_root/tests/io/gltf/gltf.dict" -artifact_prefix="$build/" \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 "$@" "$build/corpus" "$build/seeds"
}

# Fuzzes what a client of `view` sends, from an empty corpus: its messages are short.
fuzz_page() {
  local build=$palpate_root/build/fuzz
  mkdir -p "$build/page_corpus"
  "$build/fuzz_page" -max_total_time="${PALPATE_FUZZ_PAGE_SECONDS:-15}" -timeout=5 -rss_limit_mb=2048 \
    -max_len=4096 -dict="$palpate_root/tests/engine/viewer/page.dict" -artifact_prefix="$build/" \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 "$build/page_corpus"
}

preset=${PRESET:-release}
if [ "$preset" = fuzz ]; then
  install_missing_packages "${palpate_fuzz_packages[@]}"
  build_preset fuzz fuzz_gltf make_fuzz_seeds fuzz_page
  fuzz_gltf "$@"
  fuzz_page
  exit
fi
install_missing_packages
case $preset in
  asan)
    build_preset asan memory_tests
    set -- -L memory "$@"
    ;;
  tsan)
    build_preset tsan rt_tests
    set -- -L ' rt$' "$@"
    ;;
  *) build_preset "$preset" ;;
esac
exec ctest --test-dir "$palpate_root/build/$preset" --output-on-failure "$@"
