# The sentences of the shell scripts, which read this file with `.` in the project's folder.
#
# They stand in grader/course/messages/LANGUAGE/, as those of sentences.py: in the language of MRT_LANG, French when
# nothing is asked for, English for what a language has not. No other program is needed.

# files_of NAME: prints the files of that name that there are, the language's own first.
files_of() (
    messages=grader/course/messages
    language=${MRT_LANG:-fr}
    language=${language%"${language#??}"}
    [ -d "$messages/$language" ] || language=fr
    for folder in "$messages/$language" "$messages/en"; do
        [ ! -f "$folder/$1" ] || echo "$folder/$1"
    done
)

# replaced TEXT OLD NEW: prints a text with NEW in each place of OLD.
replaced() (
    left=$1 made=
    while :; do
        case $left in
        *"$2"*) made=$made${left%%"$2"*}$3 left=${left#*"$2"} ;;
        *) break ;;
        esac
    done
    printf '%s\n' "$made$left"
)

# sentence setup.KEY [NAME=VALUE...]: prints that sentence, with the values in the places of their {names}.
sentence() (
    key=${1#setup.} text=
    for file in $(files_of setup.toml); do
        while [ -z "$text" ] && IFS= read -r line; do
            case $line in
            "$key = \""*) text=${line#*\"} text=${text%\"*} ;;
            esac
        done <"$file"
    done
    text=$(replaced "${text:-$*}" '\"' '"')
    shift
    for value; do
        text=$(replaced "$text" "{${value%%=*}}" "${value#*=}")
    done
    printf '%s\n' "$text"
)
