#!/bin/sh
# CGAL behind the command line of `meniscus fill IN -o OUT --report FILE`, so that the suite in
# tests/it/models.rs judges its results by the same measure:
#
#   MENISCUS_MODELS=... MENISCUS_MODELS_PROGRAM=$PWD/benches/compare/cgal_as_meniscus.sh \
#       cargo test --test it models -- --nocapture
#
# CGAL_FILL names the compiled cgal_fill (run.sh builds it), CONTINUITY is 2 (default) or 1. The
# loops to leave open are taken from the manifest. The report contains no steps, so ignore the
# suite's failures about steps; its errors, cuts and folds are valid.
set -eu
shift # fill
input=$1
output= report=
while [ $# -gt 0 ]; do
    case $1 in
        -o) output=$2; shift ;;
        --report) report=$2; shift ;;
    esac
    shift
done
leave=$(python3 - "$MENISCUS_MODELS/manifest.json" "$input" <<'PY'
import json, os, sys
manifest, path = sys.argv[1:]
for case in json.load(open(manifest))["cases"]:
    if os.path.realpath(os.path.join(os.path.dirname(manifest), case["file"])) == os.path.realpath(path):
        loops = [l for l in case.get("loops", []) if not l["fill"]]
        print(" ".join(f"--leave {l['vertices'][0]}" for l in loops))
        break
PY
)
# shellcheck disable=SC2086 # several arguments on purpose
"${CGAL_FILL:-cgal_fill}" "$input" "${CONTINUITY:-2}" 1 $leave -o "$output" >&2
echo '{"holes": []}' > "$report"
