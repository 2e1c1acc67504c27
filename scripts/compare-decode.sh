#!/bin/sh
# Compares `devicenet decode` with tshark on the same recording and on one core: frames a second of processor time and peak
# memory, once as text and once as JSON, both into /dev/null. Processor time, so that what else the machine does counts
# less. The best of three runs counts, tshark's JSON runs once.
#
#   scripts/compare-decode.sh [FRAMES]      default 1000000
#
# Needs tshark, taskset and GNU time.
set -eu
cd "$(dirname "$0")/.."
frames=${1:-1000000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cargo build --quiet --release -p devicenet-cli --bin devicenet --example generate-log
target=${CARGO_TARGET_DIR:-target}/release
"$target/examples/generate-log" --frames "$frames" --seed 1 >"$work/log"

# best RUNS COMMAND...: prints "seconds kilobytes" of the fastest run. Exit code 1 of decode means findings.
best() {
    runs=$1
    shift
    for _ in $(seq "$runs"); do
        taskset -c 0 /usr/bin/time -q -f '%U %S %M' -o "$work/time" "$@" >/dev/null 2>"$work/errors" || [ $? = 1 ]
        awk '{print $1 + $2, $3}' "$work/time"
    done | sort -n | head -n 1
}

row() {
    printf '%-28s %9.2f s %12.0f frames/s %9.1f MiB\n' "$1" "$2" "$(echo "$frames $2" | awk '{print $1 / $2}')" \
        "$(echo "$3" | awk '{print $1 / 1024}')"
}

compare() {
    name=$1
    runs=$2
    ours=$3
    theirs=$4
    # shellcheck disable=SC2086 # the words of a command
    set -- $(best 3 $ours "$work/log") $(best "$runs" $theirs -r "$work/log")
    row "devicenet decode $name" "$1" "$2"
    row "tshark $name" "$3" "$4"
    echo "$1 $3" | awk '{printf "%.1f times as fast\n\n", $2 / $1}'
}

echo "$frames frames, $(nproc) cores, one used; $(tshark --version 2>/dev/null | head -n 1)"
echo
compare text 3 "$target/devicenet decode" "tshark -n -d can.subdissector,devicenet"
compare json 1 "$target/devicenet decode --json" "tshark -n -T json -d can.subdissector,devicenet"
