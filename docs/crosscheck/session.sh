#!/usr/bin/env bash
# What a machine with a GPU is asked, the harmless first, in under 12 minutes: every step has a limit of its own, and the
# limits add up to 680 seconds. A report is whole at every moment: whatever happens, what was found until then is there.
#
#   docs/crosscheck/session.sh OUT [ADAPTER]
#
# OUT: a folder for the reports. ADAPTER: part of the adapter's name [default: all adapters]. FRAGLOOM: the binary
# [default: it is built]. LAYERS: fragments per pixel of the large scene [default: 130: 1.09e9 fragments per path over
# the eight methods that must be equal].
set -uo pipefail
cd "$(dirname "$0")/../.."
out=${1:?a folder for the reports}
adapter=${2:+--adapter "$2"}
layers=${LAYERS:-130}
mkdir -p "$out"
if [ -z "${FRAGLOOM:-}" ]; then
    cargo build --release --locked || exit 2
    FRAGLOOM=target/release/fragloom
fi
began=$SECONDS

# A step: its name, its limit in seconds, and the command.
step() {
    local name=$1 limit=$2
    shift 2
    printf '== %s, %s s after the start\n' "$name" $((SECONDS - began))
    timeout -k 5 "$limit" "$FRAGLOOM" "$@" >"$out/$name.txt" 2>&1
    printf 'exit code %s\n' $? | tee -a "$out/$name.txt"
}

same=z-buffer,ab-array,ab-ll,s-buffer,dfb,kb-mdt64,ha64,ha32
waits=kplus-array,kplus-heap,kplus-sb,kb-ll,ab-ll-paged,k-variable
mended=kplus-array@word64
for method in kplus-array kplus-heap kplus-sb kb-ll ab-ll-paged; do
    mended=$mended,$method@atomic,$method@rmw
done

step adapters 60 adapters
# shellcheck disable=SC2086
{
    step same-small 60 crosscheck --quick $adapter -m $same --limit 20 --report "$out/same-small.jsonl"
    step same-large 200 crosscheck "layers:count=$layers" --size 1024x1024 $adapter -m $same --limit 20 \
        --report "$out/same-large.jsonl"
    step may-differ 60 crosscheck --quick --path compute $adapter -m kb,kb-mdt32,$waits --limit 20 \
        --report "$out/may-differ.jsonl"
    step mended 60 crosscheck --quick --path compute $adapter -m $mended --limit 20 --report "$out/mended.jsonl"
    step vulkan 60 crosscheck --quick --path compute $adapter --form vulkan -m $waits --limit 20 \
        --report "$out/vulkan.jsonl"
    step litmus 90 crosscheck --litmus --repeats 1 $adapter -m kb,$same,$waits,$mended
    # What hung on an H200: locks in fragment shaders. Last, and one picture at a time.
    step raster-kb 30 crosscheck --quick --path raster $adapter -m kb,kb-mdt32 --limit 10 \
        --report "$out/raster-kb.jsonl"
    step raster-locks 60 crosscheck --quick --path raster $adapter -m $waits --limit 10 \
        --report "$out/raster-locks.jsonl"
}
printf 'done, %s s after the start\n' $((SECONDS - began))
