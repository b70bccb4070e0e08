# make demo    fly the example mission         make test    run the tests
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# The integration tests wait more than they compute.
JOBS ?= 3

.PHONY: help demo test soak bench lint types contracts check docs clean

help:
	@sed -n 's/^\([a-z]*\):.*## /\1	/p' $(MAKEFILE_LIST)

# An environment is made anew only when pyproject.toml has changed since: each stamp is a copy of
# it. The sources are installed in place, so that edits need no new one.
define install
	@cmp -s pyproject.toml $(VENV)/$(2).stamp || { \
		echo "Installing into $(VENV)"; \
		$(PYTHON) -m venv $(VENV) && \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '$(1)' && \
		cp pyproject.toml $(VENV)/$(2).stamp; }
endef

.PHONY: base base-alone dev
base:
	@cmp -s pyproject.toml $(VENV)/dev.stamp || $(MAKE) --no-print-directory base-alone
base-alone:
	$(call install,.,base)
# MAVProxy is a client in tests, run as a process of its own; without --no-deps it brings 1 GB.
dev:
	$(call install,.[dev],dev)
	@$(BIN)/python -c 'import MAVProxy' 2>/dev/null || \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps 'MAVProxy>=1.8.75'

demo: base ## fly the built-in example mission
	$(BIN)/uavbridge launch

test: dev ## unit and integration tests
	$(BIN)/pytest -n $(JOBS) --dist worksteal -m "not soak"

soak: dev ## the tests that take minutes
	$(BIN)/pytest -n $(JOBS) -m soak --timeout 3600

bench: dev ## measure speed
	@for script in tests/benchmarks/bench_*.py; do echo "== $$script"; $(BIN)/python $$script || exit 1; done

lint: dev ## style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: dev ## strict type check
	$(BIN)/mypy

contracts: dev ## who may import what
	$(BIN)/lint-imports

check: lint types contracts test ## all that CI checks

docs: dev ## write the generated pages of docs/reference anew
	$(BIN)/python docs/generate.py

clean: ## remove environment and caches
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
