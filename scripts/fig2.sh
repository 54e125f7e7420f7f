#!/usr/bin/env bash
# Reproduces Fig. 2 of the paper: four cylinders blended under six energies. Writes
# docs/pictures/fig2-*.png and docs/fig2.md. MENISCUS is the program to use; without it the script
# builds one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare_pictures
look=(--camera iso --up z --size 640x480)
"$meniscus" sample four-cylinders -o "$scratch/in.obj"
"$meniscus" render "$scratch/in.obj" -o docs/pictures/fig2-a.png --view shaded "${look[@]}"

rows=
# blend LETTER TITLE PAPER OPTION...: one blend, its picture and its row of the table
blend() {
    local letter=$1 title=$2 paper=$3
    shift 3
    "$meniscus" blend "$scratch/in.obj" -o "$scratch/out.obj" --quiet --report "$scratch/report.json" \
        --picture "docs/pictures/fig2-$letter.png" "${look[@]}" "$@"
    field() { sed -n "s/^ *\"$1\": \([^,]*\),*$/\1/p" "$scratch/report.json" | head -1; }
    local end=converged
    warned() { grep -q "^ *\"$1\",*$" "$scratch/report.json"; } # by the code of a warning
    warned pinched && end='before the neck pinches off'
    warned step-size-collapsed && end='no step lowers the energy'
    warned step-limit && end='stopped'
    rows+="| ($letter) $title | $paper | $(field steps) | $(field rejected) | $end | $(field seconds | cut -c1-5) |"$'\n'
}
blend b 'start, with noise' '-' --view shaded --noise 0.3 --steps 0
blend c '`1`' '135 of τ = 0.01' --energy 1 --noise 0.3 --continuity g0 --mode flow --tau 0.01 --steps 135
# the stationary surfaces, which are the limits of the paper's flows
blend d '`H^2`' '1000 of τ = 1e-5' --energy 'H^2' --noise 0.3
blend e '`K^2`' '1000 of τ = 1e-5' --energy 'K^2' --noise 0.3
blend f '`H^2+K^2`' '1000 of τ = 1e-5' --energy 'H^2+K^2' --noise 0.3
blend g '`H^2*K^2`' '1000 of τ = 1e-5' --energy 'H^2*K^2' --noise 0.3
blend h '`k1^4+k2^4`' '1000 of τ = 1e-5' --energy 'k1^4+k2^4' --noise 0.3

cat > docs/fig2.md <<END
# Fig. 2 of the paper

Blends of four cylinders under six energies, from a start surface with noise. The pictures show isophotes of the
limit surfaces. \`./scripts/fig2.sh\` creates them.

| (a) the cylinders | (b) the start | (c) f = 1, a crease at the rims | (d) f = H² |
|---|---|---|---|
| ![a](pictures/fig2-a.png) | ![b](pictures/fig2-b.png) | ![c](pictures/fig2-c.png) | ![d](pictures/fig2-d.png) |

| (e) f = K² | (f) f = H² + K² | (g) f = H²K² | (h) f = k1⁴ + k2⁴ |
|---|---|---|---|
| ![e](pictures/fig2-e.png) | ![f](pictures/fig2-f.png) | ![g](pictures/fig2-g.png) | ![h](pictures/fig2-h.png) |

| energy | steps in the paper | steps | rejected | ended | seconds |
|---|---|---|---|---|---|
$rows
(c) is mean curvature flow in true time. It ends at the paper's stopping time, or before that at the last state
before a neck pinches off, because the area of these tubes has no minimum with an open middle. (d) to (h) are
stationary surfaces, the limits of the paper's flows. Use \`--mode flow --tau 1e-5 --steps 1000\` for a flow in
true time. Isophotes have no kink at the rims under every energy of fourth order. K² gives a poor surface, as in
the paper: it is small where only one of the two curvatures vanishes, and concentrates the bending in narrow
bands. H²K² is ill-posed on parts of the surface and keeps oscillations.
END
