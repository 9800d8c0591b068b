# Thin targets over tools/bootstrap.py, which also runs alone: python tools/bootstrap.py test
PYTHON ?= python3

.PHONY: demo check test test-all coverage docs figures lint bench clean

demo check test test-all coverage docs figures lint bench:
	@$(PYTHON) tools/bootstrap.py $@

clean:
	rm -rf .venv build dist docs/_build docs/auto_examples .coverage .mypy_cache .pytest_cache .ruff_cache .hypothesis .benchmarks .import_linter_cache
