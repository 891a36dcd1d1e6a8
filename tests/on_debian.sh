#!/usr/bin/env bash
# Runs ./run.sh, the commands whose pages Python makes, and ./test.sh in a new root directory of a
# Debian release, as on a freshly installed system. The root contains only packages of that release and
# the files of the project. The pages are made before ./test.sh installs the packages of tests.
#
# usage: tests/on_debian.sh 12|13 [ROOT [ARGUMENTS of test.sh...]]
#
# ROOT is the folder for the root directory. A named ROOT is kept and used again; by default the script
# makes a temporary folder and removes it at the end. The packages are downloaded from the package
# source of this system. Requires root privileges, debootstrap, 8 GB of disk space and about an hour
# on two cores.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  printf 'on_debian.sh: %s\n' "$*" >&2
  exit 2
}

case ${1:-} in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) fail "the first argument must be the number of a Debian release, 12 or 13" ;;
esac
shift
[ "$(id -u)" -eq 0 ] || fail "debootstrap and chroot require root privileges; run this script as root"
command -v debootstrap >/dev/null || fail "debootstrap is missing; install it with apt-get install debootstrap"

root=${1:-}
if [ -n "$root" ]; then
  shift
  mkdir -p "$root"
else
  root=$(mktemp -d)
  trap 'rm -rf "$root"' EXIT
fi

# The first Debian package source of this system, in either format of the source lists.
mirror=$({ cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null || true; } |
  sed -nE 's/^(URIs:|deb( \[[^]]*\])?) *([a-z]+:[^ ]*debian\/?)( .*)?$/\3/p' | grep -v security |
  head -1)
[ -n "$mirror" ] || fail "this system has no Debian package source; add one to /etc/apt/sources.list"

if [ ! -x "$root/usr/bin/apt-get" ]; then
  debootstrap --variant=minbase "$suite" "$root" "$mirror"
fi
printf 'deb %s %s main\n' "$mirror" "$suite" >"$root/etc/apt/sources.list"
cp /etc/resolv.conf /etc/hosts "$root/etc/" 2>/dev/null || true
grep -ls Acquire /etc/apt/apt.conf.d/* | xargs -r cp -t "$root/etc/apt/apt.conf.d/"  # proxies

mkdir -p "$root/palpate"
git ls-files -z | tar --null --files-from=- -cf - | tar -C "$root/palpate" -xf -

# Mounts pseudo-terminals, for tests of the output on a terminal, and shared memory.
mounts="mkdir -p /dev/pts /dev/shm && mount -t devpts -o newinstance,ptmxmode=0666 none /dev/pts &&
  ln -sf pts/ptmx /dev/ptmx && mount -t tmpfs none /dev/shm"

# Runs a command inside the root with its own namespaces, so that its mounts and processes end with it.
run_inside() {
  unshare --mount --pid --fork --mount-proc="$root/proc" \
    chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
    bash -c "$mounts && cd /palpate && $1"
}

run_inside "apt-get update -q >/dev/null"
run_inside "./run.sh run models/star.glb --virtual --out /tmp/out"
run_inside "python3 tests/pages_on_debian.py ."
run_inside "./test.sh $*"
