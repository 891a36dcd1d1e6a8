#!/usr/bin/env bash
# Installs the packages, builds Palpate and runs it with the given arguments. Without arguments, the
# simulated hand explores the model star.glb (palpate run). The command view needs npm, which bundles
# its page; the other commands do not.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
install_missing_packages
if [ "${1:-}" = view ]; then prepare_viewer release; fi
build_preset release palpate palpate_distribution
if (($# == 0)); then
  set -- run "$palpate_root/models/star.glb"
fi
export PALPATE_COMMAND=$0  # the program proposes command lines that begin with it
exec "$palpate_root/build/release/palpate" "$@"
