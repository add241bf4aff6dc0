PYTHON ?= .venv/bin/python
.DEFAULT_GOAL := help

.PHONY: build  ## Set up .venv and compile the kernels into it, editable
build:
	python3 -m venv .venv
	$(PYTHON) -m pip install --quiet --disable-pip-version-check --editable '.[dev]'

.PHONY: test  ## The quick part of the tests: Rust, Python and doctests
test:
	cargo test
	$(PYTHON) -m pytest -m 'not slow and not mitsuba' --numprocesses auto --dist loadfile --no-loadscope-reorder
	$(PYTHON) -m pytest -m 'not slow and mitsuba'

.PHONY: fuzz  ## Thousands of damaged files, generated calls and killed saves; about an hour
fuzz:
	ENVLIGHTS_FUZZ=1 $(PYTHON) -m pytest -s tests/test_fuzz.py tests/test_calls.py tests/test_saves.py \
	  tests/export/test_hostile_text.py tests/export/test_names.py

.PHONY: fuzz-native  ## Coverage-guided fuzzing of decoders and reduction, SECONDS for each; needs cargo-fuzz
SECONDS ?= 600
fuzz-native:
	$(PYTHON) fuzz/seeds.py
	for target in decode rows; do \
	  mkdir -p fuzz/corpus/$$target; \
	  cargo fuzz run --release --sanitizer none $$target fuzz/corpus/$$target fuzz/seeds/$$target -- \
	    -max_total_time=$(SECONDS) -max_len=4096 -timeout=8 -rss_limit_mb=1024 || exit 1; \
	done

.PHONY: lint  ## Everything that needs no judgement
lint:
	cargo fmt --check
	cargo clippy --all-targets --features python -- -D warnings
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) tests/words.py
	$(PYTHON) -c 'import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True, no_logo=True))'

.PHONY: types  ## Python types, and stubs against the compiled module
types:
	$(PYTHON) -m mypy
	$(PYTHON) -m mypy.stubtest envlights._native

.PHONY: pyright  ## Completeness of the public types; needs `pip install 'pyright[nodejs]'`
pyright:
	PATH="$(abspath $(dir $(PYTHON))):$$PATH" $(PYTHON) -m pyright --verifytypes envlights --ignoreexternal

.PHONY: docs  ## The site, docs/_build/html/index.html, without the network; needs the extra docs
docs:
	MPLBACKEND=agg $(PYTHON) -m sphinx --fail-on-warning --keep-going --quiet --jobs 2 -c docs . docs/_build/html

.PHONY: bench  ## Run time against error, peers in the same run
bench:
	$(PYTHON) -m benchmarks
	$(PYTHON) benchmarks/probe.py
	$(PYTHON) benchmarks/fit.py
	$(PYTHON) benchmarks/detection_speed.py
	$(PYTHON) benchmarks/detection.py
	$(PYTHON) benchmarks/transfer.py
	$(PYTHON) benchmarks/transfer_memory.py
	$(PYTHON) benchmarks/bridge.py

.PHONY: check  ## What CI runs
check:
	bash .ci/run

.PHONY: help  ## This list
help:
	@awk -F '## ' '/^.PHONY/ {split($$1, t, " "); printf "%-8s %s\n", t[2], $$2}' $(MAKEFILE_LIST)
