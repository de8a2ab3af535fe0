#!/usr/bin/env bash
# The rows of the table in docs/gallery.md: the command that stands below each picture there, run as it is written; wall time in seconds.
# usage: benches/gallery.sh      PROGRAM=FILE and GALLERY=FILE take the place of building curved_layers and gallery
set -euo pipefail
cd "$(dirname "$0")/.."
built=${CARGO_TARGET_DIR:-target}/release/examples
[ -n "${PROGRAM:-}" ] && [ -n "${GALLERY:-}" ] || cargo build --quiet --release --example curved_layers --example gallery
program=$(realpath "${PROGRAM:-$built/curved_layers}")
gallery=$(realpath "${GALLERY:-$built/gallery}")
docs=$PWD/docs/gallery.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$gallery" >/dev/null

echo '| part | volume cm3 | layers | curves | beads m | print time min | missed cells | unsupported mm | unprinted % | warnings / failed | planned in s |'
echo '|---|---|---|---|---|---|---|---|---|---|---|'
sed -n 's/^## //p; s/^cargo run --release --example curved_layers -- //p' "$docs" | while read -r line; do
  case $line in target/*) ;; *) part=$line; continue ;; esac
  status=0
  before=$(date +%s.%N)
  # shellcheck disable=SC2086 # a command line, taken apart at its spaces
  "$program" $line --quiet >said 2>&1 </dev/null || status=$?
  seconds=$(awk -v from="$before" -v to="$(date +%s.%N)" 'BEGIN { print to - from }')
  [ "$status" = 0 ] || [ "$status" = 3 ] || { cat said >&2; exit 1; } # 3 is a finding, not a failure
  python3 - "$part" "$seconds" "${line##*--out }/summary.json" <<'P'
import json, sys

part, seconds, file = sys.argv[1:]
s = json.load(open(file))
print(
    f"| [{part}](#{part.lower().replace(' ', '-')}) | {s['volume_mm3'] / 1e3:.2f} | {s['surfaces']} | {s['curves']} | {s['path_mm'] / 1e3:.1f} "
    f"| {s['print_time_s'] / 60:.0f} | {s['missed_cells']} | {s['unsupported_mm']:.1f} | {100 * (1 - s['filled_share']):.1f} "
    f"| {s['findings_warnings']} / {s['findings_failed']} | {float(seconds):.0f} |"
)
P
done
