#!/usr/bin/env bash
# Installs the packages, builds the tests and runs the suite on all cores, except the tests labelled
# soak: ./test.sh -L soak. Arguments are passed to ctest: -j sets how many tests run at a time; with
# -L, -R or -LE, all tests that these select are run. Finally lists the tests that were not run because
# the machine lacks what they need; with PALPATE_NEEDS=all, these make the script fail.
#
# PRESET=debug ./test.sh uses the debug build. PRESET=asan builds and runs only the tests labelled
# memory, which cover all code that processes files or device input from outside. PRESET=tsan builds
# and runs only the tests labelled rt, which cover all code that uses threads. PRESET=fuzz fuzzes the
# glTF reader for 30 s, and for 15 s each the conversation with a hAPI board, what a page of `view`
# sends, and recordings, in the build of PRESET=asan. PALPATE_FUZZ_SECONDS sets the time of each;
# PALPATE_FUZZ_TARGET selects one, gltf, hapi_link, page or recording; arguments are passed to libFuzzer.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# fuzz TARGET SECONDS ARGUMENT...: fuzzes, beginning with the inputs of earlier runs.
fuzz() {
  local target=$1 seconds=${PALPATE_FUZZ_SECONDS:-$2} build=$palpate_root/build/asan
  shift 2
  say "fuzzing ($target); inputs that fail are saved in $build as crash-..., timeout-... and so on"
  "$build/fuzz_$target" -max_total_time="$seconds" -timeout=5 -artifact_prefix="$build/" \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 "$@"
}
# Starts with the seeds of the project as well.
fuzz_gltf() {
  local build=$palpate_root/build/asan
  "$build/make_fuzz_seeds" "$build/seeds"
  mkdir -p "$build/corpus"
  fuzz gltf 30 -rss_limit_mb=2048 -max_len=16384 -dict="$palpate_root/tests/io/gltf/gltf.dict" \
    "$@" "$build/corpus" "$build/seeds"
}
fuzz_hapi_link() {
  local corpus=$palpate_root/build/asan/corpus_hapi_link
  mkdir -p "$corpus"
  fuzz hapi_link 15 -max_len=1024 "$@" "$corpus"
}
# Starts from an empty corpus: the messages of a page are short.
fuzz_page() {
  local corpus=$palpate_root/build/asan/corpus_page
  mkdir -p "$corpus"
  fuzz page 15 -rss_limit_mb=2048 -max_len=4096 \
    -dict="$palpate_root/tests/engine/viewer/page.dict" "$@" "$corpus"
}

# Makes its recordings itself; the inputs are changes of them.
fuzz_recording() {
  local corpus=$palpate_root/build/asan/corpus_recording
  mkdir -p "$corpus"
  fuzz recording 15 -rss_limit_mb=2048 -max_len=4096 "$@" "$corpus"
}

preset=${PRESET:-release}
if [ "$preset" = fuzz ]; then
  install_missing_packages "${palpate_clang_packages[@]}"
  build_preset asan "${palpate_fuzz_targets[@]}"
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

# What the user selects himself counts.
selects= sets_jobs=${CTEST_PARALLEL_LEVEL:-}
for word in "$@"; do
  case $word in
    -L | -L* | --label-regex* | --label-exclude* | -R* | --tests-regex* | -I* | --tests-information* | \
      --rerun-failed) selects=1 ;;
    -j* | --parallel*) sets_jobs=1 ;;
  esac
done
leaves_out_soak=
case $preset in
  asan)
    install_missing_packages "${palpate_clang_packages[@]}"
    build_preset asan memory_tests
    set -- -L memory "$@"
    ;;
  tsan)
    install_missing_packages
    build_preset tsan rt_tests
    set -- -L ' rt$' "$@"
    ;;
  *)
    install_missing_packages "${palpate_python_test_packages[@]}"
    build_preset "$preset"
    if [ -z "$selects" ]; then
      leaves_out_soak=1
      set -- -LE soak "$@"
    fi
    ;;
esac
if [ -z "$sets_jobs" ]; then set -- -j "$(nproc)" "$@"; fi
if [ -n "$leaves_out_soak" ]; then
  say "running the tests on $(nproc) cores; on two cores, this takes about twelve minutes"
fi
results=$(mktemp)
trap 'rm -f "$results"' EXIT
status=0
ctest --test-dir "$palpate_root/build/$preset" --output-on-failure --output-junit "$results" "$@" ||
  status=$?
if [ -s "$results" ]; then python3 "$palpate_root/tests/summary.py" "$results" || status=1; fi
if [ -n "$leaves_out_soak" ]; then
  say "left out: the tests labelled soak, which run for long: ./test.sh -L soak"
fi
exit "$status"
