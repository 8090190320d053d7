#!/bin/sh
# Makes what `make demo` and `make test` need, from a machine with only Python 3.11 or 3.12 and apt.
#
#   sh scripts/setup.sh run    .venv with the package and its runtime dependencies
#   sh scripts/setup.sh dev    the same, plus the test and lint tools
#   sh scripts/setup.sh gl     Mesa's EGL for pictures without a display; never fails
#
# Environment: PYTHON (interpreter to use), MARINE_MJ_APT=no (never call apt-get),
# MARINE_MJ_GL=none (treat this machine as one without OpenGL).
set -eu
cd "$(dirname "$0")/.."

GL_PACKAGES="libegl1 libegl-mesa0 libgl1-mesa-dri"
VENV=.venv

say() { printf '%s\n' "setup: $*" >&2; }
die() { say "$@"; exit 1; }

# Prefix with which apt-get may run, or failure when it may not.
apt_prefix() {
    [ "${MARINE_MJ_APT:-yes}" != no ] && command -v apt-get >/dev/null 2>&1 || return 1
    if [ "$(id -u)" -eq 0 ]; then
        echo env
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        echo sudo -n env
    else
        return 1
    fi
}

# Installs Debian packages if that is allowed; shows the end of apt's output when it fails.
apt_install() {
    prefix=$(apt_prefix) || return 1
    say "installing $* with apt-get"
    log=$(mktemp)
    options="-q -o Acquire::Retries=2 -o Acquire::http::Timeout=30 -o DPkg::Lock::Timeout=120"
    # An outdated package index can still serve the install: only the install decides.
    # shellcheck disable=SC2086
    $prefix apt-get $options update >"$log" 2>&1 </dev/null || true
    # shellcheck disable=SC2086
    if $prefix DEBIAN_FRONTEND=noninteractive \
        apt-get $options install -y --no-install-recommends "$@" >>"$log" 2>&1 </dev/null; then
        rm -f "$log"
    else
        say "apt-get failed; its last lines:"
        tail -n 5 "$log" >&2
        rm -f "$log"
        return 1
    fi
}

supported() {
    "$1" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 13))' 2>/dev/null
}

find_python() {
    if [ -n "${PYTHON:-}" ]; then
        supported "$PYTHON" || die "PYTHON=$PYTHON is not a Python 3.11 or 3.12." \
            "It says: $("$PYTHON" --version 2>&1 || true)"
        echo "$PYTHON"
        return
    fi
    for candidate in python3 python3.12 python3.11; do
        if supported "$candidate"; then
            echo "$candidate"
            return
        fi
    done
    die "no Python 3.11 or 3.12 found (python3 is: $(python3 --version 2>&1 || true))." \
        "dm-control needs labmaze, which has no wheels for other versions." \
        "Install one (Debian 12: apt-get install python3) or give it: make PYTHON=/path/to/python3.11 ..."
}

has_venv() {
    "$1" -c 'import venv, ensurepip; ensurepip.version()' 2>/dev/null
}

make_venv() {
    if [ -x "$VENV/bin/python" ] && supported "$VENV/bin/python" &&
        "$VENV/bin/python" -m pip --version >/dev/null 2>&1; then
        return
    fi
    python=$(find_python)
    # Debian ships Python without ensurepip; a venv made then has no pip.
    if ! has_venv "$python"; then
        package=$("$python" -c 'import sys; print("python3.%d-venv" % sys.version_info[1])')
        apt_install "$package" || true
        has_venv "$python" || die \
            "$python has no venv module. As root: apt-get install python3-venv (or $package)," \
            "then run make again."
    fi
    say "making $VENV with $("$python" --version)"
    rm -rf "$VENV"
    "$python" -m venv "$VENV" || { rm -rf "$VENV"; die "$python -m venv $VENV failed."; }
}

install_package() { # $1: what to install, $2: name of the stamp
    make_venv
    say "installing marine-mj and its dependencies into $VENV (a few minutes the first time)"
    "$VENV/bin/python" -m pip install -qq --disable-pip-version-check --editable "$1" </dev/null ||
        die "pip could not install '$1'. If a package could not be downloaded, check the network" \
            "(and PIP_INDEX_URL, if this machine has an index of its own) and run make again."
    for stamp in $2; do : >"$VENV/.stamp-$stamp"; done
}

# Renders one frame the way the package does; prints why not on failure.
probe_gl() {
    if [ "${MARINE_MJ_GL:-}" = none ]; then
        echo "MARINE_MJ_GL=none"
        return 1
    fi
    MUJOCO_GL=${MUJOCO_GL:-egl} "$VENV/bin/python" - 2>&1 <<'PY'
import ctypes
import ctypes.util
import os
import sys

try:
    if os.environ["MUJOCO_GL"] == "egl":
        ctypes.CDLL(ctypes.util.find_library("EGL") or "libEGL.so.1")
except OSError:
    print("the library libEGL.so.1 is missing")
    sys.exit(1)
try:
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><light pos='0 0 3'/><geom size='1'/></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 48, 64) as renderer:
        renderer.update_scene(data)
        if not renderer.render().any():
            raise RuntimeError("the frame is black")
except Exception as error:
    print(f"{type(error).__name__}: {error}".splitlines()[0], flush=True)
    os._exit(1)
PY
}

setup_gl() {
    [ "${MARINE_MJ_GL:-}" != none ] && [ -e "$VENV/.stamp-gl" ] && return
    if reason=$(probe_gl); then
        : >"$VENV/.stamp-gl"
        return
    fi
    # Try apt once only: a second `make demo` must not wait for it again.
    if [ "${MARINE_MJ_GL:-}" != none ] && [ ! -e "$VENV/.stamp-gl-tried" ]; then
        # shellcheck disable=SC2086
        if apt_install $GL_PACKAGES; then
            if reason=$(probe_gl); then
                : >"$VENV/.stamp-gl"
                return
            fi
        fi
        apt_prefix >/dev/null && : >"$VENV/.stamp-gl-tried"
    fi
    reason=$(printf '%s\n' "$reason" | tail -n 1)
    say "no OpenGL here, so there will be no video ($reason)."
    sudo="sudo "
    if [ "$(id -u)" -eq 0 ]; then sudo=; fi
    say "To get it, type:  ${sudo}apt-get update && ${sudo}apt-get install -y $GL_PACKAGES"
    say "The run goes on without video: plot and summary are made."
}

case "${1:-}" in
run) install_package . run ;;
dev) install_package ".[dev]" "run dev" ;;
gl) setup_gl || true ;;
*) die "unknown step '${1:-}'; allowed: run, dev, gl" ;;
esac
