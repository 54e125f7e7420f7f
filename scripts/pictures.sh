#!/usr/bin/env bash
# Creates the pictures of the README, except that of the window, with the program itself.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare_pictures
"$meniscus" sample creature -o "$scratch/creature.obj"
"$meniscus" fill "$scratch/creature.obj" -o "$scratch/filled.obj" --quiet \
    --picture docs/pictures/filled.png --size 640x480
"$meniscus" render "$scratch/creature.obj" -o docs/pictures/holed.png --size 640x480 --view shaded --rims
"$meniscus" render "$scratch/filled.obj" -o docs/pictures/curvature.png --size 640x480 --view H
