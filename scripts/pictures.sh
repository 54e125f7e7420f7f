#!/usr/bin/env bash
# Creates the pictures of the README, except that of the window, and those of docs/real.md with the
# program itself. MENISCUS is the program to use; without it the script builds one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare_pictures
"$meniscus" sample creature -o "$scratch/creature.obj"
"$meniscus" fill "$scratch/creature.obj" -o "$scratch/filled.obj" --quiet \
    --picture docs/pictures/filled.png --size 640x480 --view isophotes
"$meniscus" render "$scratch/creature.obj" -o docs/pictures/holed.png --size 640x480 --view shaded --rims
"$meniscus" render "$scratch/filled.obj" -o docs/pictures/curvature.png --size 640x480 --view H
for sample in egg ring; do
    look=(--view colour --size 320x240)
    "$meniscus" sample "$sample" -o "$scratch/$sample.obj"
    "$meniscus" fill "$scratch/$sample.obj" -o "$scratch/filled.obj" --quiet
    "$meniscus" render "$scratch/$sample.obj" -o "docs/pictures/$sample-before.png" --rims "${look[@]}"
    "$meniscus" render "$scratch/filled.obj" -o "docs/pictures/$sample-after.png" "${look[@]}"
done

# The pictures of docs/real.md need the scans: MENISCUS_MODELS is the folder of the models.
if [ -z "${MENISCUS_MODELS:-}" ]; then
    say "the pictures of docs/real.md are unchanged: set MENISCUS_MODELS to the folder of the models"
    exit 0
fi

# pair FOLDER SCAN HOLE CAMERA: one hole before and after the fill of the scan
pair() {
    local scan=$MENISCUS_MODELS/real/$2_riddled.obj name=$1/real-$2-$3 look=(--size 320x240 --stripes 8 --camera "$4")
    "$meniscus" render "$scan" -o "$name-before.png" --quiet --view shaded --rims "${look[@]}"
    "$meniscus" fill "$scan" -o "$scratch/filled.obj" --quiet --view isophotes --picture "$name-after.png" "${look[@]}"
}
pair docs/pictures spot 1 0.099167,-0.024942,0.53464,-0.48686,0.2177,0.12673,0.83637,0.61609,35,persp
pair docs/pictures spot 6 -0.10568,0.50255,-0.3836,-0.097501,0.65863,0.73808,-0.10926,0.98306,35,persp
pair docs/pictures spot 7 -0.14651,0.082274,-0.18512,-0.12732,-0.6871,-0.12418,0.70446,0.81884,35,persp
pair docs/pictures spot 9 -0.26067,-0.33752,0.22723,0.00027094,0.68357,0.00025375,-0.72988,1.0903,35,persp
pair docs/pictures bunny 1 -0.044082,0.52228,-0.087503,0.37181,-0.27771,-0.11761,-0.87795,0.58927,35,persp
pair docs/pictures bunny 5 -0.2606,-0.47028,0.31086,-0.35281,-0.30706,-0.12379,0.87516,0.72146,35,persp
pair docs/pictures bunny 8 -0.36039,0.2944,-0.040597,-0.11643,0.8423,0.20176,0.48607,0.41609,35,persp
pair docs/pictures bunny 14 -0.41008,0.51312,-0.41235,-0.051421,-0.7092,-0.70129,-0.050848,0.34178,35,persp

# The recorded terms of the other scans do not state that pictures may be published. These are not committed.
mkdir -p target/pictures
pair target/pictures igea 12 -0.12328,-0.42905,0.45056,-0.060398,0.37569,-0.024546,-0.92445,0.40816,35,persp
pair target/pictures rocker_arm 8 0.041002,0.32396,-0.56656,-0.14917,0.53188,0.095818,0.82805,0.39625,35,persp
pair target/pictures lion 1 0.18,-0.2,0.45,-0.29333,-0.40961,0.14098,-0.85224,1.8,35,persp
pair target/pictures lion 10 0.05451,0.19278,-0.45162,-0.0027633,0.97884,0.013246,0.20419,0.58501,35,persp
pair target/pictures fertility 8 -0.066271,0.2407,-0.074674,-0.022861,0.97536,0.12243,0.18212,0.68728,35,persp
pair target/pictures homer 3 -0.046591,0.35564,0.1272,0.062443,0.22557,0.014489,-0.97212,0.48079,35,persp
pair target/pictures cheburashka 8 0.2805,-0.25688,-0.065599,0.018186,0.96059,-0.26969,0.064776,0.57202,35,persp
