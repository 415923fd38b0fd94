#!/bin/sh
# Builds the ray tracer's program, for `make mrt`, and the student's own tests, for `make try`.
#
#   sh grader/setup/program.sh mrt      core_c/mrt; for another SRC, or a read-only core_c, BUILD/<name of SRC>/mrt
#   sh grader/setup/program.sh try      BUILD/try/my_tests, built with the sanitizers where they work, then run
#   sh grader/setup/program.sh debug    the same without optimisation, in gdb
#   sh grader/setup/program.sh flags    says what would be used, without building
#
# Runs in the project's folder. Reads from the environment:
#   SRC                      folder of the student's files, core_c by default; given files always come from core_c
#   BUILD                    where outputs go
#   CASE                     try, debug: an exercise, a function or a check that the last grade showed to fail, or
#                            "last" for its first one; the call that shows it takes the place of my_tests.c
#   PREPARE                  debug: builds for the debugger of an editor, and starts none
#   CC                       the C compiler, cc by default
#   WIDTH HEIGHT SCENE_SIZE  the picture's size in pixels, the most objects of a scene
#   PLATFORM                 what `uname -s` says; a test says another name
#   MRT_LANG                 fr (default), en, or another folder of grader/course/messages/
set -eu

SRC=${SRC:-core_c}
SRC=${SRC%/}
BUILD=${BUILD:-build}
CC=${CC:-cc}
PLATFORM=${PLATFORM:-$(uname -s)}
NEEDED=20000 # kilobytes: of a full disk, compilers say that the sanitizers are not there

. grader/setup/sentences.sh

# say KEY [NAME=VALUE...]; at a terminal no word is cut at the end of a line.
say() {
    if [ -t 1 ]; then
        said=$(sentence "$@")
        echo "$said" | fold -s -w "$(stty size <&1 2>/dev/null | cut -d ' ' -f 2)" 2>/dev/null || echo "$said"
    else
        sentence "$@"
    fi
}

# fail KEY [NAME=VALUE...]
fail() {
    say "$@" >&2
    exit 1
}

# Tells whether a tiny program builds with these flags, and runs: a sanitizer may link and yet not start.
works() {
    scratch=$(mktemp -d "$BUILD/probe.XXXXXX") # not in /tmp, where some machines let nothing run
    echo 'int main(void) { return 0; }' >"$scratch/probe.c"
    # CC may hold several words (ccache gcc).
    # shellcheck disable=SC2086
    $CC "$@" "$scratch/probe.c" -o "$scratch/probe" $libraries >/dev/null 2>&1 &&
        "$scratch/probe" >/dev/null 2>&1 && answer=0 || answer=1
    rm -rf "$scratch"
    return $answer
}

# Sets flags and libraries, lists of words without spaces.
choose_flags() {
    command -v "${CC%% *}" >/dev/null || fail setup.no_compiler compiler="$CC"
    mkdir -p "$BUILD" 2>/dev/null && [ -w "$BUILD" ] || fail setup.build_unwritable folder="$BUILD"
    free=$(df -Pk "$BUILD" 2>/dev/null | awk 'NR == 2 { print $4 }')
    [ "${free:-$NEEDED}" -ge "$NEEDED" ] || fail setup.disk_full folder="$BUILD" free=$((free / 1000)) needed=$((NEEDED / 1000))
    flags="-std=gnu11 -g -Wall -Wextra -Wfatal-errors"
    for name in WIDTH HEIGHT SCENE_SIZE; do
        eval "value=\${$name:-}"
        case $value in
        '') ;;
        *[!0-9]* | 0*) fail setup.not_positive name="$name" value="$value" ;;
        *) flags="$flags -D$name=$value" ;;
        esac
    done
}

# Apple's clang takes OpenMP only behind -Xpreprocessor, with a library that Homebrew keeps apart.
choose_openmp() {
    openmp=-fopenmp
    if [ "$PLATFORM" = Darwin ]; then
        prefix=$(brew --prefix libomp 2>/dev/null || echo /opt/homebrew/opt/libomp)
        openmp="-Xpreprocessor -fopenmp -I$prefix/include -L$prefix/lib -lomp"
    fi
}

choose_mrt_flags() {
    choose_flags
    libraries=-lm
    choose_openmp
    # shellcheck disable=SC2086
    if works $openmp; then
        flags="$flags $openmp"
    fi
    flags="$flags -O3"
    if png=$(pkg-config --cflags libpng 2>/dev/null) && png_libs=$(pkg-config --libs libpng); then
        libraries="$png_libs -lm"
        # shellcheck disable=SC2086
        if works $png; then
            flags="$flags -DMRT_PNG $png"
        else
            libraries=-lm
        fi
    fi
}

# choose_try_flags OPTIMISATION
choose_try_flags() {
    choose_flags
    libraries=-lm
    flags="$flags $1 -fno-omit-frame-pointer"
    # What has no first value is then -1.7e38, and not a zero that hides it.
    if works -ftrivial-auto-var-init=pattern; then
        flags="$flags -ftrivial-auto-var-init=pattern"
    fi
    sanitizers="-fsanitize=address,undefined"
    if works $sanitizers; then
        flags="$flags $sanitizers"
    else
        say setup.no_sanitizers >&2
    fi
}

# Names the given files that are not as they were handed out, where there is a Python to look; stops where one is missing.
check_given() {
    if python=$(sh grader/setup/environment.sh python 2>/dev/null); then
        "$python" -m grader.setup.restore --check
    fi
}

# The sources but main.c are given to a function, behind its own parameters.
with_sources() {
    [ -e "$SRC/main.c" ] || fail setup.no_main folder="$SRC"
    for file in "$SRC"/*.c; do
        case $file in
        */main.c | */my_tests.c | */vector.c | */scene.c) ;;
        *) set -- "$@" "$file" ;;
        esac
    done
    "$@" core_c/vector.c core_c/scene.c
}

# compile OUTPUT ARGUMENT...
compile() {
    output=$1
    shift
    # shellcheck disable=SC2086
    $CC $flags -I"$SRC" -Icore_c "$@" -o "$output" || fail setup.build_failed
}

# Tells whether the program is newer than every source and was built by the same command.
is_fresh() {
    [ -x "$program" ] && [ "$(cat "$stamp" 2>/dev/null)" = "$command" ] &&
        [ -z "$(find "$SRC" core_c -name '*.[ch]' -newer "$program")" ]
}

build_mrt() {
    name=$(basename "$SRC")
    program=$BUILD/$name/mrt
    if [ "$SRC" = core_c ] && [ -w core_c ]; then
        program=core_c/mrt
    fi
    stamp=$BUILD/$name/flags
    command="$CC $flags $libraries $*"
    if is_fresh; then
        say setup.up_to_date program="$program"
        return
    fi
    mkdir -p "$BUILD/$name"
    rm -f "$program" # an old program must not pass for the new one
    # shellcheck disable=SC2086
    compile "$program" "$SRC/main.c" "$@" $libraries
    echo "$command" >"$stamp"
    if [ "$program" != core_c/mrt ] && [ -e core_c/texture.ppm ]; then
        cp core_c/texture.ppm "$BUILD/$name/"
    fi
    say setup.program_ready program="$program" folder="${program%/mrt}"
}

# Sets tests, function and the size of the pictures: the student's own tests, or the call of CASE.
choose_tests() {
    function=main
    if [ -n "${CASE:-}" ]; then
        python=$(sh grader/setup/environment.sh python)
        found=$("$python" -m grader.setup.failing_call "$CASE" "$BUILD") || exit 1
        {
            read -r tests
            read -r function
            read -r width || :
            read -r height || :
        } <<END
$found
END
        WIDTH=${WIDTH:-$width} HEIGHT=${HEIGHT:-$height}
        return
    fi
    tests=$SRC/my_tests.c
    [ -e "$tests" ] || tests=core_c/my_tests.c
    [ -e "$tests" ] || fail setup.no_tests path="$tests"
}

# object SOURCE FLAG...: compiles a source, unless that was done since it or a header changed; sets object.
object() {
    source=$1
    shift
    object=$objects/$(basename "$source" .c).o
    [ "$object" -nt "$source" ] && [ -z "$(find "$SRC" core_c -name '*.h' -newer "$object")" ] ||
        compile "$object" -c "$@" "$source"
}

# Sets program: the tests, linked with every source. The objects of other flags are kept apart.
build_tests() {
    objects=$BUILD/try/$(printf '%s' "$CC $flags $SRC" | cksum | cut -d ' ' -f 1)
    mkdir -p "$objects"
    object "$SRC/main.c" -Dmain=mrt_program_main
    main=$object
    set -- "$@" "$tests"
    case $flags in *-fsanitize=*) set -- "$@" grader/setup/sanitizers.c ;; esac
    for source; do
        object "$source"
        shift
        set -- "$@" "$object"
    done
    program=$BUILD/try/$(basename "$tests" .c)
    # shellcheck disable=SC2086
    compile "$program" "$main" "$@" $libraries
}

run_tests() {
    build_tests "$@"
    exec "$program"
}

# With PREPARE=1 gdb is started by somebody else, an editor, who finds the program and the breakpoint in BUILD/try.
debug_tests() {
    command -v gdb >/dev/null || fail setup.no_gdb
    build_tests "$@"
    if [ -n "${PREPARE:-}" ]; then
        cp "$program" "$BUILD/try/debugged"
        echo "break $function" >"$BUILD/try/debugged.gdb"
        say setup.debug_ready path="$BUILD/try/debugged"
        return
    fi
    say setup.gdb_stops function="$function"
    DEBUGINFOD_URLS='' exec gdb -q -ex "break $function" -ex run "$program"
}

case ${1:-} in
mrt)
    choose_mrt_flags
    check_given
    with_sources build_mrt
    ;;
try)
    choose_tests
    choose_try_flags -O1
    check_given
    with_sources run_tests
    ;;
debug)
    choose_tests
    choose_try_flags -O0
    check_given
    with_sources debug_tests
    ;;
flags)
    choose_mrt_flags
    echo "mrt: $CC $flags $libraries"
    choose_try_flags -O1
    echo "try: $CC $flags $libraries"
    ;;
*)
    echo "usage: sh grader/setup/program.sh mrt|try|debug|flags" >&2
    exit 2
    ;;
esac
