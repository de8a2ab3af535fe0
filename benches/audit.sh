#!/usr/bin/env bash
# The rows of "Audit of peers" in docs/benchmarks.md: what audit says of our prints, of a planar slicer's and of published tool paths; and of our layer meshes.
# usage: benches/audit.sh FOLDER_OF_MESHES FOLDER_OF_WAYPOINTS [MODEL...]      AUDIT, PROGRAM: binaries, built in release mode unless set
# Needs the public models and the published waypoints (the folder ../shared of the project; docs/benchmarks.md says which) and Debian's prusa-slicer.
set -euo pipefail
[ $# -ge 2 ] || { echo 'usage: benches/audit.sh FOLDER_OF_MESHES FOLDER_OF_WAYPOINTS [MODEL...]' >&2; exit 2; }
meshes=$1 waypoints=$2
shift 2
[ -d "$meshes" ] && [ -d "$waypoints" ] || { echo "audit.sh: needs $meshes and $waypoints: the folders models and waypoints of ../shared" >&2; exit 2; }
command -v prusa-slicer >/dev/null || { echo 'audit.sh: needs prusa-slicer (apt-get install prusa-slicer)' >&2; exit 2; }
[ $# -gt 0 ] || set -- bunny-hollow fertility
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
binaries=${CARGO_TARGET_DIR:-target}/release/examples
program=${PROGRAM:-$binaries/curved_layers}
audit=${AUDIT:-$binaries/audit}
[ -n "${PROGRAM:-}" ] || cargo build --quiet --release --example curved_layers
[ -n "${AUDIT:-}" ] || cargo build --quiet --release --example audit

figure() { sed -n "s/^ *\"$1\": \"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}$/\1/p" "$out/audit/summary.json" | head -n 1; }
share() { local value; value=$(figure "$1_share"); [ -z "$value" ] && echo absent || awk -v s="$value" 'BEGIN { printf "%.2f %%", 100 * s }'; }

# Runs an audit. 3 is a finding, not a failure.
audited() {
  local status=0
  rm -rf "$out/audit"
  "$audit" "$@" --quiet --out "$out/audit" >/dev/null 2>"$out/errors" || status=$?
  [ "$status" = 0 ] || [ "$status" = 3 ] || { cat "$out/errors" >&2; exit 1; }
}

# A row: name, and the options of its audit.
row() {
  local name=$1 length
  shift
  audited "$@"
  length=$(awk -v mm="$(figure bead_length_mm)" 'BEGIN { printf "%.1f m", mm / 1e3 }')
  echo "| $name | $length | $(share unsupported) | $(share in_air) | $(share gouged) | $(share laid_twice) | $(share uncovered) | $(share outside) | $(figure starts) | $(figure sharp_turns) | $(figure layers) |"
}

echo '| program | beads | unsupported | in the air | gouged | laid twice | uncovered | outside | starts | sharp turns | layers |'
echo '|---|---|---|---|---|---|---|---|---|---|---|'
for model in "$@"; do
  mesh=$meshes/$model.stl
  "$program" "$mesh" --voxels 60000 --layer-height 0.3 --bead 0.5 --layers-by directed --threads 1 --quiet --out "$out/ours" >/dev/null 2>"$out/errors" ||
    [ $? = 3 ] || { cat "$out/errors" >&2; exit 1; }
  row "$model, ours" "$out/ours" --mesh "$mesh"
  prusa-slicer --export-gcode --layer-height 0.3 --first-layer-height 0.3 --nozzle-diameter 0.4 --extrusion-width 0.5 --first-layer-extrusion-width 0.5 \
    --external-perimeter-extrusion-width 0.5 --perimeter-extrusion-width 0.5 --infill-extrusion-width 0.5 --solid-infill-extrusion-width 0.5 \
    --top-infill-extrusion-width 0.5 --fill-density 100% --fill-pattern rectilinear --skirts 0 --output "$out/planar.gcode" "$mesh" >/dev/null 2>&1
  row "$model, PrusaSlicer" "$out/planar.gcode" --mesh "$mesh" --centre
  rm -rf "$out/ours"
done
for path in "$waypoints"/maxis_*.txt; do
  row "$(basename "$path" .txt), published" "$path" --bead 0.8 --layer-height 0.6
done

# Layer meshes: heights of a twentieth, half and all but a twentieth of the area.
echo
echo '| layers | layers | area | heights, mm | tilt of 95 % | unsupported | in the air | gouged | laid twice | uncovered | outside |'
echo '|---|---|---|---|---|---|---|---|---|---|---|'
for model in "$@"; do
  mesh=$meshes/$model.stl
  for by in directed distance hull; do
    "$program" "$mesh" --voxels 60000 --layer-height 0.3 --layers-by "$by" --stage surfaces --threads 1 --quiet --out "$out/ours" >/dev/null 2>"$out/errors" ||
      [ $? = 3 ] || { cat "$out/errors" >&2; exit 1; }
    audited "$out/ours/layers.obj" --mesh "$mesh"
    area=$(awk -v mm2="$(figure layer_area_mm2)" 'BEGIN { printf "%.0f cm2", mm2 / 100 }')
    heights=$(awk -v a="$(figure height_p05_mm)" -v b="$(figure height_median_mm)" -v c="$(figure height_p95_mm)" 'BEGIN { printf "%.2f / %.2f / %.2f", a, b, c }')
    tilt=$(awk -v deg="$(figure tilt_p95_deg)" 'BEGIN { printf "%.0f deg", deg }')
    echo "| $model, $by | $(figure layers) | $area | $heights | $tilt | $(share unsupported) | $(share in_air) | $(share gouged) | $(share laid_twice) | $(share uncovered) | $(share outside) |"
    rm -rf "$out/ours"
  done
done
