# make test, make lint, ...: each with the environment of .venv, made by `make setup`.
.PHONY: setup test slow lint types format docs bench check
BIN := .venv/bin

setup:
	python3 -m venv .venv && $(BIN)/pip install -e '.[test]'

test: # the ordinary suite, on all cores
	$(BIN)/pytest

slow: # long ones, and more of a kind
	$(BIN)/pytest -m slow -n 0

lint:
	$(BIN)/ruff format --check . && $(BIN)/ruff check .

types:
	$(BIN)/mypy

format:
	$(BIN)/ruff format . && $(BIN)/ruff check --fix .

docs: # build/docs/index.html
	$(BIN)/python -m sphinx -W -q -j auto -b html docs build/docs

bench: # ratios against a named reference in the same process
	$(BIN)/pytest tests/benchmarks --benchmark-enable -n 0 --ignore-glob='' -m 'not gpu'

check: lint types test # what CI does
