# Two commands are enough: `make bringup` and `make test` set up all that they need.

PYTHON ?= python3
VENV ?= .venv
ARGS ?=
# Extras of setup.cfg that make env installs beside what every environment has.
EXTRAS ?=
# Tests with programs in real time that run at a time.
WORKERS ?= 3
# Where LeRobot is installed for its tests.
LEROBOT ?= build/lerobot

# An environment that exists keeps its Python unless one is named on the command line.
this_python := $(if $(filter command environment,$(firstword $(origin PYTHON))),--this-python)
environment = @command -v $(PYTHON) > /dev/null \
	|| { echo 'env: there is no $(PYTHON); install Python 3.10 to 3.13, or name one: make PYTHON=python3.12' >&2; exit 1; }; \
	$(PYTHON) scripts/env.py --venv $(VENV) $(this_python)

.DEFAULT_GOAL := help
.PHONY: help env dist bringup test test-page test-lerobot lint mutants docs bench bench-planning bench-ik bench-timing bench-simulation clean

help: ## show this
	@echo 'usage: make TARGET [ARGS="..."] [PYTHON=python3.12] [VENV=.venv]'
	@sed -n 's/^\([a-z-]*\):.*## /  \1|/p' $(firstword $(MAKEFILE_LIST)) | column -t -s '|'

env: ## prepare the Python environment in .venv; with extras of setup.cfg: make env EXTRAS="data gym"
	$(environment) $(addprefix --with ,$(EXTRAS))

dist: ## wheels for installations without a compiler, in dist/: make dist ARGS="--python 3.12"
	$(environment)
	@$(VENV)/bin/python scripts/dist.py $(ARGS)

bringup: ## start simulation, move_group and the page: make bringup ARGS="robot:=sunday"
	$(environment)
	@exec $(VENV)/bin/armsim bringup web:=true $(ARGS)

test: ## run the whole test suite: make test ARGS="-k name"
	$(environment) --with test
	@$(VENV)/bin/python scripts/run_tests.py --workers $(WORKERS) $(ARGS)

test-page: ## test what pages may do in headless Chromium, which must be installed
	$(environment) --with test
	@$(VENV)/bin/python -m pytest -m browser test/nodes/web test/nodes/bridge $(ARGS)

test-lerobot: ## what LeRobot opens and finds, in build/lerobot: needs python3.12, and 6 GB for it
	@test -x $(LEROBOT)/bin/python || python3.12 -m venv $(LEROBOT)
	@$(LEROBOT)/bin/pip install -q -e '.[gym,data]' -e distributions/lerobot_robot_armsim 'lerobot[dataset]' pytest
	@HF_HUB_OFFLINE=1 HF_HOME=$(CURDIR)/build/lerobot_home $(LEROBOT)/bin/python -m pytest \
		-c /dev/null --rootdir=. --noconftest -p no:armsim test/distributions $(ARGS)

lint: ## style, types, import contracts, and words
	$(environment) --with test --with lint
	@$(VENV)/bin/ruff check .
	@$(VENV)/bin/mypy
	@$(VENV)/bin/python scripts/page_types.py
	@$(VENV)/bin/lint-imports
	@$(VENV)/bin/python scripts/language.py

mutants: ## change the package in random places and report what no test notices; about two hours
	$(environment) --with test --with mutants
	@$(VENV)/bin/python scripts/mutants.py $(ARGS)

docs: ## the documentation as HTML, with a reference of the library: build/docs/index.html
	$(environment) --with docs
	@$(VENV)/bin/python -m sphinx -q -W --keep-going -b html docs build/docs
	@echo 'docs: build/docs/index.html'

bench: ## start-up times and the lateness of the control tick
	$(environment) --with test
	@$(VENV)/bin/python -m benchmarks $(ARGS)

bench-planning: ## planning problems for us and our peers, judged; about half an hour
	$(environment) --with test --with bench
	@$(VENV)/bin/python -m benchmarks planning --report docs/benchmarks.md $(ARGS)
	@$(VENV)/bin/python -m benchmarks planning_named_states planning_service --runs 21

bench-ik: ## inverse kinematics of us and our peers
	$(environment) --with test --with bench
	@$(VENV)/bin/python -m benchmarks ik $(ARGS)

bench-simulation: ## what a simulated step costs beside bare MuJoCo
	$(environment) --with bench
	@$(VENV)/bin/python -m benchmarks simulation --report docs/benchmarks.md $(ARGS)

bench-timing: ## timing of random paths
	$(environment) --with test
	@$(VENV)/bin/python -m benchmarks timing --runs 50 $(ARGS)

clean: ## remove the environment and what builds and tools have left
	rm -rf $(VENV) build install log dist *.egg-info .pytest_cache .mypy_cache .ruff_cache \
		.import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
