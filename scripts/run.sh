#!/usr/bin/env bash
# Builds Meniscus and runs it: `./scripts/run.sh` runs the built-in demo, with arguments it passes
# them on (`./scripts/run.sh fill scan.obj -o filled.obj`). Installs what the build needs, if missing.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/scripts/prepare.sh"
prepare
# in the project's folder, where its toolchain file and cargo's settings hold
target=$(
    cd "$root" &&
        cargo build --release --locked --bin meniscus >&2 &&
        cargo metadata --locked --no-deps --format-version 1 |
        sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p'
)
[ $# -gt 0 ] || set -- demo
exec "$target/release/meniscus" "$@"
