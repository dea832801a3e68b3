# Two commands matter: `make bench` and `make test`. Every target sets up its own environment.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   ?= .venv
BIN    := $(VENV)/bin
OUT    ?= results/quick
CASES  ?= 1000000
JOBS   ?= 1
CORE   := $(VENV)/.core
DEV    := $(VENV)/.dev
DOCS   := $(VENV)/.docs

.PHONY: bench test test-all coverage lint perf fuzz mutation docs clean help

help:
	@echo "make bench     set up, then scan, match, evaluate and report on the built-in shapes"
	@echo "make test      set up, then run the default tests"
	@echo "make test-all  the same with the slow tests"
	@echo "make coverage  the default tests, and the share of branches that they take"
	@echo "make lint      ruff (lint, format) and mypy"
	@echo "make perf      time and memory of every stage"
	@echo "make fuzz      broken files for every reader: CASES=$(CASES) in JOBS=$(JOBS) processes"
	@echo "make mutation  are formulas tested? changes operators and numbers of a copy (hours); MODULES=..."
	@echo "make docs      the pages of docs/ and the reference, as build/docs/index.html"

$(CORE): pyproject.toml
	@test -n "$(PYTHON)" || { echo "no python3.11 on PATH; install it or set PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "$(PYTHON) is older than Python 3.11; set PYTHON=/path/to/python3.11" >&2; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "Installing medialbench into $(VENV) (about 1 GB, a minute or two) ..."
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e .
	@echo "Compiling the numerical kernels (once, about a minute) ..."
	@$(BIN)/python -m medial.precompile & first=$$!; \
		$(BIN)/python -m evaluation.compile_metrics; second=$$?; wait $$first && exit $$second
	@touch $@

$(DEV): $(CORE)
	@echo "Installing the development tools into $(VENV) ..."
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[dev,peers]'
	@touch $@

bench: $(CORE)
	@$(BIN)/medialbench run quick -o $(OUT)

# A file of tests stays on one worker, which makes what its tests share once.
test: $(DEV)
	$(BIN)/python -m pytest -m "not slow" -n auto --dist loadfile

test-all: $(DEV)
	$(BIN)/python -m pytest -n auto --dist loadfile

# Kernels are measured uncompiled, in a run of their own: what Numba compiles is not traced.
coverage: $(DEV)
	$(BIN)/python -m coverage erase
	$(BIN)/python -m coverage run -m pytest -q -m "not slow" -n auto --dist loadfile
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m coverage run -m pytest -q -m uncompiled -n auto
	$(BIN)/python -m coverage combine -q
	$(BIN)/python -m coverage report --skip-covered --sort=cover

lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

perf: $(DEV)
	$(BIN)/python -m pytest tests/benchmarks --benchmark-only -s \
		--benchmark-time-unit=ms --benchmark-columns=min,median,max,rounds

fuzz: $(DEV)
	$(BIN)/python -m tests.fuzzing.fuzz --count $(CASES) --processes $(JOBS)

mutation: $(DEV)
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[mutation]'
	$(BIN)/python -m tests.mutation.mutate $(MODULES)

$(DOCS): $(CORE)
	@echo "Installing Sphinx into $(VENV) ..."
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[docs]'
	@touch $@

docs: $(DOCS)
	@$(BIN)/python -m sphinx -q -W --keep-going -j auto -b html -d build/doctrees docs build/docs
	@echo "build/docs/index.html"

clean:
	rm -rf $(VENV) build dist *.egg-info
