#!/bin/sh
# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
#
# Print the path of a Python that can make the virtual environment: 3.12 (that of ROS 2 Jazzy) if any works, else
# 3.11, 3.13 or 3.10. Looked for on PATH, below pyenv and below uv, without running pyenv or uv.
# A file named python is not yet a Python (pyenv's shims stand on PATH for versions that are not switched on):
# only what starts, has the version asked for and owns venv and ensurepip counts.

pyenv_roots() {
    [ -z "${PYENV_ROOT:-}" ] || echo "$PYENV_ROOT"
    [ -z "${HOME:-}" ] || echo "$HOME/.pyenv"
    echo "$PATH" | tr ':' '\n' | sed -n 's:/\{1,\}shims/*$::p'  # a shim's folder reveals the root
}

uv_folders() {
    [ -z "${UV_PYTHON_INSTALL_DIR:-}" ] || echo "$UV_PYTHON_INSTALL_DIR"
    [ -z "${XDG_DATA_HOME:-}" ] || echo "$XDG_DATA_HOME/uv/python"
    [ -z "${HOME:-}" ] || echo "$HOME/.local/share/uv/python"
}

candidates() {  # VERSION: one path per line, best first; the files need not exist
    echo "$PATH" | tr ':' '\n' | sed -n "s:[^/]\$:&/:; s:^/.*:&python$1:p"
    pyenv_roots | while read -r folder; do
        for path in "$folder/versions/$1"[.-]*/bin/python "$folder/versions/$1/bin/python"; do echo "$path"; done
    done
    uv_folders | while read -r folder; do
        for path in "$folder/cpython-$1"[.-]*/bin/"python$1"; do echo "$path"; done
    done
    echo "$PATH" | tr ':' '\n' | sed -n 's:[^/]$:&/:; s:^/.*:&python3:p'
}

works() {  # PATH VERSION
    [ -x "$1" ] && [ ! -d "$1" ] && [ "$("$1" -c '
import sys, sysconfig, venv, ensurepip
if sys.implementation.name == "cpython" and not sysconfig.get_config_var("Py_GIL_DISABLED"):
    print("%d.%d" % sys.version_info[:2])' </dev/null 2>/dev/null)" = "$2" ]
}

unset PYTHONHOME PYTHONPATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
for version in 3.12 3.11 3.13 3.10; do
    found=$(candidates $version | while read -r path; do
        if works "$path" $version; then
            echo "$path"
            break
        fi
    done)
    if [ -n "$found" ]; then
        echo "$found"
        exit 0
    fi
done
echo "rigid_body_sim needs Python 3.12 (or 3.11, 3.13, 3.10) with venv and ensurepip, and none works here:" \
    "none on PATH, below pyenv's or uv's versions; install python3.12 and python3.12-venv, or name pyenv's folder in PYENV_ROOT" >&2
exit 1
