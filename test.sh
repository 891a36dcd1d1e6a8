#!/usr/bin/env bash
# Installs, builds and runs the whole test suite; arguments go to ctest.
# PRESET=asan ./test.sh (or tsan, debug) runs it on another build.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
preset=${PRESET:-release}
install_missing_packages
build_preset "$preset"
exec ctest --test-dir "$palpate_root/build/$preset" --output-on-failure "$@"
