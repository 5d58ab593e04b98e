# make help lists the targets. Everything is written in this checkout: .venv (tools), out (results).
PYTHON ?= python3
BIN := .venv/bin

# A sourced ROS installation and the environment's own ROS do not mix.
unexport PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH RMW_IMPLEMENTATION
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE VIRTUAL_ENV
export ROS_LOG_DIR := $(CURDIR)/out/log
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
export DAMPER_TEST_ROS := required

.DEFAULT_GOAL := help
.PHONY: help env test check format demo pictures bench bench-diagnosis bench-sensitivity bench-recordings bench-plan bench-parameters bench-hidden real-data bench-node soak fuzz man package clean

help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/make \1|\2/' | column -t -s '|'

env: ## set up .venv (ROS 2 Jazzy, messages, project, test tools); quick when it is up to date
	@tools/environment "$(PYTHON)"

test: env ## run all tests on all processors, including those of the ROS node (browser settings go to out)
	@XDG_CONFIG_HOME="$(CURDIR)/out/home" XDG_CACHE_HOME="$(CURDIR)/out/home" OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
		$(BIN)/python -m pytest -n auto --dist loadfile $(PYTEST_ARGUMENTS)

check: env ## style, faults, types and the imports of every test, without running any
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@mkdir -p out && $(BIN)/python -m pytest --collect-only -qq > out/collected.txt || { tail -n 30 out/collected.txt; exit 1; }

format: env ## correct what make check finds, if possible automatically
	@$(BIN)/ruff check --fix-only --quiet .
	@$(BIN)/ruff format .

demo: env ## the example of damper-estimator demo, then the live node over DDS on the same recording
	@PATH="$(CURDIR)/$(BIN):$$PATH" tools/demo

.PHONY: docs
docs: env ## build the documentation into out/site; it loads nothing from a network
	@NO_MKDOCS_2_WARNING=1 NUMBA_DISABLE_JIT=1 $(BIN)/mkdocs build --strict --quiet
	@$(BIN)/python tools/docs/check.py out/site

pictures: env ## the pictures of README.md, docs/hidden_effect.md and docs/studio.md (needs chromium)
	@$(BIN)/python tools/docs/pictures.py
	@PATH="$(CURDIR)/$(BIN):$$PATH" tools/pictures

real-data: env ## the tables of docs/real_data.md, if the recordings are available
	@$(BIN)/python benchmarks/real_story.py -o docs/real_data.md
	@$(BIN)/python benchmarks/real_data.py -o docs/real_data.md

bench: env ## measure speed and print it, 20 minutes (bench-node: the full bars of the node)
	@for file in $(filter-out %/bench_diagnosis.py %/bench_hidden.py %/bench_plan.py %/bench_parameters.py %/bench_sensitivity.py,$(wildcard benchmarks/bench_*.py)); do $(BIN)/python $$file || exit 1; done

bench-node: env ## the node against a relay at full length: 60 s, five rounds, 25 minutes on a quiet machine
	@$(BIN)/python benchmarks/bench_node.py --full

bench-diagnosis: env ## hide effects in 150 randomly drawn dampers and check whether they are found (FULL=1: 600)
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench_diagnosis.py -o docs/diagnosis_bench.md

bench-sensitivity: env ## the names of a run of bench-diagnosis with every threshold of the ranking at -30 and +30 % (SEED=its seed)
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench_sensitivity.py --seed $(SEED) -o docs/diagnosis_bench.md

bench-recordings: env ## every verb on real recordings, whole and in windows: no traceback, no contradiction (FULL=1: all)
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/every_recording.py $(RECORDINGS)

bench-plan: env ## plan tests for 60 randomly drawn ties, drive them on the plant, and check whether the ties break; resumable
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench_plan.py -o docs/planning.md $(PLAN)

bench-parameters: env ## plan tests for the parameters of 20 randomly drawn models, drive them, and compare the standard errors, 20 minutes
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench_parameters.py $(PARAMETERS)

bench-hidden: env ## the same for the listed cases of the project's plant (FULL=1: all)
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench_hidden.py -o out/bench_hidden.md

soak: env ## half an hour of the closed loop under random faults, judged against the truth (SOAK="SECONDS RATE")
	@$(BIN)/python benchmarks/soak.py $(SOAK)

FUZZ_TARGETS ?= bags bench models maps wire parameters
FUZZ_SECONDS ?= 600
fuzz: env ## fuzz bags, bench files, YAML, messages and parameters, 10 minutes each; findings in out/fuzz
	@$(BIN)/python -m pip install -qq atheris || echo "no atheris here: random mutation instead of coverage guidance"
	@rm -rf out/fuzz; for target in $(FUZZ_TARGETS); do $(BIN)/python benchmarks/fuzz.py $$target $(FUZZ_SECONDS) || exit 1; done
	@ls out/fuzz/*.txt 2>/dev/null && exit 1 || echo "nothing found"

man: env ## the manual pages of the command line, into man
	@$(BIN)/python tools/man_pages

package: man ## wheel and source distribution with the manual pages, into dist, checked by twine
	@rm -rf dist build
	@$(BIN)/python -m pip install -qq build twine
	@$(BIN)/python -m build --outdir dist .
	@$(BIN)/python -m twine check --strict dist/*

clean: ## remove everything that make created: .venv, out, caches
	rm -rf .venv out build dist install log man .pytest_cache .ruff_cache .mypy_cache .hypothesis *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
