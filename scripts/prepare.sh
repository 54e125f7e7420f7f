# Sourced by run.sh, test.sh and .ci/run: makes sure that a Rust project can be built here.
# Needs: a Rust toolchain (cargo), a C linker and the C library's development files.

say() { printf '%s\n' "meniscus: $*" >&2; }
die() { say "$*"; exit 1; }

# Can a program be linked? A compiler without the C library's start files cannot.
can_link() {
    local scratch status=0
    command -v cc >/dev/null 2>&1 || return 1
    scratch=$(mktemp -d)
    printf 'int main(void) { return 0; }\n' >"$scratch/probe.c"
    cc -o "$scratch/probe" "$scratch/probe.c" >/dev/null 2>&1 || status=1
    rm -rf "$scratch"
    return "$status"
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo "$@"
    else
        die "\`$*\` needs root, and there is no sudo: run it as root, then start again"
    fi
}

prepare() {
    if ! command -v cargo >/dev/null 2>&1 && [ -f "${CARGO_HOME:-$HOME/.cargo}/env" ]; then
        # shellcheck disable=SC1091
        . "${CARGO_HOME:-$HOME/.cargo}/env"
    fi
    command -v cargo >/dev/null 2>&1 ||
        die "no cargo found: install Rust from https://rustup.rs, then start again"
    can_link && return 0
    command -v apt-get >/dev/null 2>&1 ||
        die "no working C linker (cc): install a C compiler and the C library's headers, then start again"
    say "installing gcc and libc6-dev (the linker and C library files that Rust programs need)"
    as_root apt-get update -qq || die "apt-get update failed: is there a network?"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends gcc libc6-dev >&2 ||
        die "apt-get could not install gcc and libc6-dev"
    can_link || die "gcc and libc6-dev are installed, but \`cc\` still cannot link a program"
}
