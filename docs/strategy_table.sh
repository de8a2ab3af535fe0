#!/usr/bin/env bash
# Every strategy on every mesh of a folder, as a Markdown table: missed cells / layers / share in small patches / seconds.
# usage: docs/strategy_table.sh FOLDER [EPS...]       VOXELS=100000 unless set; one thread
set -euo pipefail
folder=$1
shift
[ $# -gt 0 ] || set -- 0.5 1 2
strategies="greedy incremental adaptive governed unbuild"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cargo build --quiet --release --example curved_layers
figure() { sed -n "s/^ *\"$1\": \([^,]*\),\{0,1\}$/\1/p" "$out/summary.json"; }
for eps in "$@"; do
  printf '\n**eps %s**\n\n| model |' "$eps"
  for strategy in $strategies; do printf ' %s |' "$strategy"; done
  printf '\n|---|'
  for strategy in $strategies; do printf -- '---|'; done
  echo
  for mesh in "$folder"/*.stl; do
    printf '| %s |' "$(basename "$mesh" .stl)"
    for strategy in $strategies; do
      if "${CARGO_TARGET_DIR:-target}/release/examples/curved_layers" --quiet --stage field --mesh "$mesh" \
        --voxels "${VOXELS:-100000}" --threads 1 --eps "$eps" --strategy "$strategy" --allow-missed 1 --out "$out" >/dev/null 2>&1; then
        printf ' %s / %s / %.1f %% / %.2f |' "$(figure missed_cells)" "$(figure cell_layers)" \
          "$(figure small_patch_share | awk '{ print 100 * $1 }')" "$(figure grow_s)"
      else
        printf ' failed |'
      fi
    done
    echo
  done
done
