#!/bin/sh
# Run once, as root, when Gradescope builds the container: the tools, and inputs that no student has seen.
set -eu
root=${AUTOGRADER_ROOT:-/autograder}
export DEBIAN_FRONTEND=noninteractive
apt-get update -qq
apt-get install -y -qq --no-install-recommends bubblewrap gcc libc6-dev make python3-venv >/dev/null
cd "$root/source/miniraytracer"
python=$(sh grader/setup/environment.sh grade)
"$python" -m grader.authoring.gradescope.run "$root" --prepare
