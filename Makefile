# No setup is needed: each target first makes .venv. For another Python, use
# another environment: `make test PYTHON=python3.13 VENV=.venv-3.13`.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
RUNTIME := $(VENV)/.runtime
DEV := $(VENV)/.dev
DOCS := $(VENV)/.docs
SOURCES := remosplat_drake apps tests docs/hooks

# The tests start hundreds of processes. Where this variable is set, as in many
# containers, each of them would compile all of the project's modules again.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: run test test-all smoke browser pictures fuzz check lint format types \
  docs bench kernels wheel clean help

help: ## List the targets.
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

run: $(RUNTIME) ## Run the default scenario and serve its page.
	$(BIN)/remosplat run $(ARGS)

test: $(DEV) ## Run the default test suite.
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder \
	  -m "not slow and not gpu" $(ARGS)

test-all: $(DEV) ## Run all tests, also slow ones, with more examples.
	THOROUGH=1 $(BIN)/pytest $(ARGS)

smoke: $(DEV) ## Run the few tests that CI runs on every Python.
	$(BIN)/pytest -m smoke $(ARGS)

browser: $(DEV) ## Run the page's tests, which need chromium.
	$(BIN)/pytest -m browser $(ARGS)

pictures: $(DEV) ## Take the pictures that the page's tests compare again.
	RETAKE_PICTURES=1 $(BIN)/pytest tests/commands/test_run_pictures.py \
	  tests/cockpit/test_cockpit_pictures.py

fuzz: $(DEV) ## Test the readers with mutated files: ARGS="--hours 2 --seed 7".
	$(BIN)/python -m tests.fuzz $(ARGS)

check: lint types test ## Check style, formatting and types, and run the tests.

lint: $(DEV) ## Check style and formatting.
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)

format: $(DEV) ## Correct style and formatting.
	$(BIN)/ruff check --fix $(SOURCES)
	$(BIN)/ruff format $(SOURCES)

types: $(DEV) ## Check types.
	$(BIN)/pyright

# No --quiet: with it, a strict build does not count the warnings.
docs: $(DOCS) ## Build the documentation in site/; fails on warnings.
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build $(ARGS)

bench: $(DEV) ## Measure the control tick, and print a table.
	$(BIN)/remosplat bench $(ARGS)

kernels: $(DEV) ## Update the list of the kernels that runs need.
	$(BIN)/python -m apps.packaging.kernel_list

wheel: $(DEV) ## Build a wheel with compiled kernels for this Python.
	$(BIN)/python -m apps.packaging.wheel $(ARGS)

clean: ## Remove the environments and all built files.
	rm -rf .venv .venv-* build dist site *.egg-info

$(VENV)/pyvenv.cfg:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(RUNTIME): pyproject.toml | $(VENV)/pyvenv.cfg
	$(BIN)/python -m pip install --quiet --editable '.[meshes]'
	@touch $@

$(DEV): pyproject.toml | $(VENV)/pyvenv.cfg
	$(BIN)/python -m pip install --quiet --editable '.[meshes,reconstruction,formats,ros2,panda,record,live,calibration,cockpit,robots,ur]' --group dev
	@touch $@ $(RUNTIME)

$(DOCS): pyproject.toml | $(DEV)
	$(BIN)/python -m pip install --quiet --group docs
	@touch $@
