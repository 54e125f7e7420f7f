#!/usr/bin/env bash
# Reproduces Fig. 4 of the paper: a coarse mesh refined by a geometric flow, by modified Butterfly
# and by Loop's scheme. Writes docs/pictures/fig4-*.png and docs/fig4.md. MENISCUS is the program to
# use; without it the script builds one. A mesh as argument replaces the built-in torus.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare_pictures
look=(--camera iso --up z --size 480x400)

# torus FILE: 10 x 6 vertices on the Clifford torus, no diagonal in line with its neighbour
torus() {
    awk 'BEGIN {
        n = 10; m = 6; pi = atan2(0, -1)
        for (i = 0; i < n; i++) for (j = 0; j < m; j++) {
            u = 2 * pi * i / n; v = 2 * pi * j / m; r = sqrt(2) + cos(v)
            printf "v %.17g %.17g %.17g\n", r * cos(u), r * sin(u), sin(v)
        }
        for (i = 0; i < n; i++) for (j = 0; j < m; j++) {
            a = i * m + j + 1; b = (i + 1) % n * m + j + 1
            c = (i + 1) % n * m + (j + 1) % m + 1; d = i * m + (j + 1) % m + 1
            print "f", a, b, c; print "f", a, c, d
        }
    }' > "$1"
}
mesh=${1:-}
if [ -z "$mesh" ]; then
    mesh=$scratch/torus.obj
    torus "$mesh"
fi
"$meniscus" render "$mesh" -o docs/pictures/fig4-a.png --view shaded --control-mesh --wireframe "${look[@]}"

rows=
# refine LETTER TITLE OPTION...: one refinement, its picture and its row of the table
refine() {
    local letter=$1 title=$2
    shift 2
    "$meniscus" refine "$mesh" -o "$scratch/out.obj" --levels 3 --energy 'H^2' --quiet \
        --report "$scratch/report.json" "$@"
    "$meniscus" render "$scratch/out.obj" -o "docs/pictures/fig4-$letter.png" --control-mesh "${look[@]}"
    list() { sed -n "s/^ *\"$1\": \([^,]*\),*$/\1/p" "$scratch/report.json"; }
    local steps ends
    steps=$(list steps | paste -sd ' ')
    ends=$(list end | tr -d '"' | sort -u | paste -sd ' ')
    rows+="| ($letter) $title | $steps | $ends | $(list energy_end | tail -1 | cut -c1-9) | $(list seconds | tail -1 | cut -c1-5) |"$'\n'
}
refine b 'flow of `H^2`' --method pde
refine c 'modified Butterfly' --method butterfly
refine d 'Loop' --method loop

cat > docs/fig4.md <<END
# Fig. 4 of the paper

A coarse mesh and three levels of its refinement. The pictures show isophotes of the meshes. \`./scripts/fig4.sh\`
creates them; \`./scripts/fig4.sh MESH\` uses another mesh.

| (a) given | (b) flow of H² | (c) modified Butterfly | (d) Loop |
|---|---|---|---|
| ![a](pictures/fig4-a.png) | ![b](pictures/fig4-b.png) | ![c](pictures/fig4-c.png) | ![d](pictures/fig4-d.png) |

| method | steps of the levels | ended | ∫ H² dA | seconds |
|---|---|---|---|---|
$rows
The minimum over all tori is 2π² = 19.73921. The flow and Butterfly keep the input vertices. Loop's scheme does
not, and its surface shrinks. A Butterfly surface has no curvatures; its integral is that of the Loop surface with
its mesh as control mesh.
END
