#!/usr/bin/env bash
# The rows of "Real settings" in docs/benchmarks.md: whole runs of curved_layers at layers of 0.3 mm and beads of 0.5 mm, a planar slicer beside them.
# usage: benches/figures.sh FOLDER_OF_MESHES [MODEL...]      VOXELS=60000 THREADS=1 ORDER=directed RUNS=1 unless set; ORDER=best tries several
# Times are user seconds, the least of RUNS. The planar slicer is Debian's prusa-slicer: filled solid, beads of 0.5 mm; - where it is not installed.
set -euo pipefail
folder=${1:?usage: benches/figures.sh FOLDER_OF_MESHES [MODEL...]}
shift
[ $# -gt 0 ] || set -- bunny-hollow fertility kitten rocker-arm mech-part
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
program=${PROGRAM:-${CARGO_TARGET_DIR:-target}/release/examples/curved_layers}
[ -n "${PROGRAM:-}" ] || cargo build --quiet --release --example curved_layers

figure() { sed -n "s/^ *\"$1\": \([^,]*\),\{0,1\}$/\1/p" "$out/run/summary.json" | head -n 1; }

# User seconds of a command, the least of RUNS; 3 is a finding, not a failure.
user_seconds() {
  local least=
  for _ in $(seq "${RUNS:-1}"); do
    rm -rf "$out/run"
    local status=0
    TIMEFORMAT=%U
    { time "$@" >/dev/null 2>"$out/errors" || status=$?; } 2>"$out/time"
    if [ "$status" != 0 ] && [ "$status" != 3 ]; then
      cat "$out/errors" >&2
      return 1
    fi
    least=$(printf '%s\n' "$least" "$(tail -n 1 "$out/time")" | grep . | sort -n | head -n 1)
  done
  echo "$least"
}

planar() {
  command -v prusa-slicer >/dev/null || { echo -; return; }
  user_seconds prusa-slicer --export-gcode --layer-height 0.3 --first-layer-height 0.3 --extrusion-width 0.5 \
    --fill-density 100% --fill-pattern rectilinear --output "$out/planar.gcode" "$1"
}

echo '| model | waypoints | user seconds | microseconds a waypoint | gouging waypoints | left out, mm | laid, mm3 | curves | planar slicer, user seconds |'
echo '|---|---|---|---|---|---|---|---|---|'
for model in "$@"; do
  mesh=$folder/$model.stl
  flat=$(planar "$mesh")
  seconds=$(user_seconds "$program" "$mesh" --voxels "${VOXELS:-60000}" --layer-height 0.3 --bead 0.5 --layers-by "${ORDER:-directed}" \
    --threads "${THREADS:-1}" --quiet --out "$out/run")
  waypoints=$(figure waypoints)
  each=$(awk -v s="$seconds" -v n="$waypoints" 'BEGIN { printf "%.0f", 1e6 * s / n }')
  printf '| %s | %s | %.1f | %s | %s | %.0f | %.0f | %s | %s |\n' "$model" "$waypoints" "$seconds" "$each" "$(figure gouging_waypoints)" \
    "$(figure left_out_mm)" "$(figure extruded_mm3)" "$(figure curves)" "$flat"
done
