#!/bin/sh
# What `make help` prints: the targets of the Makefile that are marked with ##, with a sentence each.
#
# Runs in the project's folder. Reads MRT_LANG from the environment.
set -eu

. grader/setup/sentences.sh

# shellcheck disable=SC2046
awk '
    FILENAME != "Makefile" && match($0, /^[a-z-]+ = "/) {
        name = substr($0, 1, RLENGTH - 4)
        text = substr($0, RLENGTH + 1)
        sub(/"[ \t\r]*$/, "", text)
        gsub(/\\"/, "\"", text)
        if (!(name in texts)) texts[name] = text
    }
    FILENAME == "Makefile" && /^[a-z-]+:.*##$/ {
        name = substr($0, 1, index($0, ":") - 1)
        printf "  make %-12s %s\n", name, texts[name]
    }
' $(files_of help.toml) Makefile
