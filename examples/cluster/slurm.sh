#!/bin/sh
# A part in pieces of layers, two or more, by Slurm: docs/cluster.md. sh examples/cluster/slurm.sh part.stl FOLDER PIECES [options of the paths]
# PROGRAM is the program, CELLS what cells there are. Folders must be on a file system that all computers share.
# 3 is the status of a run that is done and found something, such as missed cells: print/report.html says what.
set -eu
mesh=$1 out=$2 pieces=$3
shift 3
program=${PROGRAM:-target/release/examples/curved_layers}
cells=${CELLS:---voxels 100000}
field=$out/field/field.txt
mkdir -p "$out"
# Cells, their order, the even field, and the first piece.
first=$(sbatch --parsable --job-name field --cpus-per-task 4 --output "$out/field-%j.log" \
  --wrap "$program '$mesh' $cells $* --layers 1/$pieces --quiet --threads 4 --out '$out/field' || [ \$? -eq 3 ]")
# One task for each of the others.
pieces_id=$(sbatch --parsable --job-name layers --array "2-$pieces" --cpus-per-task 4 --dependency "afterok:$first" \
  --output "$out/piece-%a-%j.log" \
  --wrap "$program '$mesh' --resume '$field' $* --layers \$SLURM_ARRAY_TASK_ID/$pieces --quiet --threads 4 --out '$out'/piece-\$SLURM_ARRAY_TASK_ID || [ \$? -eq 3 ]")
# All of them in order, and the machine file.
sbatch --job-name print --cpus-per-task 4 --dependency "afterok:$pieces_id" --output "$out/print-%j.log" \
  --wrap "$program '$mesh' --resume '$field' $* --merge '$out/field/paths.jsonl' '$out'/piece-*/paths.jsonl --quiet --threads 4 --out '$out/print' || [ \$? -eq 3 ]"
