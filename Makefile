# Needs only python3 (3.11 or later) and make. Everything is installed into .venv.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
TESTS ?=

.DEFAULT_GOAL := help
.PHONY: help demo test test-long check docs readers installed scoreboard validate bench format console-parts clean

help:  ## Show what can be made.
	@sed -n 's/^\([a-z-]*\):.*##/  make \1 \t/p' $(firstword $(MAKEFILE_LIST))

demo: .venv/installed  ## Run the main job: a 6x6 knit, two biaxial cycles to 40 %.
	$(BIN)/knitlab run examples/biaxial_cycle.yaml

test: .venv/installed-dev  ## Run the tests, slow ones left out. TESTS=path picks some.
	@# Kernels that are not there yet are compiled first: four processes would compile each of them.
	@rm -rf build/first && mkdir -p build
	@$(BIN)/knitlab run examples/biaxial_small.yaml --no-pictures --quiet --out build/first >build/first.txt
	$(BIN)/pytest --numprocesses 4 --dist worksteal $(TESTS)

test-long: .venv/installed-dev  ## Run the slow tests too: storms of jobs, the paper's figures (hours). TESTS=path picks some.
	$(BIN)/pytest -m "" $(TESTS)

check: .venv/installed-dev  ## Check format, lint, types and the direction of imports.
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

readers: .venv/installed-dev  ## Read files of real runs with people's own readers.
	tests/readers/run.sh $(BIN)/python

docs: .venv/installed-dev  ## Build the site of the documentation into build/docs; warnings are errors.
	$(BIN)/mkdocs build --quiet --strict

installed: .venv/bin/python  ## Build the wheel, install it apart and use it outside the sources.
	tests/installed/run.sh $(BIN)/python

validate: .venv/installed-dev  ## Print bar and figure of every validation, slow ones included; keep them in docs/validation.md.
	$(BIN)/pytest tests/validation -m "" --quiet --bars docs/validation.json $(TESTS)

scoreboard: .venv/installed  ## Score the claims of the paper in quick mode, some minutes.
	$(BIN)/knitlab scoreboard --quick --jobs 2

bench: .venv/installed-dev  ## Time the main job.
	$(BIN)/python -m benchmarks

format: .venv/installed-dev  ## Format the code and apply safe fixes.
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

console-parts:  ## Bundle the console's parts anew from npm's packages (needs Node).
	cd app/service/console/vendor && npm install --silent --no-package-lock && npm run --silent build && rm -rf node_modules

clean:  ## Remove what was installed, built and cached here.
	rm -rf .venv .venv-installed .venv-readers build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# A stamp that is newer than its sources means: nothing to install.
.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "knitlab needs Python 3.11 or later")'
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml constraints.txt | .venv/bin/python
	@echo "Installing knitlab into .venv (once)"
	$(PIP) --editable '.[printing]'
	@touch $@

.venv/installed-dev: pyproject.toml constraints.txt | .venv/bin/python
	@echo "Installing knitlab and its checkers into .venv (once)"
	$(PIP) --editable '.[printing,test,dev]'
	@touch $@ .venv/installed
