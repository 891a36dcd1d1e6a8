#!/usr/bin/env bash
# Installs, builds and runs Palpate. Without arguments: the main job on the star.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
install_missing_packages
build_preset release palpate
if (($# == 0)); then
  set -- run "$palpate_root/models/star.glb"
fi
exec "$palpate_root/build/release/palpate" "$@"
