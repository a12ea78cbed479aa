# Everything that is run by name. The environment in .venv is made, and made again when the project's needs change.
#
#   make demo         a star collapses: runs/pulsar_collapse with a netCDF file and pictures
#   make test         all tests but the long ones (23 minutes on two quiet cores of an AMD EPYC)
#   make test-quick   the quick ones (under 3 minutes)
#   make test-full    the long ones, hours in all; can be stopped and goes on where it was; results in tests/results
#   make test-status  which results of the long ones are valid for this code and this kind of processor, which stale
#   make bench        the benchmarks
#   make notebooks    executes the notebooks of sims/notebooks and writes them
#   make docs         the guide, the scenes, the notebooks and the Python interface as a site: build/site/index.html
#   make lint         format, lint, types, import order
#   make venv         only the environment

SHELL := /bin/bash
.DELETE_ON_ERROR:
.PHONY: help demo test test-quick test-full test-status bench notebooks docs lint venv clean

VENV := .venv
RUN := $(VENV)/bin/python
NEEDS := pyproject.toml .ci/constraints.txt
WORKERS ?= 2
# What the benchmarks share; the other files of tests/benchmarks are programs.
BENCH_PARTS := scaling_plan precision_table fair_times gravity_codes point_sets evrard_cloud evrard_codes

# Compiled code is kept between runs, inside the checkout: a fresh clone is then a fresh start.
export JAX_COMPILATION_CACHE_DIR ?= $(CURDIR)/.cache/jax
export JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS ?= 0.3
export NUMBA_CACHE_DIR ?= $(CURDIR)/.cache/numba
export ASTROINERTIA_CACHE ?= $(CURDIR)/.cache/astroinertia
# Tests start hundreds of processes, which read bytecode if it is kept (empty: it is, whatever the caller's shell says).
export PYTHONDONTWRITEBYTECODE :=
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_CONSTRAINT := $(CURDIR)/.ci/constraints.txt

# The first Python that is 3.11 or newer.
PYTHON ?= $(shell for each in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$each -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$each && break; done)

help:
	@sed -n 's/^#   //p' Makefile

$(VENV)/made: $(NEEDS)
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed." >&2; exit 1; }
	@rm -rf $(VENV)
	$(PYTHON) -m venv $(VENV)
	@touch $@

# Only what is asked for is installed: running needs less than testing.
$(VENV)/run: $(VENV)/made
	$(RUN) -m pip install -qq -e .
	@touch $@

$(VENV)/test: $(VENV)/made
	$(RUN) -m pip install -qq -e '.[test]'
	@$(RUN) -m pip install -qq -e '.[reboundx]' || echo "reboundx cannot be installed here: comparisons with it are skipped"
	@$(RUN) -m pip install -qq -e '.[mpi]' mpich || echo "MPI cannot be installed here: runs by several processes are skipped"
	@$(RUN) -m pip install -qq -e '.[fuzz]' || echo "atheris cannot be installed here: the fuzzer is skipped"
	@touch $@ $(VENV)/run

$(VENV)/bench: $(VENV)/test
	@$(RUN) -m pip install -qq -e '.[bench]' || echo "not all other codes can be installed here: comparisons with them are skipped"
	@touch $@

$(VENV)/lint: $(VENV)/made
	$(RUN) -m pip install -qq -e '.[lint]'
	@touch $@ $(VENV)/run

$(VENV)/docs: $(VENV)/made
	$(RUN) -m pip install -qq -e '.[docs]'
	@touch $@ $(VENV)/run

venv: $(VENV)/test

demo: $(VENV)/run
	@if [ -e runs/pulsar_collapse/manifest.json ]; then $(RUN) -m astroinertia resume runs/pulsar_collapse; \
	else $(RUN) -m astroinertia run sims/pulsar_collapse.toml --output runs/pulsar_collapse; fi
	@$(RUN) -m astroinertia show runs/pulsar_collapse

test: $(VENV)/test
	$(RUN) -m pytest -m "not full" --kept -n $(WORKERS) --dist worksteal

test-quick: $(VENV)/test
	$(RUN) -m pytest -m "quick and not full" -n $(WORKERS) --dist worksteal

test-full: $(VENV)/test
	$(RUN) -m pytest -m full --kept

test-status: $(VENV)/test
	@$(RUN) -m tests.full_results

bench: $(VENV)/bench
	@for each in $(filter-out $(BENCH_PARTS:%=tests/benchmarks/%.py),$(wildcard tests/benchmarks/*.py)); do \
		echo "$$each"; $(RUN) $$each || exit 1; done

notebooks: $(VENV)/test
	$(RUN) sims/notebooks/execute.py

docs: $(VENV)/docs
	$(RUN) .ci/docs/build_site.py
	@echo "wrote build/site/index.html"

lint: $(VENV)/lint
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/pyright
	$(VENV)/bin/lint-imports

clean:
	rm -rf $(VENV) .cache build dist
