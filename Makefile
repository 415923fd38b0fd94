# Every command a person types. `make` alone lists them.
#
# Each recipe finds or makes the Python environment that it needs: see grader/setup/environment.sh.
# Paths here are relative, and values travel by the environment, so that this works from any folder.

.DEFAULT_GOAL := help
.PHONY: help grade report watch mrt try debug restore lab submit update release classroom gradescope vpl batch alike purge oral notebooks figures expected new calibrate prove skeleton format lint test test-all bench doctor image wheelhouse print-flags clean

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

help: ## cette liste | this list
	@awk -F ':.*## | [|] ' -v language="$${MRT_LANG:-fr}" \
	    '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, language ~ /^en/ ? $$3 : $$2 }' Makefile

grade: ## évalue votre code : TP=1, K=fill, HINT=2, SUBMISSION=dossier | grades your code: TP=1, K=fill, HINT=2, SUBMISSION=folder
	@$(call PYTHON_OF,grade) && "$$python" -m grader grade "$$SUBMISSION" \
	    $${TP:+--tp "$$TP"} $${K:+-k "$$K"} $${HINT:+--hint "$$HINT"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${EXPECTED:+--expected "$$EXPECTED"} $${ANNOTATE:+--annotate "$$ANNOTATE"} --build "$$BUILD"

report: ## refait le rapport sans rien exécuter : MRT_LANG=en, RESULTS=dossier | makes the report again, runs nothing: MRT_LANG=en, RESULTS=folder
	@$(call PYTHON_OF,grade) && "$$python" -m grader report "$${RESULTS:-$$BUILD/grade}" $${HINT:+--hint "$$HINT"}

watch: ## évalue à chaque enregistrement : TP=1, K=fill | grades at each save: TP=1, K=fill
	@$(call PYTHON_OF,grade) && "$$python" -m grader watch "$$SUBMISSION" \
	    $${TP:+--tp "$$TP"} $${K:+-k "$$K"} $${HINT:+--hint "$$HINT"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${ANNOTATE:+--annotate "$$ANNOTATE"} --build "$$BUILD"

mrt: ## compile core_c/mrt : WIDTH=640 HEIGHT=360, SCENE_SIZE=, CC= | builds core_c/mrt: WIDTH=640 HEIGHT=360, SCENE_SIZE=, CC=
	@sh grader/setup/program.sh mrt

try: ## compile et lance vos propres tests, core_c/my_tests.c, ou un appel qui échoue : CASE=TP2.4 | builds and runs your own tests, core_c/my_tests.c, or a failing call: CASE=TP2.4
	@sh grader/setup/program.sh try

debug: ## ouvre vos tests dans gdb, ou un appel qui échoue : K=TP2.4 | opens your tests in gdb, or a failing call: K=TP2.4
	@CASE="$${CASE:-$$K}" sh grader/setup/program.sh debug

restore: ## remet les fichiers fournis de core_c/, sans toucher aux vôtres | puts the given files of core_c/ back, and leaves yours alone
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.restore

doctor: ## ce que cette machine sait faire, et comment compléter | what this machine has, and how to get the rest
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.doctor

submit: ## prépare l'archive à rendre : FORCE=1, OUT=dossier | makes the archive to hand in: FORCE=1, OUT=folder
	@$(call PYTHON_OF,grade) && "$$python" -m grader submit --source "$$SUBMISSION" --build "$$BUILD" \
	    $${OUT:+--out "$$OUT"} $${FORCE:+--force}

update: ## remplace le sujet par une version plus récente, pas vos fichiers : ARCHIVE=nom.zip | a newer workbook around your files: ARCHIVE=name.zip
	@$(call PYTHON_OF,python) && "$$python" -m grader.setup.update $${FORCE:+--force} $${ARCHIVE:+"$$ARCHIVE"}

release: ## l'archive à distribuer, sans la solution : OUT=nom.zip, COMMENTS=en | the archive to hand out, without the solution: OUT=name.zip, COMMENTS=en
	@$(call PYTHON_OF,grade) && "$$python" -m grader release --out "$${OUT:-$$BUILD/miniraytracer.zip}" \
	    $${COMMENTS:+--comments "$$COMMENTS"}

classroom: ## un dépôt pour GitHub ou GitLab, évalué à chaque envoi : OUT=dossier, COMMENTS=en | a repository for GitHub or GitLab, graded at each push: OUT=folder, COMMENTS=en
	@$(call PYTHON_OF,grade) && "$$python" -m grader classroom --out "$${OUT:-$$BUILD/classroom}" \
	    $${COMMENTS:+--comments "$$COMMENTS"}

gradescope: ## l'archive d'un évaluateur de Gradescope, avec la solution : OUT=nom.zip | the archive of an autograder for Gradescope, with the solution: OUT=name.zip
	@$(call PYTHON_OF,grade) && "$$python" -m grader gradescope --out "$${OUT:-$$BUILD/autograder.zip}"

vpl: ## les fichiers d'exécution d'une activité VPL de Moodle, avec la solution : OUT=nom.zip | the execution files of a Moodle VPL activity, with the solution: OUT=name.zip
	@$(call PYTHON_OF,grade) && "$$python" -m grader vpl --out "$${OUT:-$$BUILD/vpl.zip}"

batch: ## évalue une classe : SUBMISSIONS=, OUT=, JOBS=2, NAMES=1, AGAIN=1, PUBLIC=1 | grades a class: SUBMISSIONS=, OUT=, JOBS=2, NAMES=1, AGAIN=1, PUBLIC=1
	@$(call PYTHON_OF,grade) && "$$python" -m grader batch $${SUBMISSIONS:+"$$SUBMISSIONS"} $${OUT:+--out "$$OUT"} \
	    $${JOBS:+--jobs "$$JOBS"} $${SCHEDULER:+--scheduler "$$SCHEDULER"} $${ISOLATION:+--isolation "$$ISOLATION"} \
	    $${AGAIN:+--again} $${NAMES:+--names} $${GALLERY:+--gallery} $${WORKSHEET:+--worksheet "$$WORKSHEET"} \
	    $${HINT:+--hint "$$HINT"} $${EXPECTED:+--expected "$$EXPECTED"} $${YES:+--yes} $${PUBLIC:+--public}

alike: ## les rendus qui se ressemblent, à regarder : SUBMISSIONS=, OUT=, PAST=, NAMES=1 | submissions that are alike, to look at: SUBMISSIONS=, OUT=, PAST=, NAMES=1
	@$(call PYTHON_OF,grade) && "$$python" -m grader alike $${SUBMISSIONS:+"$$SUBMISSIONS"} $${OUT:+--out "$$OUT"} \
	    $${PAST:+--past "$$PAST"} $${NAMES:+--names}

purge: ## efface les résultats d'une classe : OUT=dossier | erases the results of a class: OUT=folder
	@$(call PYTHON_OF,grade) && "$$python" -m grader purge $${OUT:+"$$OUT"}

oral: ## cinq questions sur un rendu, avec leurs réponses : SUBMISSION=, TP=2 | five questions on a submission, with their answers: SUBMISSION=, TP=2
	@$(call PYTHON_OF,grade) && "$$python" -m grader oral "$$SUBMISSION" --build "$$BUILD" $${TP:+--tp "$$TP"}

lab: ## ouvre les carnets : TP=2, MRT_LANG=en | opens the notebooks: TP=2
	@$(call PYTHON_OF,lab) && "$$python" -m grader.lab $${TP:+--tp "$$TP"}

notebooks: ## refait les carnets depuis leurs textes : PICTURES=1 redessine leurs images | makes the notebooks from their texts: PICTURES=1 draws their images again
	@$(call PYTHON_OF,lab) && "$$python" -m grader.authoring.workbook.notebooks $${PICTURES:+--pictures}

figures: ## les figures du sujet, dans build/figures/ | the handout's figures, in build/figures/
	@$(call PYTHON_OF,lab) && "$$python" -m grader.authoring.drawings.figures --build "$$BUILD"

expected: ## refait les données attendues : SEED=7 OUT=dossier ; une seule : SUITE=, PICTURE=, MISTAKE= | makes the expected data again: SEED=7 OUT=folder; one thing of it: SUITE=, PICTURE=, MISTAKE=
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.expected.command $${SEED:+--seed "$$SEED"} $${OUT:+--out "$$OUT"} \
	    $${SUITE:+--suite "$$SUITE"} $${PICTURE:+--picture "$$PICTURE"} $${MISTAKE:+--mistake "$$MISTAKE"}

new: ## les fichiers à compléter : EXERCISE=TP3.B3 FUNCTION=, CHECK= SUITE=, MISTAKE= EXERCISE= | stubs of the files to write: EXERCISE=TP3.B3 FUNCTION=, CHECK= SUITE=, MISTAKE= EXERCISE=
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.new \
	    $${EXERCISE:+--exercise "$$EXERCISE"} $${FUNCTION:+--function "$$FUNCTION"} $${CHECK:+--check "$$CHECK"} \
	    $${SUITE:+--suite "$$SUITE"} $${MISTAKE:+--mistake "$$MISTAKE"} $${WORTH:+--worth "$$WORTH"}

calibrate: ## règle les limites des images sur des programmes justes | sets the limits of pictures by right programs
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.expected.pictures

prove: ## prouve que les notes sont justes (long, se reprend) : PART=known, SAMPLE=3, JOBS=2, AGAIN=1 | proves the marks right (long, goes on): PART=known, SAMPLE=3, JOBS=2, AGAIN=1
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.proof --build "$$BUILD" $${PART:+--part "$$PART"} \
	    $${SAMPLE:+--sample "$$SAMPLE"} $${JOBS:+--jobs "$$JOBS"} $${AGAIN:+--again}

skeleton: ## refait les fichiers à compléter depuis reference/ | makes the files to complete from reference/
	@$(call PYTHON_OF,grade) && "$$python" -m grader.authoring.skeleton.skeleton && "$$python" -m grader.authoring.skeleton.originals

# The C that is laid out alike; the submissions of the tests are as wild as they are.
C_FILES = core_c/*.[ch] notebooks/first_steps/*.c reference/*.[ch] grader/build/shim/*.c grader/execution/*.c grader/setup/*.c grader/authoring/bench/*.c grader/authoring/expected/pictures/*.c grader/tests/setup/program/*.c
format: ## met le C et le Python en forme | lays out the C and the Python
	@$(call PYTHON_OF,dev) && "$$python" -m ruff check --no-cache --fix-only . && "$$python" -m ruff format --no-cache . && \
	    "$${python%/*}/clang-format" -i $(C_FILES)

lint: ## relit le C et le Python | checks the C and the Python
	@$(call PYTHON_OF,dev) && set -ex && "$$python" -m ruff check --no-cache . && \
	    "$$python" -m ruff format --no-cache --check . && \
	    "$${python%/*}/clang-format" --dry-run -Werror $(C_FILES) && \
	    printf '%s\n' core_c/*.c reference/*.c | \
	        xargs -P 2 -I FILE "$${python%/*}/clang-tidy" --quiet FILE -- -std=gnu11 -Icore_c && \
	    "$$python" -m mypy --cache-dir "$$BUILD/mypy"

test: ## les tests du projet, un quart d'heure sur deux cœurs | the tests of the project, a quarter of an hour on two cores
	@$(MAKE) --no-print-directory -j 2 lint suite

test-all: test ## et ceux qui passent tout en revue | and those that go through everything
	@$(call PYTHON_OF,dev) && set -x && $(PYTEST) -m exhaustive

# The generated files are those of their sources; the tests, side by side, one more at a time than there are cores
# since many wait.
PYTEST = "$$python" -m pytest -p xdist -n "$$(($$(getconf _NPROCESSORS_ONLN) + 1))" --dist loadscope
.PHONY: suite
suite:
	@$(call PYTHON_OF,dev) && set -x && "$$python" -m grader.authoring.skeleton.skeleton --check && \
	    "$$python" -m grader.authoring.skeleton.originals --check && \
	    "$$python" -m grader.authoring.workbook.notebooks --check && $(PYTEST)

bench: ## les mesures de performance ; d'une classe : CLASS=200, KILLS=10 | the benchmarks; of a class: CLASS=200, KILLS=10
	@$(call PYTHON_OF,dev) && case "$$CLASS,$$KILLS" in \
	    ,) "$$python" -m grader.authoring.bench --build "$$BUILD" ;; \
	    ,*) "$$python" -m grader.authoring.bench.kills --trials "$$KILLS" --build "$$BUILD" ;; \
	    *) "$$python" -m grader.authoring.bench.batch --size "$$CLASS" --build "$$BUILD" ;; esac

image: ## l'image d'un conteneur avec tous les outils : IMAGE=nom, HUB=version | the image of a container with all the tools: IMAGE=name, HUB=version
	@sh grader/setup/image.sh

wheelhouse: ## les paquets pour une salle sans réseau | the packages for a room without a network
	@sh grader/setup/environment.sh wheelhouse "$$BUILD/wheelhouse"

clean: ## efface build/ et core_c/mrt | removes build/ and core_c/mrt
	@rm -rf build core_c/mrt

# For the tests of this file.
print-flags:
	@sh grader/setup/program.sh flags
