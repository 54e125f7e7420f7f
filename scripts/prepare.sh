# Sourced by run.sh, test.sh and .ci/run: installs what Meniscus needs to build and run. Needs a
# Rust toolchain (cargo); missing system packages are installed with apt.

say() { printf '%s\n' "meniscus: $*" >&2; }
die() { say "$*"; exit 1; }

# Tests whether a program can be linked. A compiler without the start files of the C library cannot
# link.
can_link() {
    local scratch status=0
    command -v cc >/dev/null 2>&1 || return 1
    scratch=$(mktemp -d)
    printf 'int main(void) { return 0; }\n' >"$scratch/probe.c"
    cc -o "$scratch/probe" "$scratch/probe.c" >/dev/null 2>&1 || status=1
    rm -rf "$scratch"
    return "$status"
}

# Tests whether a shared library is installed. ldconfig may be outside the PATH of an ordinary user.
has_library() {
    PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -q "[[:space:]]$1 "
}

# Tests whether there is a Vulkan driver, possibly a software one.
has_vulkan() {
    has_library libvulkan.so.1 || return 1
    compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}

# Tests whether there is a Vulkan or OpenGL driver.
has_graphics() {
    has_vulkan && return 0
    has_library libEGL.so.1 && compgen -G '/usr/share/glvnd/egl_vendor.d/*.json' >/dev/null
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

# install PACKAGE...: installs packages with apt and prints their names.
install() {
    command -v apt-get >/dev/null 2>&1 ||
        die "missing here: $*. Install them (these are the names on Debian and Ubuntu), then start again"
    say "installing with apt: $*"
    as_root apt-get update -qq || die "apt-get update failed: is there a network?"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >&2 ||
        die "apt-get could not install: $*"
}

# Requirements of the build.
prepare() {
    if ! command -v cargo >/dev/null 2>&1 && [ -f "${CARGO_HOME:-$HOME/.cargo}/env" ]; then
        # shellcheck disable=SC1091
        . "${CARGO_HOME:-$HOME/.cargo}/env"
    fi
    # Mesa's layer that selects a device by its display prints errors where there is none
    [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] || export NODEVICE_SELECT=1
    command -v cargo >/dev/null 2>&1 ||
        die "no cargo found: install Rust from https://rustup.rs, then start again"
    can_link || install gcc libc6-dev
    can_link || die "gcc and libc6-dev are installed, but \`cc\` still cannot link a program"
}

# Requirements of the window: desktop libraries, and a graphics driver if there is none.
prepare_window() {
    local missing=()
    has_library libX11.so.6 || missing+=(libx11-6)
    has_library libX11-xcb.so.1 || missing+=(libx11-xcb1)
    has_library libXcursor.so.1 || missing+=(libxcursor1)
    has_library libXi.so.6 || missing+=(libxi6)
    has_library libXrandr.so.2 || missing+=(libxrandr2)
    has_library libxkbcommon-x11.so.0 || missing+=(libxkbcommon-x11-0)
    has_graphics || missing+=(libvulkan1 mesa-vulkan-drivers)
    [ ${#missing[@]} -eq 0 ] || install "${missing[@]}"
}

# Further requirements of the tests: Vulkan for pictures to compare, a virtual display, and xdotool
# for mouse and keys.
prepare_tests() {
    local missing=()
    has_vulkan || missing+=(libvulkan1 mesa-vulkan-drivers)
    [ ${#missing[@]} -eq 0 ] || install "${missing[@]}"
    missing=()
    prepare_window
    command -v Xvfb >/dev/null 2>&1 || missing+=(xvfb)
    command -v xdotool >/dev/null 2>&1 || missing+=(xdotool)
    [ ${#missing[@]} -eq 0 ] || install "${missing[@]}"
}

# Requirements of the pictures of docs/: the program as `meniscus` (MENISCUS, or a new build), a
# temporary folder as `scratch`, and the folder for the pictures.
prepare_pictures() {
    meniscus=${MENISCUS:-}
    if [ -z "$meniscus" ]; then
        prepare
        prepare_window
        cargo build --release --locked --bin meniscus
        meniscus=target/release/meniscus
    fi
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    mkdir -p docs/pictures
}
