#!/bin/sh
# Runs one shard of an experiment or of a sweep as one task of a Slurm array:
#
#   sbatch --array=1-20 engine/trials/deal/slurm_array.sh run plan.json results
#   sbatch --array=1-20 engine/trials/deal/slurm_array.sh sweep sweep.json results
#
# slurm_array.sh run|sweep FILE FOLDER [OPTION...]: task i of n runs `palpate experiment run FILE
# --shard i/n`, or `sweep`, with the results in FOLDER/shard-i. OPTION: passed on to palpate.
# When all tasks have ended, join their results:
#
#   ./run.sh experiment merge results/shard-* --out results
#
# If tasks were killed, submit the whole array again: it computes what is missing. PALPATE: the program;
# a path, or a name that is found on PATH; by default build/release/palpate in the folder from which
# the array was submitted. Without Slurm, set SLURM_ARRAY_TASK_ID (1 to n) and SLURM_ARRAY_TASK_COUNT
# (n). The array must count from 1 to n in steps of 1, because a task that does not exist would leave
# its shard out. FILE may be the name of what ships: paper or canonical for run, sweep for sweep.

#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1

set -eu

fail() {
  printf 'slurm_array.sh: %s\n' "$1" >&2
  exit 2
}

# The value of a number that is set by Slurm: 1 or more, with at most 9 digits, so that sh can compare
# it.
is_count() {
  case $1 in
    '' | 0* | *[!0-9]* | ??????????*) return 1 ;;
    *) return 0 ;;
  esac
}

[ $# -ge 3 ] || fail 'has too few arguments; expected run|sweep FILE FOLDER [OPTION...]'
command=$1
file=$2
folder=$3
shift 3

case $command in
  run | sweep) ;;
  *) fail "is asked for \"$command\"; expected run or sweep" ;;
esac
case $folder in
  '' | -*) fail "has the folder \"$folder\"; expected a name that does not begin with -" ;;
esac
is_shipped=no
case $command/$file in
  run/paper | run/canonical | sweep/sweep) is_shipped=yes ;;
  run/sweep) fail 'is asked to run "sweep", which is a sweep; expected sweep sweep' ;;
  sweep/paper | sweep/canonical) fail "is asked to sweep \"$file\", which is a plan; expected run $file" ;;
esac
[ "$is_shipped" = yes ] || [ -f "$file" ] ||
  fail "finds no file \"$file\"; expected a plan or a sweep (palpate experiment plan writes one)"

task=${SLURM_ARRAY_TASK_ID:-}
count=${SLURM_ARRAY_TASK_COUNT:-}
is_count "$task" ||
  fail "has SLURM_ARRAY_TASK_ID \"$task\"; expected a number from 1 (sbatch --array=1-n sets it)"
is_count "$count" ||
  fail "has SLURM_ARRAY_TASK_COUNT \"$count\"; expected a number from 1 (sbatch --array=1-n sets it)"
[ "$task" -le "$count" ] ||
  fail "is task $task of $count; expected an array that counts from 1 in steps of 1 (--array=1-$count)"

[ "${SLURM_ARRAY_TASK_MIN:-1}" = 1 ] ||
  fail "is of an array from $SLURM_ARRAY_TASK_MIN; expected --array=1-$count"
[ "${SLURM_ARRAY_TASK_MAX:-$count}" = "$count" ] ||
  fail "is of an array of $count tasks to $SLURM_ARRAY_TASK_MAX; expected --array=1-$count"

palpate=${PALPATE:-${SLURM_SUBMIT_DIR:-.}/build/release/palpate}
command -v "$palpate" > /dev/null || fail "finds no program \"$palpate\"; build it, or set PALPATE"

exec "$palpate" experiment "$command" "$file" --shard "$task/$count" \
  --out "$folder/shard-$task" "$@"
