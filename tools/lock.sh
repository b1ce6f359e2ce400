#!/bin/sh
# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
#
# Lock what `make venv` installs: every package that the lists runtime, ros and test come to, at one version for each
# Python from 3.10 to 3.13, with the SHA-256 of each file of that version (any processor). Extras are locked by name too:
# else pip looks for the newest `coverage[toml]` and, as soon as there is one newer than the lock, finds no hash for it.
#   sh tools/lock.sh            locks anew what has changed in the lists; the other versions stay
#   sh tools/lock.sh --upgrade  takes the newest version of all that the lists leave open
# Writes requirements/locked.txt (runtime), locked_ros.txt (what rclpy as wheels adds) and locked_test.txt (the rest). uv,
# which resolves for all Pythons at once, is installed into a temporary folder. One package (empy) comes as source
# alone: pip builds it with the setuptools of the day.
set -eu
cd "$(dirname "$0")/../requirements"
python=$(sh ../tools/find_python.sh)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check uv

compile() {  # OUTPUT LISTS…
    output=$1
    shift
    "$folder/venv/bin/uv" pip compile --quiet --universal --no-strip-extras --python-version 3.10 \
        --generate-hashes --no-annotate --no-header --no-emit-index-url --output-file "$output" "$@"
}

[ "${1:-}" = --upgrade ] || [ ! -f locked.txt ] || cat locked*.txt > "$folder/all.txt"
compile "$folder/all.txt" runtime.txt ros.txt test.txt
compile "$folder/base.txt" runtime.txt --constraints "$folder/all.txt"
compile "$folder/node.txt" runtime.txt ros.txt --constraints "$folder/all.txt"
"$python" - "$folder/all.txt" "$folder/base.txt" "$folder/node.txt" <<'PYTHON'
import re
import sys
from pathlib import Path

HEAD = '# Made by tools/lock.sh from the lists beside it: {}\n'


def entries(path):
    every = re.split(r'(?m)^(?=\S)', Path(path).read_text())[1:]
    return [entry for entry in every if "sys_platform == 'win32'" not in entry.partition('\n')[0]]


def named(path):
    """Entries by name, extras included: pip takes `name[extra]` for another package than `name`."""
    found = {}
    for entry in entries(path):
        found.setdefault(entry.partition('==')[0], []).append(entry)
    return found


total, base, node = map(named, sys.argv[1:])
parts = {
    'locked.txt': ('what runtime.txt comes to.', base, {}),
    'locked_ros.txt': ('what ros.txt adds.', node, base),
    'locked_test.txt': ('what test.txt adds.', total, base | node),
}
for file, (what, found, before) in parts.items():
    # of what others need too, the entry that is for every Python on which one of them does
    kept = [entry for name in found if name not in before for entry in total.get(name, found[name])]
    Path(file).write_text(HEAD.format(what) + ''.join(kept))
    print(f'requirements/{file}: {len(kept)} entries')
PYTHON
