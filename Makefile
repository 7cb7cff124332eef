# `make` sets up and runs the main job; `make test` sets up and runs the tests.
# Needs Python 3.11 or newer, make, a C compiler and pip; everything else comes from requirements.lock into .venv.
# TORCH chooses PyTorch's build: `make TORCH=cpu`, `make TORCH=cu130` (CUDA 13.0), as download.pytorch.org/whl has them;
# without it pip's own index decides, where PyPI has the build with CUDA for Linux. docs/install.md says more.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
CORES ?= 2
KILLS ?= 50
INPUTS ?= 5000
MINUTES ?= 60
BIN := .venv/bin
TORCH ?=
READY := .venv/.ready$(if $(TORCH),-$(TORCH))

.PHONY: main gpu-check update repro test fuzz reruns reads same-bytes faults stateful variables crate doors notebook promises real paper report status fog_models schema docs dvc.yaml scale remotes slurm lint lock clean

main: $(READY)
	@echo "== The main job: snakemake --cores $(CORES)"
	@$(BIN)/snakemake --cores $(CORES)
	@echo "== Done. Tables: results/tables   Figures: results/figures   How each was made: the .run.json beside it"

# After a change of code that gives the same results, such as a faster way of computing the same fog: step by step, so
# that what came out as it was stops there; `snakemake` alone runs all that follows. Another comment runs nothing.
update: $(READY)
	@$(BIN)/python workflow/waves.py --cores $(CORES)

# DVC, after a kill too: repairs first what a kill left half-written of its own files, at which `dvc repro` stops.
repro: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python workflow/repro.py

# The promises of docs/promises.md, tested at length (about two hours on two idle cores; the tests hold a short form).
promises: reruns faults stateful

# Random histories of a folder on a chain of tiny jobs, and changes that times do not tell, run by Snakemake itself.
stateful: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/real_changes.py
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/stateful.py --minutes $(MINUTES)

# Which jobs each of some thirty changes, and changes of raw data, make run again on both engines.
reruns: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/reruns.py
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/raw_changes.py

# Whether each step reads and writes what it declares and nothing else.
reads: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/reads.py

# Whether clean runs give the same bytes on other cores, in other folders, time zones and languages.
same-bytes: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/same_bytes.py

# Which environment variables change bytes, and whether the run record says so.
variables: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/variables.py

# Files that are wrong in every way, given to every reader: INPUTS of them, with counts of what became of them.
fuzz: $(READY)
	@$(BIN)/python tests/long/fuzz.py $(INPUTS)

# Kills at random moments (KILLS of them), a full disk, no memory, a wrong clock, two engines at once; as root, for mounts.
faults: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/faults.py --kills $(KILLS)

# Whether the exported lineage of a table passes what its profile requires (roc-validator, in an environment of its own).
crate: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/crate.py

# The example notebook, run anew and written with what its cells print and draw.
notebook: $(READY)
	@$(BIN)/python examples/make_notebook.py

# What each way of installing brings, and whether the wheel works in an empty folder (DOORS="bare train" for these alone).
doors: $(READY)
	@$(BIN)/python tests/long/doors.py $(DOORS) $(if $(TORCH),--torch $(TORCH))

test: $(READY)
	@echo "== The tests: pytest"
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest -n 2 --dist loadgroup

# The chain on real frames at their native size, by both engines (some minutes); docs/real-data.md.
real: $(READY)
	@echo "== The chain on real samples: pytest tests/real"
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest -rs tests/real

# All tables and figures that are made so far, as a PDF. The dates are fixed, so that equal results give equal bytes.
paper: $(READY)
	@command -v pdflatex > /dev/null || { echo "make paper needs LaTeX; on Debian: apt-get install --no-install-recommends texlive-latex-base texlive-latex-recommended texlive-latex-extra" >&2; exit 1; }
	@$(BIN)/foggy tables --published --out results/paper
	@$(BIN)/foggy clean --unused --tex results/paper/unused.tex
	@for pass in 1 2; do \
		SOURCE_DATE_EPOCH=0 FORCE_SOURCE_DATE=1 pdflatex -halt-on-error -interaction=nonstopmode \
			-output-directory results/paper paper/article.tex > results/paper/pdflatex.txt \
		|| { tail -n 20 results/paper/pdflatex.txt >&2; exit 1; }; \
	done
	@echo "== results/paper/article.pdf"

# All tables and figures as one page for the browser, with the command behind each; the trade-off too where it was measured.
# The pages of predictions, to which it links, lie beside it in results/view; results/gallery.html has all tables and figures
# below each other.
report: $(READY)
	@$(BIN)/foggy view --results
	@$(BIN)/foggy gallery
	@$(BIN)/snakemake all $(if $(wildcard results/tradeoff/networks.run.json),tradeoff) --report results/report.html
	@echo "== results/report.html"

# docs/status.md and the pictures of the pages, from what the main job made; and the published means as a picture.
status: $(READY)
	@$(BIN)/python docs/make_status.py
	@$(BIN)/python docs/make_table.py

# docs/fog_models.md and its picture: the fog models against path tracing, from the stored reference.
fog_models: $(READY)
	@$(BIN)/foggy atlas
	@cp results/atlas/bounds.csv src/foggy_synscapes/fog/ladder/bounds.csv
	@$(BIN)/python docs/make_fog_models.py

# The stages of DVC and the picture of the workflow, from the table of steps: after an edit of steps.py, or a new test set, figure, kind of row or plugin.
dvc.yaml: $(READY)
	@$(BIN)/foggy steps --dvc dvc.yaml --svg docs/images/workflow.svg

# The JSON Schema and the pages of all keys, commands and functions, after a setting, an option or a docstring was edited.
schema: $(READY)
	@$(BIN)/foggy params --schema --out docs/params.schema.json
	@$(BIN)/foggy params --docs --out docs/parameters.md
	@$(BIN)/python docs/make_commands.py
	@$(BIN)/python docs/make_api.py

# The documentation as a site to be opened from disk, in an environment of its own. A link that leads nowhere, a page that no
# list names and a misspelt word stop it.
docs: .venv-docs/.ready
	@.venv-docs/bin/codespell README.md CHANGELOG.md CONTRIBUTING.md docs src workflow tests benchmarks examples params.yaml params
	@.venv-docs/bin/python -m sphinx -W --keep-going -q -b html docs build/docs
	@echo "== build/docs/index.html"

.venv-docs/.ready: requirements-docs.lock
	@echo "== Set-up: .venv-docs from requirements-docs.lock; half a minute"
	@$(PYTHON) -m venv .venv-docs
	@.venv-docs/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	@touch $@

# Measurements of whole runs: planning at full size, sharing through servers, a Slurm of one machine (docs/scale.md).
# Each stops with what to install where that is missing.
remotes slurm: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tests/long/$@.py

scale: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python benchmarks/scale.py

# Speed, memory, precision and repeatability on this machine's GPU, as a page of the docs; says so where there is none.
gpu-check: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python benchmarks/gpu.py --out docs/gpu.md

# Style and types; mypy takes half a minute at first, then seconds.
lint: $(READY)
	@echo "== Style and types: ruff, snakefmt, mypy"
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/snakefmt --check Snakefile workflow
	@$(BIN)/mypy

# A stamp inside .venv: a set-up that was cut off is done again, one that is older than the lock file is brought up to date.
# First every package but PyTorch by its SHA-256, so that one that was changed since is refused; then PyTorch, whose build (CPU
# or CUDA) is the one that pip's index has.
$(READY): requirements.lock requirements-hashes.lock pyproject.toml
	@echo "== Set-up: .venv from requirements.lock ($(PYTHON)); about two minutes"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; name one: make PYTHON=python3.11")'
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r requirements-hashes.lock
	@$(if $(TORCH),$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--extra-index-url https://download.pytorch.org/whl/$(TORCH) "$$(sed -n '/^torch==/p' requirements.lock)+$(TORCH)")
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	@touch $(READY)

# Newest versions that pyproject.toml allows; their SHA-256 for every platform; and the same for the site. The local part of
# torch's version (+cpu, +cu130) is left out, because its CPU and CUDA builds share a version.
lock: $(READY)
	@$(BIN)/python -m pip install --quiet pip-tools uv
	@$(BIN)/pip-compile --quiet --upgrade --extra experiment --extra test --strip-extras --no-emit-index-url --no-emit-trusted-host \
		--no-emit-find-links --no-emit-options --no-header --output-file requirements.lock pyproject.toml
	@sed -i -E 's/^(torch==[0-9.]+)\+[a-z0-9]+/\1/' requirements.lock
	@$(BIN)/uv pip compile --quiet --universal --generate-hashes --no-header --no-annotate --no-emit-index-url --extra experiment --extra test \
		--python-version 3.11 --constraint requirements.lock pyproject.toml --output-file requirements-hashes.lock
	@awk '/^[a-zA-Z0-9]/ {skip = /^(torch|triton|cuda-[a-z]+|nvidia-[a-z0-9-]+)==/ && !/^nvidia-ml-py==/} !skip' \
		requirements-hashes.lock > requirements-hashes.new && mv requirements-hashes.new requirements-hashes.lock
	@$(BIN)/uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--python-version 3.11 docs/requirements.in --output-file requirements-docs.lock

# Trainings took days: where there are any, `make clean` says so and leaves them, unless SURE=yes.
clean:
	@models=$$(find results/train -name model.safetensors 2> /dev/null | wc -l); \
	if [ $$models -gt 0 ] && [ "$(SURE)" != yes ]; then \
		echo "results/ holds $$models trained models, in $$(du -sh results | cut -f 1). To remove them too: make clean SURE=yes" >&2; \
		exit 1; \
	fi
	rm -rf results .snakemake
