#!/usr/bin/env bash
# Builds Meniscus and runs it. `./scripts/run.sh` opens the window on a sample (where there is no
# display it fills the sample without one), `./scripts/run.sh scan.obj` opens a mesh, other arguments
# are passed on (`./scripts/run.sh fill scan.obj -o filled.obj`). Installs what is needed, if missing.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/scripts/prepare.sh"
prepare
prepare_window
# in the project's folder, where its toolchain file and cargo's settings hold
target=$(
    cd "$root" &&
        cargo build --release --locked --bin meniscus >&2 &&
        cargo metadata --locked --no-deps --format-version 1 |
        sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p'
)
if [ $# -eq 0 ] && [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
    say "no display: filling the sample without a window"
    set -- demo
fi
exec "$target/release/meniscus" "$@"
