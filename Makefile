# Needs Debian's python3 (3.11 or newer) and make, nothing else: `make demo` and `make test` set up .venv on their first run.

PYTHON  ?= python3
VENV    ?= .venv
EXAMPLE ?= cantilever-plate
WORKERS ?= 2
BIN     := $(VENV)/bin
SOURCES := src tests tools benchmarks verification examples
PRESENT  = $(wildcard $(SOURCES))

.DEFAULT_GOAL := help
.PHONY: help demo test lint format verify bench history docs clean

help:  ## show this list
	@sed -n 's/^\([a-z]*\):[^#]*## \(.*\)/  make \1|\2/p' $(MAKEFILE_LIST) | awk -F'|' '{ printf "%-16s %s\n", $$1, $$2 }'

# A stamp is older than pyproject.toml when the dependencies may have changed; the set-up is then done again.
$(VENV)/.ready-%: pyproject.toml tools/bootstrap.py
	@$(PYTHON) tools/bootstrap.py $(VENV) $(subst +,$(comma),$*) $@

comma := ,

demo: $(VENV)/.ready-viz  ## run the example EXAMPLE=cantilever-plate into results/, with pictures and a report
	@$(BIN)/lamella run $(EXAMPLE) --out results/$(EXAMPLE) --overwrite
	@echo
	@echo "Pictures, report and data of this run:"
	@find results/$(EXAMPLE) -type f | sort | sed 's/^/  /'

test: $(VENV)/.ready-viz+test  ## run the tests
	@$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

lint: $(VENV)/.ready-lint+test  ## style, formatting, types and the architecture
	$(BIN)/ruff check $(PRESENT)
	$(BIN)/ruff format --check $(PRESENT)
	$(BIN)/pyright
	$(BIN)/python -m pytest -q tests/test_architecture.py

format:  $(VENV)/.ready-lint+test  ## format the sources
	$(BIN)/ruff check --fix $(PRESENT)
	$(BIN)/ruff format $(PRESENT)

verify: $(VENV)/.ready-viz+test  ## the whole verification and the slow tests (nightly)
	$(BIN)/lamella verify
	$(BIN)/python -m pytest -m slow

bench: $(VENV)/.ready-bench  ## time lamella and other codes on the same cases, into results/bench
	@$(BIN)/lamella bench

history: $(VENV)/.ready-history  ## time lamella's parts, keep the times in .benchmarks and compare them with the last ones
	@$(BIN)/python -m pytest benchmarks -q --benchmark-autosave --benchmark-compare --benchmark-columns=min,median,rounds

docs: $(VENV)/.ready-docs  ## build the pages of docs/ into build/docs
	$(BIN)/mkdocs build --quiet --strict --site-dir build/docs
	@echo "open build/docs/index.html"

clean:  ## remove the environment, results and caches
	rm -rf $(VENV) results build .pytest_cache .ruff_cache
