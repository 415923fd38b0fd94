#!/bin/sh
# Builds the image of .devcontainer/Dockerfile with docker or podman, whichever works here.
#
# Runs in the project's folder. Reads from the environment:
#   IMAGE     the image's name, miniraytracer by default
#   HUB       the version of the JupyterHub that will use it
#   MRT_LANG  fr (default), en, or another folder of grader/course/messages/
set -eu

. grader/setup/sentences.sh

silent=
for engine in docker podman; do
    command -v "$engine" >/dev/null 2>&1 || continue
    if "$engine" info >/dev/null 2>&1; then
        exec "$engine" build --file .devcontainer/Dockerfile --tag "${IMAGE:-miniraytracer}" \
            ${HUB:+--build-arg "JUPYTERHUB=$HUB"} .
    fi
    silent="$silent $engine"
done
if [ -n "$silent" ]; then
    sentence setup.engine_silent engines="$silent" >&2
else
    sentence setup.no_engine >&2
fi
exit 1
