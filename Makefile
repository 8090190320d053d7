# `make demo` and `make test` work from a fresh clone: see README.md.
# PYTHON=/path/to/python3.11 chooses the interpreter, WORKERS=N the number of test processes.
PYTHON ?=
WORKERS ?= 2
PYTEST_ARGS ?=

BIN := .venv/bin
RUN := .venv/.stamp-run
DEV := .venv/.stamp-dev

export PYTHON
export PYTHONUNBUFFERED = 1

.DEFAULT_GOAL := help
.PHONY: help demo test validate lint bench gl clean distclean

help: ## Show this list
	@grep -E '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

demo: $(RUN) gl ## Dock an AUV to a USV in waves -> results/demo/{video.mp4,plot.png,summary.json}
	$(BIN)/marine-mj demo

# The first import compiles the kernels; done once here, the workers only read the cache.
test: $(DEV) gl ## Run the tests
	@$(BIN)/python -c "import marine_mj"
	$(BIN)/python -m pytest -n $(WORKERS) $(PYTEST_ARGS)

validate: $(DEV) ## Run the validation -> results/validation.json, docs/validation.md, and the long tests
	$(BIN)/marine-mj validate
	$(BIN)/python -m pytest -n $(WORKERS) -m validation --ignore tests/validation

bench: $(RUN) ## Measure speed against its bars -> results/bench.json
	@mkdir -p results
	$(BIN)/marine-mj bench --json results/bench.json

lint: $(DEV) ## Check style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

gl: $(RUN)
	@sh scripts/setup.sh gl

# `dev` includes `run` and refreshes its stamp as well.
$(RUN): pyproject.toml
	@sh scripts/setup.sh run

$(DEV): pyproject.toml
	@sh scripts/setup.sh dev

clean: ## Remove what builds and tools leave behind (.venv and results stay)
	rm -rf build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -path ./.venv -prune -o -type d -name __pycache__ -exec rm -rf {} +

distclean: clean ## Remove .venv and results as well
	rm -rf .venv results
