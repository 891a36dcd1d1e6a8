#!/usr/bin/env bash
# Installs, builds and runs the whole test suite; arguments go to ctest.
# PRESET=asan ./test.sh (or debug) runs it on another build. PRESET=tsan builds and runs the tests
# of threads only: nothing else has a race to find.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
preset=${PRESET:-release}
install_missing_packages
if [ "$preset" = tsan ]; then
  build_preset tsan rt_tests
  set -- -L rt "$@"
else
  build_preset "$preset"
fi
exec ctest --test-dir "$palpate_root/build/$preset" --output-on-failure "$@"
