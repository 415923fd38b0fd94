#!/bin/sh
# Prints the Python that a command must use; what it says to a person goes to stderr.
#
#   sh grader/setup/environment.sh python            an interpreter that is recent enough, without any package
#   sh grader/setup/environment.sh grade|lab|dev     that of an environment with the level's packages, made if need be
#   sh grader/setup/environment.sh wheelhouse DIR    collects the packages of `lab` in DIR, for rooms without a network
#
# Runs in the project's folder. Reads from the environment:
#   PYTHON    the interpreter to use instead of looking for one
#   MRT_ENV   an existing environment to use as it is, maybe read-only
#   BUILD     where outputs go; the environment too (BUILD/venv) when .venv cannot be made here
#   WHEELS    a folder of wheels to install from, instead of the network
#   MRT_LANG  fr (default), en, or another folder of grader/course/messages/
set -eu

BUILD=${BUILD:-build}

. grader/setup/sentences.sh

# fail KEY [NAME=VALUE...]
fail() {
    sentence "$@" >&2
    exit 1
}

# What a candidate says of itself: a rank, 0 the best, and its path outside of any virtual environment.
# An interpreter that other users cannot reach (under a closed home folder) cannot run in the sandbox of a
# dropped user; one without ensurepip cannot make an environment without uv.
PROBE='
import sys
if sys.version_info < (3, 10):
    sys.exit(1)
import importlib.util, os
path = getattr(sys, "_base_executable", None) or sys.executable
real = os.path.realpath(path)
folders = [real]
while folders[-1] != os.path.dirname(folders[-1]):
    folders.append(os.path.dirname(folders[-1]))
reachable = all(os.stat(folder).st_mode & 0o001 for folder in folders)
complete = importlib.util.find_spec("ensurepip") is not None
print("%d %s" % ((not reachable) + 2 * (not complete), path))
'

probe() {
    "$1" -I -S -c "$PROBE" 2>/dev/null
}

choose() {
    if [ -n "${PYTHON:-}" ]; then
        found=$(probe "$PYTHON") || fail setup.python_too_old value="$PYTHON"
        echo "${found#* }"
        return
    fi
    best='' rank=9
    set -f
    IFS=:
    for folder in $PATH:/usr/bin:/usr/local/bin:/opt/homebrew/bin; do
        for name in python3 python3.13 python3.12 python3.11 python3.10 python3.14 python; do
            [ -x "${folder:-.}/$name" ] && found=$(probe "$folder/$name") || continue
            if [ "${found%% *}" -lt "$rank" ]; then
                rank=${found%% *} best=${found#* }
            fi
            [ "$rank" -gt 0 ] || break 2
        done
    done
    unset IFS
    set +f
    [ -n "$best" ] || fail setup.no_python
    echo "$best"
}

case ${1:-} in
python)
    choose
    ;;
wheelhouse)
    python=$(choose)
    exec "$python" -E -s -m grader.setup.environment wheelhouse "$2"
    ;;
grade | lab | dev)
    if [ -n "${MRT_ENV:-}" ]; then
        probe "$MRT_ENV/bin/python" >/dev/null || fail setup.environment_unusable value="$MRT_ENV"
        exec "$MRT_ENV/bin/python" -E -s -m grader.setup.environment check "$1"
    fi
    if [ -z "${PYTHON:-}" ]; then
        for folder in .venv "$BUILD/venv"; do
            if [ -x "$folder/bin/python" ] &&
                "$folder/bin/python" -E -s -m grader.setup.environment ready "$1" "$folder" 2>/dev/null; then
                exit 0
            fi
        done
    fi
    python=$(choose)
    exec "$python" -E -s -m grader.setup.environment make "$1" "$BUILD"
    ;;
*)
    echo "usage: sh grader/setup/environment.sh python|grade|lab|dev|wheelhouse DIR" >&2
    exit 2
    ;;
esac
