# Functions of run.sh, test.sh and .ci/run: install missing Debian packages and build a preset.
# Source this file; it only defines functions and variables.

palpate_root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

palpate_packages=(
  build-essential cmake ninja-build
  libembree-dev libopenmesh-dev libtinygltf-dev libeigen3-dev
  libcli11-dev nlohmann-json3-dev libdraco-dev libmeshoptimizer-dev libpng-dev
  zlib1g-dev libspng-dev libturbojpeg0-dev libsqlite3-dev libzstd-dev
  libgtest-dev libboost-dev libbenchmark-dev libcgal-dev
  gnuplot-nox python3 valgrind
)

palpate_fuzz_packages=(clang libclang-rt-dev)  # only for the preset fuzz

palpate_browser_packages=(chromium fonts-dejavu-core)  # for the test that opens the report

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

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      say "packages are missing: ${missing[*]}; run this script as root, or install sudo"
      return 1
    }
    as_root=(sudo)
  fi
  say "installing ${missing[*]} (a few minutes the first time)"
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    cat "$log" >&2
    say "apt-get could not install ${missing[*]}; see its output above"
    return 1
  fi
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
  say "building $preset (five to ten minutes the first time)"
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
