#!/usr/bin/env bash
# Installs, builds and runs the whole test suite; arguments go to ctest.
# PRESET=debug ./test.sh runs it on another build. PRESET=asan builds and runs the tests of what files
# and hands from outside reach (label memory), PRESET=tsan those of threads (rt): nothing else has such
# errors to find. PRESET=fuzz fuzzes the glTF reader for 30 s, or for PALPATE_FUZZ_SECONDS; arguments
# go to libFuzzer.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# Fuzzes from the seeds that the project makes and from what earlier runs have found to be new.
fuzz_gltf() {
  local build=$palpate_root/build/fuzz
  "$build/make_fuzz_seeds" "$build/seeds"
  mkdir -p "$build/corpus"
  say "fuzzing; what is found is kept as $build/crash-..., and so on"
  "$build/fuzz_gltf" -max_total_time="${PALPATE_FUZZ_SECONDS:-30}" -timeout=5 -rss_limit_mb=2048 \
    -max_len=16384 -dict="$palpate_root/tests/io/gltf/gltf.dict" -artifact_prefix="$build/" \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 "$@" "$build/corpus" "$build/seeds"
}

preset=${PRESET:-release}
if [ "$preset" = fuzz ]; then
  install_missing_packages "${palpate_fuzz_packages[@]}"
  build_preset fuzz fuzz_gltf make_fuzz_seeds
  fuzz_gltf "$@"
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
