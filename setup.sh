# Functions of run.sh, test.sh and .ci/run: install missing Debian packages and build a preset.
# Source this file; it only defines functions and variables.

palpate_root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

palpate_packages=(
  build-essential cmake ninja-build
  libembree-dev libopenmesh-dev libtinygltf-dev libeigen3-dev
  libcli11-dev nlohmann-json3-dev libdraco-dev libmeshoptimizer-dev libpng-dev
  zlib1g-dev libspng-dev libturbojpeg0-dev libsqlite3-dev libzstd-dev
  libgtest-dev libboost-dev libbenchmark-dev libcgal-dev
  python3 valgrind
  python3-numpy python3-scipy python3-pandas python3-statsmodels python3-matplotlib python3-jinja2  # pages
)

palpate_python_test_packages=(python3-pytest mypy)  # for the tests of engine/python

palpate_clang_packages=(clang libclang-rt-dev)  # only for the preset asan
palpate_fuzz_targets=(fuzz_gltf fuzz_hapi_link fuzz_page fuzz_recording make_fuzz_seeds)

palpate_browser_packages=(
  chromium fonts-dejavu-core  # for tests that open reports and pages
  xvfb evilwm xdotool  # a desktop with a mouse, for those of full screen and pointer lock
)

palpate_site_packages=(python3-sphinx python3-myst-parser furo)  # for docs/build.sh and its tests

palpate_format_packages=(python3-zstandard python3-yaml python3-jsonschema)  # for FORMAT.md, CITATION.cff, exports

say() { printf 'palpate: %s\n' "$*" >&2; }

# install_missing_packages [PACKAGE...]: installs the packages of Palpate and the named packages.
# Prints nothing and returns at once if all packages are installed.
install_missing_packages() {
  local missing=() package
  for package in "${palpate_packages[@]}" "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
      missing+=("$package")
  done
  ((${#missing[@]})) || return 0
  install_packages "${missing[@]}"
}

# install_packages PACKAGE...: installs the Debian packages, without recommended ones.
install_packages() {
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      say "packages are missing: $*; run this script as root, or install sudo"
      return 1
    }
    as_root=(sudo)
  fi
  say "installing $* (a few minutes the first time)"
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends "$@"; } >"$log" 2>&1; then
    cat "$log" >&2
    say "apt-get could not install $*; see its output above"
    return 1
  fi
  rm -f "$log"
}

# need_npm: installs the command npm if it is missing. The command is asked for and not the package:
# where Node came with an npm of its own, Debian's package conflicts with it.
need_npm() {
  command -v npm >/dev/null && return 0
  say "npm is missing: installing Debian's, which has 355 packages with Node and takes some minutes"
  install_packages npm
}

# fetch_packages NAME FOLDER: fetches the npm packages that the project's FOLDER names, into
# build/NAME. Returns at once if they are there. Scripts of packages are not run.
fetch_packages() {
  local target=$palpate_root/build/$1 source=$palpate_root/$2 log
  if [ -e "$target/node_modules/.package-lock.json" ] &&
    cmp -s "$source/package-lock.json" "$target/package-lock.json"; then
    return 0
  fi
  need_npm || return 1
  say "fetching the packages of $2 (up to a minute)"
  rm -rf "$target"
  mkdir -p "$target"
  cp "$source/package.json" "$source/package-lock.json" "$source/.npmrc" "$target"
  log=$(mktemp)
  if ! (cd "$target" && npm ci --ignore-scripts --no-audit --no-fund --no-update-notifier) \
    >"$log" 2>&1; then
    cat "$log" >&2
    rm -rf "$log" "$target"
    say "npm could not fetch the packages of $2; see its output above"
    return 1
  fi
  rm -f "$log"
}

# prepare_viewer PRESET: fetches what the page of `palpate view` is bundled from, and configures the
# preset with it.
prepare_viewer() {
  local build=$palpate_root/build/$1
  fetch_packages page_packages engine/viewer/page || return 1
  if [ "$build/build.ninja" -nt "$palpate_root/build/page_packages/node_modules" ] &&
    grep -q '^PALPATE_VIEWER:STRING=AUTO$' "$build/CMakeCache.txt"; then
    return 0
  fi
  say "configuring $1 with the viewer"
  local log
  log=$(mktemp)
  (cd "$palpate_root" && cmake --preset "$1" -DPALPATE_VIEWER:STRING=AUTO) >"$log" 2>&1 || {
    cat "$log" >&2
    rm -f "$log"
    return 1
  }
  rm -f "$log"
}

palpate_progress_s=60  # the shortest time between two lines of progress

# report_progress TASK LOG: copies the output of ninja from stdin to the file LOG. From time to time
# it prints how many of ninja's steps are done. Requires NINJA_STATUS='[%f/%t] '.
report_progress() {
  local task=$1 log=$2 line last_s=$SECONDS
  local status='^\[([0-9]+)/([0-9]+)\] '
  while IFS= read -r line || [ -n "$line" ]; do
    printf '%s\n' "$line"
    if ((SECONDS - last_s >= palpate_progress_s)) && [[ $line =~ $status ]]; then
      say "$task: ${BASH_REMATCH[1]} of ${BASH_REMATCH[2]} files"
      last_s=$SECONDS
    fi
  done >"$log"
}

# build_preset PRESET [TARGET...]: configures the preset if it is not configured or if the presets
# have changed since, then builds the targets. On a terminal it shows the progress of the build;
# otherwise it prints a line of progress at most once a minute, and the output of a failed build.
build_preset() {
  local preset=$1 build=$palpate_root/build/$1
  shift
  if [ ! "$build/build.ninja" -nt "$palpate_root/CMakePresets.json" ]; then
    say "configuring $preset"
    (cd "$palpate_root" && cmake --preset "$preset" >"$palpate_root/.configure.log" 2>&1) || {
      cat "$palpate_root/.configure.log" >&2
      rm -f "$palpate_root/.configure.log"
      return 1
    }
    rm -f "$palpate_root/.configure.log"
  fi
  local target_flags=()
  if (($#)); then target_flags=(--target "$@"); fi
  if cmake --build "$build" "${target_flags[@]}" -- -n 2>/dev/null | grep -q 'no work to do'; then
    return 0
  fi
  # Ninja alone starts two compilers more than cores, which takes 5 % more time of the cores.
  local -x CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
  say "building $preset (up to half an hour on two cores the first time)"
  if [ -t 2 ]; then  # ninja shows its progress in one line, and prints errors
    cmake --build "$build" "${target_flags[@]}" >&2
    return
  fi
  local log
  log=$(mktemp)
  if ! (
    set -o pipefail
    NINJA_STATUS='[%f/%t] ' cmake --build "$build" "${target_flags[@]}" 2>&1 |
      report_progress "building $preset" "$log"
  ); then
    cat "$log" >&2
    rm -f "$log"
    return 1
  fi
  rm -f "$log"
}
