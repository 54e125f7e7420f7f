#!/usr/bin/env bash
# Records the results of the program, to check that a change of its structure changes no result.
#   scripts/record.sh LIST            runs all jobs and writes one line a job: hash of the output file, exit status, name
#   scripts/record.sh LIST --quick    a part of them that takes a minute
#   diff BEFORE AFTER                 no difference: every output is bit-identical
# MENISCUS names the program (default: target/debug/meniscus), MENISCUS_MODELS the folder of test models.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
list=${1:?usage: scripts/record.sh LIST [--quick]}
quick=${2:-}
export MENISCUS=${MENISCUS:-$PWD/target/debug/meniscus}
models=${MENISCUS_MODELS:?MENISCUS_MODELS must name the folder of test models}
scratch=$(mktemp -d)
export scratch models
trap 'rm -rf "$scratch"' EXIT
jobs=$scratch/jobs
: >"$jobs"

# job NAME EXTENSION ARGUMENT...: one run. `@` is replaced by the output file, which is hashed.
job() {
    local name=$1 extension=$2
    shift 2
    printf '%s\t%s' "$name" "$extension" >>"$jobs"
    printf '\t%s' "$@" >>"$jobs"
    printf '\n' >>"$jobs"
}

samples=(creature sphere egg ring torus catenoid saddle four-cylinders three-y)
for sample in "${samples[@]}"; do
    "$MENISCUS" sample "$sample" -o "$scratch/$sample.obj" >/dev/null 2>&1
    job "sample/$sample" obj sample "$sample" -o @
    case $sample in
    four-cylinders | three-y) ;;
    *)
        job "fill/$sample" obj fill "$scratch/$sample.obj" -o @
        job "analyze/$sample" json analyze "$scratch/$sample.obj" --json
        ;;
    esac
done
sphere=$scratch/sphere.obj
torus=$scratch/torus.obj
job "blend/three-y" obj blend "$scratch/three-y.obj" -o @
for energy in 1 H H^2 H^4 'H^2+K^2' K^2 'H^2*K^2' K 'k1^4+k2^4' '(H-H0)^2' 'sqrt(k1^2+k2^2+c^2)'; do
    extra=()
    case $energy in
    *H0*) extra=(--param H0=-1) ;;
    *c*) extra=(--param c=1) ;;
    esac
    job "energy/sphere/$energy" obj fill "$sphere" -o @ --loops 1 --energy "$energy" "${extra[@]}"
    job "energy/torus/$energy" obj fill "$torus" -o @ --loops 1 --energy "$energy" "${extra[@]}"
done
for scheme in mixed mixed-corrected; do
    job "scheme/$scheme/sphere" obj fill "$sphere" -o @ --loops 1 --scheme $scheme
    job "scheme/$scheme/torus" obj fill "$torus" -o @ --loops 1 --scheme $scheme --linear lu
done
printf 'attempt,control,value\n3,energy,H^2+K^2\n6,rewind,2\n9,stop,\n' >"$scratch/a.csv"
printf 'attempt,control,value\n2,density,1.5\n5,finish,\n' >"$scratch/b.csv"
printf 'attempt,control,value\n1,continuity,g0\n4,tension,2\n4,tau,1e-4\n' >"$scratch/c.csv"
for schedule in a b c; do
    job "schedule/$schedule" obj fill "$sphere" -o @ --mode flow --steps 12 --schedule "$scratch/$schedule.csv"
done
job "options/flow" obj fill "$torus" -o @ --mode flow --steps 15 --relaxation 0.3 --noise 0.2 --growth 2
job "options/g0" obj fill "$sphere" -o @ --loop-continuity 2=g0 --tension 1 --bulge 0.5 --density 1.4
job "refill" obj refill "$sphere" -o @ --ball 0,0,1,0.4
job "fair" obj refill "$sphere" -o @ --ball 0,0,-1,0.4 --fair
job "erase" obj erase "$sphere" -o @ --ball 0,0,1,0.3
job "flip" obj flip "$sphere" -o @ --component-of 1
job "bridge" obj bridge "$sphere" -o @ --from 0,0,1 --to 0,1,0
for m in refine_octahedron refine_cube refine_torus; do
    job "refine/$m" obj refine "$models/refine/$m.obj" -o @ --levels 2
done
job "refine/H2" obj refine "$models/refine/refine_icosahedron.obj" -o @ --levels 2 --energy H^2
job "refine/loop" obj refine "$models/refine/refine_torus.obj" -o @ --levels 2 --method loop
job "refine/butterfly" obj refine "$models/refine/refine_torus.obj" -o @ --levels 2 --method butterfly
job "refine/crease" obj refine "$models/refine/refine_cube.obj" -o @ --levels 2 --crease-angle 40
job "fill/spot" obj fill "$models/real/spot_riddled.obj" -o @
job "stl" stl fill "$models/bad/sphere_binary.stl" -o @
job "ply" ply fill "$models/bad/sphere_binary_ply.ply" -o @

if [ "$quick" != --quick ]; then
    for file in "$models"/analytic/*.obj "$models"/real/*.obj "$models"/ref/bunny.obj "$models"/bad/*; do
        name=$(basename "$file")
        job "models/fill/$name" obj fill "$file" -o @
        job "models/analyze/$name" json analyze "$file" --json
    done
    for file in "$models"/blend/*.obj; do
        job "models/blend/$(basename "$file")" obj blend "$file" -o @
        job "models/analyze/$(basename "$file")" json analyze "$file" --json
    done
    for file in "$models"/refine/*.obj; do
        job "models/refine/$(basename "$file")" obj refine "$file" -o @ --levels 2
    done
    for file in spot igea; do
        job "models/refill/$file" obj refill "$models/ref/$file.obj" -o @ --ball 0,0,0.4,0.2
        job "models/erase/$file" obj erase "$models/ref/$file.obj" -o @ --ball 0,0,0.4,0.2
    done
    job "blend/four-cylinders" obj blend "$scratch/four-cylinders.obj" -o @
fi

# run_job LINE: one line of the result
run_job() {
    local fields status=0 output
    IFS=$'\t' read -r -a fields <<<"$1"
    output=$scratch/out-$$.${fields[1]}
    local words=("${fields[@]:2}")
    rm -f "$output"
    timeout 300 "$MENISCUS" "${words[@]/#@/$output}" >"$output.stdout" 2>/dev/null </dev/null || status=$?
    # the report contains the path of the measured file, which differs from run to run
    [ "${fields[1]}" != json ] || sed -e "s#$scratch/##g" -e "s#$models/##g" "$output.stdout" >"$output"
    local hash=-
    [ ! -f "$output" ] || hash=$(sha256sum "$output" | cut -c1-24)
    rm -f "$output" "$output.stdout"
    printf '%s %s %s\n' "$hash" "$status" "${fields[0]}"
}
export -f run_job
tr '\n' '\0' <"$jobs" | xargs -0 -P "$(nproc)" -I{} bash -c 'run_job "$1"' _ {} | sort -k3 >"$list"
printf '%s jobs recorded in %s\n' "$(wc -l <"$list")" "$list" >&2
