#!/usr/bin/env bash
# Builds the site from the texts of this folder into build/site: docs/build.sh
# The first run installs Sphinx, MyST and furo. A warning, for example of a link that leads nowhere, is an error.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../setup.sh"

site=$palpate_root/build/site
(
  palpate_packages=()  # the site needs none of the program
  install_missing_packages "${palpate_site_packages[@]}"
)
mkdir -p "$palpate_root/build"
# -E: an included text that is new may change the links of every page.
sphinx-build -E -W --keep-going -n -q -b html -d "$palpate_root/build/site.cache" "$palpate_root/docs" "$site"
say "open $site/index.html"
