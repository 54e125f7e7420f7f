#!/bin/sh
# Times `meniscus fill` against CGAL's triangulate_refine_and_fair_hole on the same holes.
#
#   MENISCUS_MODELS=/path/to/models benches/compare/run.sh [CASE...]
#
# CASE is a name in the manifest (default: the six of the table below). The two programs run
# alternately, RUNS times each (default 7; large holes 3), and the minimum time of each is kept.
# CGAL: only the call, fairing continuity 2 and 1. Meniscus: totals.timings.total of its report,
# which excludes only reading and writing files. Set MENISCUS to a binary; otherwise the script
# makes a release build. Both are wall times on an idle machine. CGAL's processor time is printed
# too, which shows whether the machine was idle.
#
# Installs CGAL (Debian's libcgal-dev) if its headers are missing; the build needs g++ and
# python3. Continuous integration does not run this.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
: "${MENISCUS_MODELS:?name the folder of the test models (the one with manifest.json)}"
build=${CGAL_BUILD:-${CARGO_TARGET_DIR:-$root/target}/compare}
mkdir -p "$build"

if ! printf '#include <CGAL/version.h>\n' | g++ -E -x c++ - >/dev/null 2>&1; then
    echo "CGAL is not installed: installing libcgal-dev and libeigen3-dev with apt-get" >&2
    apt-get update >&2
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        libcgal-dev libeigen3-dev >&2
fi
if [ ! -x "$build/cgal_fill" ] || [ "$here/cgal_fill.cpp" -nt "$build/cgal_fill" ]; then
    echo "compiling cgal_fill" >&2
    g++ -O3 -DNDEBUG -std=c++17 -DCGAL_EIGEN3_ENABLED -I/usr/include/eigen3 \
        "$here/cgal_fill.cpp" -o "$build/cgal_fill" -lgmp -lmpfr
fi
if [ -z "${MENISCUS:-}" ]; then
    (cd "$root" && cargo build --release --bin meniscus >&2)
    MENISCUS=${CARGO_TARGET_DIR:-$root/target}/release/meniscus
fi
exec python3 "$here/compare.py" "$MENISCUS" "$build/cgal_fill" "$MENISCUS_MODELS" "$@"
