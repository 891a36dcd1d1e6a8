#!/usr/bin/env bash
# Runs ./run.sh and ./test.sh in an empty root of a Debian release, as somebody does who has just
# installed it: nothing of this system is there but the project's own files.
#
# usage: tests/on_debian.sh 12|13 [ROOT [ARGUMENTS of test.sh...]]
#
# ROOT is where the root is made (a new temporary folder by default, which goes with the script; a ROOT
# that is named stays, and is used again). The packages come from where this system takes its own.
# Needs root, debootstrap, 8 GB and about an hour on two cores.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  printf 'on_debian.sh: %s\n' "$*" >&2
  exit 2
}

case ${1:-} in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) fail "expected the number of a release, 12 or 13" ;;
esac
shift
[ "$(id -u)" -eq 0 ] || fail "needs to be root: debootstrap and chroot do"
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"

root=${1:-}
if [ -n "$root" ]; then
  shift
  mkdir -p "$root"
else
  root=$(mktemp -d)
  trap 'rm -rf "$root"' EXIT
fi

# The first package source of this system that is Debian's, in either form of the lists.
mirror=$({ cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null || true; } |
  sed -nE 's/^(URIs:|deb( \[[^]]*\])?) *([a-z]+:[^ ]*debian\/?)( .*)?$/\3/p' | grep -v security |
  head -1)
[ -n "$mirror" ] || fail "this system has no package source of Debian's"

if [ ! -x "$root/usr/bin/apt-get" ]; then
  debootstrap --variant=minbase "$suite" "$root" "$mirror"
fi
printf 'deb %s %s main\n' "$mirror" "$suite" >"$root/etc/apt/sources.list"
cp /etc/resolv.conf /etc/hosts "$root/etc/" 2>/dev/null || true
grep -ls Acquire /etc/apt/apt.conf.d/* | xargs -r cp -t "$root/etc/apt/apt.conf.d/"  # how to get there

mkdir -p "$root/palpate"
git ls-files -z | tar --null --files-from=- -cf - | tar -C "$root/palpate" -xf -

# Pseudo-terminals, for the tests of what a terminal shows, and shared memory.
mounts="mkdir -p /dev/pts /dev/shm && mount -t devpts -o newinstance,ptmxmode=0666 none /dev/pts &&
  ln -sf pts/ptmx /dev/ptmx && mount -t tmpfs none /dev/shm"

# With namespaces of its own, so that what it mounts and starts ends with it.
run_inside() {
  unshare --mount --pid --fork --mount-proc="$root/proc" \
    chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
    bash -c "$mounts && cd /palpate && $1"
}

run_inside "apt-get update -q >/dev/null"
run_inside "./run.sh run models/star.glb --virtual --out /tmp/out"
run_inside "./test.sh $*"
