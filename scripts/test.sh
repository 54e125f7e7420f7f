#!/usr/bin/env bash
# Runs all tests, documentation examples included; arguments go to `cargo test`. Installs what the
# build needs, if missing. MENISCUS_MODELS=FOLDER adds the suite over a folder of models.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/prepare.sh
prepare
cargo test --locked "$@"
