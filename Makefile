# Two commands: `make run` and `make test`. Both set up .venv first if it is missing or stale.
PYTHON ?= python3
CORES ?= $(shell nproc 2>/dev/null || echo 2)
TORCH_VERSION := 2.13.0
# Where the CPU build of torch is; works whether or not it answers. For a GPU build: make setup TORCH_INDEX=
TORCH_INDEX ?= https://download.pytorch.org/whl/cpu
SNAKEMAKE := .venv/bin/snakemake --cores $(CORES)

.PHONY: run help test test-all test-machine setup lint format clean benchmarks compare docs package-data

run: setup
	$(SNAKEMAKE)

help:
	@echo "make run           the whole workflow, to results/report.html"
	@echo "make test          quick tests"
	@echo "make test-all      every test: slow ones, whole runs, the study"
	@echo "make test-machine  Debian packages that the cluster and browser tests need"
	@echo "make setup         .venv with everything pinned"
	@echo "make lint          check style and types"
	@echo "make format        mend style"
	@echo "make benchmarks    time PHY, edge scores and tracking"
	@echo "make compare       speeds of this commit beside those of BASE=HEAD~1"
	@echo "make docs          documentation, to build/docs/index.html"
	@echo "make package-data  statistics of the default run and the tracker into the package"
	@echo "make clean         remove results, logs and caches"
	@echo "CORES=4 takes four cores; TORCH_INDEX= takes a build of torch for GPUs."

# One thread a process, as in runs.
test: setup
	OMP_NUM_THREADS=1 .venv/bin/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

# Everything: slow property tests, several whole runs, crash, cluster and browser suites, the study.
test-all: setup
	OMP_NUM_THREADS=1 .venv/bin/python -m pytest -m "" -n 2 --dist loadfile --no-loadscope-reorder

# What the cluster and browser suites need beside .venv, on Debian and as root; without it they are skipped.
test-machine:
	apt-get update
	apt-get install -y --no-install-recommends slurm-wlm slurm-client slurmctld slurmd chromium

setup: .venv/.installed

.venv/.installed: requirements.lock pyproject.toml Makefile
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "snowsim needs Python 3.11 or newer, $(PYTHON) is $$($(PYTHON) --version)"; exit 1; }
	rm -rf .venv
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip install --quiet --require-hashes --requirement requirements.lock
	.venv/bin/python envs/install_torch.py "$(TORCH_VERSION)" "$(TORCH_INDEX)"
	.venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	.venv/bin/python -m pip check
	touch $@

lint: setup
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/snakefmt --check Snakefile workflow
	.venv/bin/mypy

format: setup
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .
	.venv/bin/snakefmt Snakefile workflow

benchmarks: export PYTHONPATH = workflow
benchmarks: setup
	OMP_NUM_THREADS=1 .venv/bin/python -m pytest benchmarks/bench_phy.py --benchmark-only \
		--benchmark-columns=median,min,rounds --benchmark-sort=mean
	OMP_NUM_THREADS=1 .venv/bin/python benchmarks/bench_edges.py
	OMP_NUM_THREADS=1 .venv/bin/python benchmarks/bench_track.py

# Speeds of this commit beside those of another: make compare BASE=v0.5.0
BASE ?= HEAD~1
compare: setup
	.venv/bin/python benchmarks/compare_commits.py $(BASE)

# Statistics of the default run's flight, and the tracker that learned from them, to where they are read without a run.
package-data: setup
	$(SNAKEMAKE) ship_statistics pretrained
	@grep -qsF "$$(grep '"weights"' results/shipped/universal.json)" snowsim/data/universal.json || \
		echo "the tracker's weights are others than those in snowsim/data"
	cp results/shipped/* snowsim/data/

# The documentation, to build/docs/index.html; a warning fails.
docs: setup
	.venv/bin/python -m sphinx -b html -n -W --keep-going -d build/doctrees docs build/docs

# Results, logs and caches; `git clean -fdx` also removes .venv.
clean:
	rm -rf results logs .snakemake .pytest_cache .ruff_cache .hypothesis .benchmarks build docs/gallery
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
