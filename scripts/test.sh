#!/usr/bin/env bash
# Runs all tests, including documentation examples. Arguments are passed to `cargo test`. Installs
# missing system packages: a C linker, desktop libraries, a software graphics driver, a virtual
# display. MENISCUS_MODELS=FOLDER adds the suite over a folder of models.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare
prepare_tests
cargo test --locked "$@"
