# make explore   set up (first time) and start the app        ARGS="--ckpt weak.pt --port 9000"
# make test      every test, those in a real browser included  ARGS="tests/unit -k landscape"
# make check     format, lint, types
# make bench     what is fast, measured
# make clean     remove everything that was built, the environment included

PYTHON ?= python3
ARGS ?=
VENV := .venv
BIN := $(VENV)/bin
NPM := PATH="$(CURDIR)/$(BIN):$$PATH" npm
PACKAGES := core robot app static checkpoints

.PHONY: explore test check format bench browser clean
.DELETE_ON_ERROR:
.NOTPARALLEL:

explore: $(VENV)/installed
	@exec $(BIN)/rnnpb-explorer $(ARGS)

# The commands do the same for themselves (core/threads.py): threads that wait do not spin.
test: export GOMP_SPINCOUNT ?= 1000
test: $(VENV)/installed-test browser
	$(BIN)/python -m pytest $(ARGS)

check: $(VENV)/installed-dev node_modules/installed
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	@mkdir -p build/types/rnnpb_explorer
	@for package in $(PACKAGES); do \
	    ln -sfn ../../../$$package build/types/rnnpb_explorer/$$package; \
	done
	$(BIN)/mypy $(PACKAGES:%=-p rnnpb_explorer.%)
	$(NPM) run --silent check

format: $(VENV)/installed-dev node_modules/installed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(NPM) run --silent format

bench: $(VENV)/installed
	$(BIN)/python benchmarks/run.py $(ARGS)

# A Chromium for the browser tests: the one that is there, or a new one.
browser: $(VENV)/installed-test
	@$(BIN)/python tests/browser/install_chromium.py

# What checks static/web, run by the node in the environment; none of it is there at run time.
node_modules/installed: package-lock.json .npmrc $(VENV)/installed-dev
	$(NPM) ci --silent
	@touch $@

# One stamp for each set of extras; a stamp is older than what it was installed from, or up to date.
$(VENV)/installed: EXTRAS =
$(VENV)/installed-test: EXTRAS = [test]
$(VENV)/installed-dev: EXTRAS = [dev]
$(VENV)/installed $(VENV)/installed-test $(VENV)/installed-dev: pyproject.toml constraints.txt | $(BIN)/pip
	@$(BIN)/python scripts/install.py -c constraints.txt -e '.$(EXTRAS)'
	@touch $@

$(BIN)/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "needs Python 3.11 or newer; call make with PYTHON=/path/to/python3.11" >&2; exit 1; }
	@echo "making an environment in $(VENV)" >&2
	@$(PYTHON) -m venv $(VENV)

clean:
	rm -rf $(VENV) node_modules build dist test-artifacts *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
	find $(PACKAGES) tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
