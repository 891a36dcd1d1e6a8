#!/usr/bin/env bash
# Installs the packages, builds the tests and runs the whole suite. Arguments are passed to ctest.
# PRESET=debug ./test.sh uses the debug build. PRESET=asan builds and runs only the tests labelled
# memory, which cover all code that processes files or device input from outside. PRESET=tsan builds
# and runs only the tests labelled rt, which cover all code that uses threads. PRESET=fuzz fuzzes the
# glTF reader for 30 s, and for 15 s each the conversation with a hAPI board, what a page of `view`
# sends, and recordings. PALPATE_FUZZ_SECONDS sets the time of each; PALPATE_FUZZ_TARGET selects one,
# gltf, hapi_link, page or recording; arguments are passed to libFuzzer.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# fuzz TARGET SECONDS ARGUMENT...: fuzzes, beginning with the inputs of earlier runs.
fuzz() {
  local target=$1 seconds=${PALPATE_FUZZ_SECONDS:-$2} build=$palpate_root/build/fuzz
  shift 2
  say "fuzzing ($target); inputs that fail are saved in $build as crash-..., timeout-... and so on"
  "$build/fuzz_$target" -max_total_time="$seconds" -timeout=5 -artifact_prefix="$build/" \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 "$@"
}
# Starts with the seeds of the project as well.
fuzz_gltf() {
  local build=$palpate_root/build/fuzz
  "$build/make_fuzz_seeds" "$build/seeds"
  mkdir -p "$build/corpus"
  fuzz gltf 30 -rss_limit_mb=2048 -max_len=16384 -dict="$palpate_root/tests/io/gltf/gltf.dict" \
    "$@" "$build/corpus" "$build/seeds"
}
fuzz_hapi_link() {
  local corpus=$palpate_root/build/fuzz/corpus_hapi_link
  mkdir -p "$corpus"
  fuzz hapi_link 15 -max_len=1024 "$@" "$corpus"
}
# Starts from an empty corpus: the messages of a page are short.
fuzz_page() {
  local corpus=$palpate_root/build/fuzz/corpus_page
  mkdir -p "$corpus"
  fuzz page 15 -rss_limit_mb=2048 -max_len=4096 \
    -dict="$palpate_root/tests/engine/viewer/page.dict" "$@" "$corpus"
}

# Makes its recordings itself; the inputs are changes of them.
fuzz_recording() {
  local corpus=$palpate_root/build/fuzz/corpus_recording
  mkdir -p "$corpus"
  fuzz recording 15 -rss_limit_mb=2048 -max_len=4096 "$@" "$corpus"
}

preset=${PRESET:-release}
if [ "$preset" = fuzz ]; then
  install_missing_packages "${palpate_fuzz_packages[@]}"
  build_preset fuzz "${palpate_fuzz_targets[@]}"
  if [ -n "${PALPATE_FUZZ_TARGET:-}" ]; then
    "fuzz_$PALPATE_FUZZ_TARGET" "$@"
    exit
  fi
  fuzz_gltf "$@" &  # beside the others, on a core of its own
  beside=$! status=0
  for target in hapi_link page recording; do "fuzz_$target" "$@" || status=$?; done
  wait "$beside" || status=$?
  exit "$status"
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
