#!/usr/bin/env bash
# run.sh ENTRY RUNS: fuzzes one entry with the seeds of the repository. Inputs that were found go to corpus/ENTRY, finds to artifacts/any.
set -euo pipefail
cd "$(dirname "$0")"
export RUSTC_BOOTSTRAP=1 CURVLAY_FUZZ=$1 # the stable toolchain takes the flags of cargo fuzz so
python3 seeds.py corpus/seeds
mkdir -p "corpus/$1"
[ -d "corpus/seeds/$1" ] || mkdir -p "corpus/seeds/$1"
exec nice -n 19 cargo fuzz run -s none --fuzz-dir . any "corpus/$1" "corpus/seeds/$1" -- \
  -runs="$2" -timeout=10 -rss_limit_mb=1024 -max_len=20000
