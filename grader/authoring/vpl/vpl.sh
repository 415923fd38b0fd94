#!/bin/sh
# Run by VPL: unpacks the grader beside the student's files, and leaves what VPL runs then.
# The packages are in MRT_ENV, on the execution server: see INSTRUCTORS.md, "On Moodle VPL".
set -eu
rm -rf .mrt vpl_execution
mkdir .mrt
# -I: no file of the student's is taken for one of Python's.
python3 -I -m zipfile -e miniraytracer.zip .mrt
cat >vpl_execution <<'END'
#!/bin/sh
. ./vpl_environment.sh
root=$PWD
export MRT_ENV="${MRT_ENV:-/opt/miniraytracer}" MRT_LANG="${VPL_LANG:-fr}" VPL_GRADEMAX="${VPL_GRADEMAX:-100}"
cd .mrt/miniraytracer
if [ ! -x "$MRT_ENV/bin/python" ]; then
    echo "@COMMENT@$MRT_ENV : l'environnement Python n'est pas sur ce serveur (INSTRUCTORS.md, « On Moodle VPL »)."
    echo "@COMMENT@$MRT_ENV: the Python environment is not on this server (INSTRUCTORS.md, \"On Moodle VPL\")."
    exit 1
fi
exec "$MRT_ENV/bin/python" -m grader.authoring.vpl.run "$root"@WORDS@
END
chmod +x vpl_execution
