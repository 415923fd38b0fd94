# Every command a person types. `make` alone lists them.
#
# Each recipe finds or makes the Python environment that it needs: see grader/setup/environment.sh.
# Paths here are relative, and values travel by the environment, so that this works from any folder.

.DEFAULT_GOAL := help
.PHONY: help grade report watch mrt try debug restore lab submit update release classroom gradescope vpl batch alike purge oral notebooks figures expected new calibrate prove skeleton format lint test test-all test-exhaustive bench doctor image wheelhouse print-flags clean

SUBMISSION ?= core_c
SRC ?= core_c
BUILD ?= build
PLATFORM ?= $(shell uname -s)

# A variable given on make's command line is exported by make itself; these have a default.
export SUBMISSION SRC BUILD PLATFORM
export PYTEST_DISABLE_PLUGIN_AUTOLOAD := 1
# make's own default compiler is not a choice of the person's.
ifneq ($(origin CC),default)
export CC
endif

# What a person has for other work in Python changes nothing here; but which one to use, and how it writes.
unexport $(filter-out PYTHON PYTHON_OF PYTHONDONTWRITEBYTECODE PYTHONPYCACHEPREFIX PYTHONUNBUFFERED,\
    $(filter PYTHON%,$(.VARIABLES)))

# Sets $python in a recipe: $(call PYTHON_OF,LEVEL), a level of grader/setup/requirements/.
PYTHON_OF = python=$$(sh grader/setup/environment.sh $(1))

help: ##
	@sh grader/setup/help.sh

grade: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader grade "$$SUBMISSION" \
	    $${TP:+--tp "$$TP"} $${K:+-k "$$K"} $${HINT:+--hint "$$HINT"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${JOBS:+--jobs "$$JOBS"} $${EXPECTED:+--expected "$$EXPECTED"} $${ANNOTATE:+--annotate "$$ANNOTATE"} --build "$$BUILD"

report: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader report "$${RESULTS:-$$BUILD/grade}" $${HINT:+--hint "$$HINT"}

watch: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader watch "$$SUBMISSION" \
	    $${TP:+--tp "$$TP"} $${K:+-k "$$K"} $${HINT:+--hint "$$HINT"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${ANNOTATE:+--annotate "$$ANNOTATE"} --build "$$BUILD"

mrt: ##
	@sh grader/setup/program.sh mrt

try: ##
	@sh grader/setup/program.sh try

debug: ##
	@CASE="$${CASE:-$$K}" sh grader/setup/program.sh debug

restore: ##
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.restore

doctor: ##
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.doctor

submit: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader submit --source "$$SUBMISSION" --build "$$BUILD" \
	    $${OUT:+--out "$$OUT"} $${FORCE:+--force}

update: ##
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.update $${FORCE:+--force} $${ARCHIVE:+"$$ARCHIVE"}

release: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader release --out "$${OUT:-$$BUILD/miniraytracer.zip}" \
	    $${COMMENTS:+--comments "$$COMMENTS"}

classroom: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader classroom --out "$${OUT:-$$BUILD/classroom}" \
	    $${COMMENTS:+--comments "$$COMMENTS"}

gradescope: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader gradescope --out "$${OUT:-$$BUILD/autograder.zip}"

vpl: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader vpl --out "$${OUT:-$$BUILD/vpl.zip}"

batch: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader batch $${SUBMISSIONS:+"$$SUBMISSIONS"} $${OUT:+--out "$$OUT"} \
	    $${JOBS:+--jobs "$$JOBS"} $${SCHEDULER:+--scheduler "$$SCHEDULER"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${AGAIN:+--again} $${NAMES:+--names} $${GALLERY:+--gallery} $${WORKSHEET:+--worksheet "$$WORKSHEET"} \
	    $${HINT:+--hint "$$HINT"} $${EXPECTED:+--expected "$$EXPECTED"} $${YES:+--yes} $${PUBLIC:+--public}

alike: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader alike $${SUBMISSIONS:+"$$SUBMISSIONS"} $${OUT:+--out "$$OUT"} \
	    $${PAST:+--past "$$PAST"} $${NAMES:+--names}

purge: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader purge $${OUT:+"$$OUT"}

oral: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader oral "$$SUBMISSION" --build "$$BUILD" $${TP:+--tp "$$TP"}

lab: ##
	@$(call PYTHON_OF,lab) && "$$python" -m grader.lab $${TP:+--tp "$$TP"}

notebooks: ##
	@$(call PYTHON_OF,lab) && "$$python" -m grader.authoring.workbook.notebooks $${PICTURES:+--pictures}

figures: ##
	@$(call PYTHON_OF,lab) && "$$python" -m grader.authoring.drawings.figures --build "$$BUILD"

expected: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.expected.command $${SEED:+--seed "$$SEED"} $${OUT:+--out "$$OUT"} \
	    $${SUITE:+--suite "$$SUITE"} $${PICTURE:+--picture "$$PICTURE"} $${MISTAKE:+--mistake "$$MISTAKE"}

new: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.new \
	    $${EXERCISE:+--exercise "$$EXERCISE"} $${FUNCTION:+--function "$$FUNCTION"} $${CHECK:+--check "$$CHECK"} \
	    $${SUITE:+--suite "$$SUITE"} $${PICTURE:+--picture "$$PICTURE"} $${SCENE:+--scene "$$SCENE"} \
	    $${MISTAKE:+--mistake "$$MISTAKE"} $${WORTH:+--worth "$$WORTH"}

calibrate: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.expected.pictures

prove: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.proof --build "$$BUILD" $${PART:+--part "$$PART"} \
	    $${SAMPLE:+--sample "$$SAMPLE"} $${JOBS:+--jobs "$$JOBS"} $${AGAIN:+--again}

skeleton: ##
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.skeleton.skeleton && "$$python" -m grader.authoring.skeleton.originals

# The C that is laid out alike; the submissions of the tests are as wild as they are.
C_FILES = core_c/*.[ch] notebooks/first_steps/*.c reference/*.[ch] grader/build/shim/*.c grader/execution/*.c grader/setup/*.c grader/authoring/bench/*.c grader/authoring/expected/pictures/*.c grader/tests/setup/program/*.c
format: ##
	@$(call PYTHON_OF,dev) && "$$python" -m ruff check --no-cache --fix-only . && "$$python" -m ruff format --no-cache . && \
	    "$${python%/*}/clang-format" -i $(C_FILES)

lint: ##
	@$(call PYTHON_OF,dev) && set -ex && "$$python" -m ruff check --no-cache . && \
	    "$$python" -m ruff format --no-cache --check . && \
	    "$${python%/*}/clang-format" --dry-run -Werror $(C_FILES) && \
	    printf '%s\n' core_c/*.c reference/*.c | \
	        xargs -P 2 -I FILE "$${python%/*}/clang-tidy" --quiet FILE -- -std=gnu11 -Icore_c && \
	    "$$python" -m mypy --cache-dir "$$BUILD/mypy"

test: ##
	@$(MAKE) --no-print-directory -j 2 lint suite

test-all: test ##
	@$(call PYTHON_OF,dev) && set -x && $(PYTEST) -m "long and not exhaustive"

test-exhaustive: test-all ##
	@$(call PYTHON_OF,dev) && set -x && $(PYTEST) -m exhaustive

# The generated files are those of their sources; the tests, side by side, three more at a time than there are cores
# since many wait, in the order of grader/tests/conftest.py.
PYTEST = "$$python" -m pytest -p xdist -n "$$(($$(getconf _NPROCESSORS_ONLN) + 3))" --dist loadscope --no-loadscope-reorder
.PHONY: suite
suite:
	@$(call PYTHON_OF,dev) && set -x && "$$python" -m grader.authoring.skeleton.skeleton --check && \
	    "$$python" -m grader.authoring.skeleton.originals --check && \
	    "$$python" -m grader.authoring.workbook.notebooks --check && $(PYTEST)

bench: ##
	@$(call PYTHON_OF,dev) && case "$$CLASS,$$KILLS" in \
	    ,) "$$python" -m grader.authoring.bench --build "$$BUILD" ;; \
	    ,*) "$$python" -m grader.authoring.bench.kills --trials "$$KILLS" --build "$$BUILD" ;; \
	    *) "$$python" -m grader.authoring.bench.batch --size "$$CLASS" --build "$$BUILD" ;; esac

image: ##
	@sh grader/setup/image.sh

wheelhouse: ##
	@sh grader/setup/environment.sh wheelhouse "$$BUILD/wheelhouse"

clean: ##
	@rm -rf build core_c/mrt

# For the tests of this file.
print-flags:
	@sh grader/setup/program.sh flags
