#!/usr/bin/env bash
# Creates the pictures of the samples in the window's menu, assets/samples/*.png. MENISCUS is the program
# to use; without it the script builds one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare_pictures
mkdir -p assets/samples
for sample in creature sphere egg ring torus catenoid saddle four-cylinders three-y tube-onto-plane; do
    view=shaded
    case $sample in
    egg | ring) view=colour ;;
    esac
    "$meniscus" sample "$sample" -o "$scratch/$sample.obj" >/dev/null
    "$meniscus" render "$scratch/$sample.obj" -o "assets/samples/$sample.png" --quiet \
        --view "$view" --rims --transparent --size 160x120
done
