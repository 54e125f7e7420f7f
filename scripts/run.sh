#!/usr/bin/env bash
# Builds and runs Meniscus. `./scripts/run.sh` opens the window with a sample (without a display it
# fills the sample), `./scripts/run.sh scan.obj` opens a mesh. Other arguments are passed to the
# program (`./scripts/run.sh fill scan.obj -o filled.obj`). Installs missing system packages.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/scripts/prepare.sh"
prepare
prepare_window
# in the project's folder, so that its toolchain file and cargo settings apply
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
