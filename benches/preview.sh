#!/usr/bin/env bash
# The rows of "Preview" in docs/benchmarks.md: what `curved_layers --stage preview` estimates, and how far that is off the full run.
# usage: benches/preview.sh FOLDER_OF_MESHES [MODEL...]      HEIGHT=0.3 BEAD=0.5 VOXELS=60000 MORE="--walls 3 --density 20" (none) unless set
# `jug` is the part that is made in code, with cells as they follow from the layer height. Seconds are user seconds of the preview.
set -euo pipefail
folder=${1:?usage: benches/preview.sh FOLDER_OF_MESHES [MODEL...]}
shift
[ $# -gt 0 ] || set -- bunny-hollow fertility kitten mech-part rocker-arm jug
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
program=${PROGRAM:-${CARGO_TARGET_DIR:-target}/release/examples/curved_layers}
[ -n "${PROGRAM:-}" ] || cargo build --quiet --release --example curved_layers
read -r -a more <<<"${MORE:-}"

figure() { sed -n "s/^ *\"$2\": \([^,]*\),\{0,1\}$/\1/p" "$out/$1/summary.json" | head -n 1; }

# One stage of a run; 3 is a finding, not a failure.
stage() {
  local name=$1 status=0
  shift
  "$program" "$@" --stage "$name" --quiet --out "$out/$name" >/dev/null 2>"$out/errors" || status=$?
  [ "$status" = 0 ] || [ "$status" = 3 ] || { cat "$out/errors" >&2; return 1; }
}

# An estimate as a percentage above the figure of the full run.
off() { awk -v a="$(figure preview "$1")" -v b="$(figure gcode "$2")" 'BEGIN { printf "%+.1f %%", 100 * (a / b - 1) }'; }

echo '| model | surfaces, of all | preview, user seconds | beads, m | volume, cm3 | time, min | curves |'
echo '|---|---|---|---|---|---|---|'
for model in "$@"; do
  args=(--layer-height "${HEIGHT:-0.3}" --bead "${BEAD:-0.5}" --layers-by directed ${more[@]+"${more[@]}"})
  [ "$model" = jug ] || args+=("$folder/$model.stl" --voxels "${VOXELS:-60000}")
  TIMEFORMAT=%U
  { time stage preview "${args[@]}"; } 2>"$out/time"
  stage gcode "${args[@]}"
  awk -v model="$model" -v shown="$(figure preview preview_surfaces)" -v all="$(figure gcode surfaces)" -v seconds="$(tail -n 1 "$out/time")" \
    -v beads="$(figure gcode path_mm)" -v beads_off="$(off estimated_path_mm path_mm)" \
    -v volume="$(figure gcode extruded_mm3)" -v volume_off="$(off estimated_extruded_mm3 extruded_mm3)" \
    -v time="$(figure gcode print_time_s)" -v time_off="$(off estimated_print_time_s print_time_s)" -v curves="$(off estimated_curves curves)" \
    'BEGIN { printf "| %s | %d, %d | %.1f | %.0f: %s | %.2f: %s | %.0f: %s | %s |\n", model, shown, all, seconds, beads / 1000, beads_off, volume / 1000, volume_off, time / 60, time_off, curves }'
done
