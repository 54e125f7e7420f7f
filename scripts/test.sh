#!/usr/bin/env bash
# Runs all tests, documentation examples included; arguments go to `cargo test`. Installs what they
# need, if missing: a C linker, libraries of the desktop, a graphics driver in software, a virtual
# display. MENISCUS_MODELS=FOLDER adds the suite over a folder of models.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare
prepare_tests
cargo test --locked "$@"
