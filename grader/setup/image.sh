#!/bin/sh
# Builds the image of .devcontainer/Dockerfile with docker or podman, whichever works here.
#
# Runs in the project's folder. Reads from the environment:
#   IMAGE     the image's name, miniraytracer by default
#   HUB       the version of the JupyterHub that will use it
#   MRT_LANG  fr (default) or en
set -eu

# say FRENCH ENGLISH
say() {
    case ${MRT_LANG:-fr} in
    en*) echo "$2" >&2 ;;
    *) echo "$1" >&2 ;;
    esac
}

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
    say "Image :$silent ne répond pas ; lancez son service (systemctl start docker) ou donnez-vous le droit de l'utiliser, puis make image." \
        "Image:$silent does not answer; start its service (systemctl start docker) or get the right to use it, then make image."
else
    say "Image : ni docker ni podman ici ; installez l'un des deux (apt install podman), puis make image." \
        "Image: neither docker nor podman here; install one of them (apt install podman), then make image."
fi
exit 1
