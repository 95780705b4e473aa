# Everything runs in .venv, which `make` sets up by itself.
PYTHON ?= python3
BIN := .venv/bin
# Else each of the many processes that tests start compiles the package anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test slow targets dist matrix bench bench-many screenshots readme docs lint clean

demo: .venv/ready
	$(BIN)/pmjac demo

test: .venv/ready
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 -m "not slow"

slow: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[adapters,compiled,peers,release]'
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile -m slow --durations=8

# Ten thousand targets of each mechanism, many at once and one by one: takes hours.
targets: .venv/ready
	PMJAC_TARGETS=10000 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 -v -rP -m "" tests/test_ten_thousand_targets.py

dist: .venv/release
	$(BIN)/python scripts/build_distributions.py

matrix: dist
	$(BIN)/python scripts/test_matrix.py

bench: .venv/ready
	$(BIN)/python benchmarks/bench_start.py
	$(BIN)/python benchmarks/bench_pickle.py
	$(BIN)/python benchmarks/bench_jacobian.py
	$(BIN)/python benchmarks/bench_planning.py
	$(BIN)/python benchmarks/bench_batch.py
	$(BIN)/python benchmarks/bench_avx2.py
	$(BIN)/python benchmarks/bench_cpp.py
	$(BIN)/python benchmarks/bench_mujoco.py
	$(BIN)/python benchmarks/bench_grid.py
	$(BIN)/python benchmarks/bench_ladder.py
	$(BIN)/python benchmarks/bench_sweep.py 1e7
	$(BIN)/python benchmarks/bench_parameters.py
	$(BIN)/python benchmarks/bench_error.py
	$(BIN)/python benchmarks/bench_free.py
	$(BIN)/python benchmarks/bench_dynamics.py
	$(BIN)/python benchmarks/bench_polytope.py
	$(BIN)/python benchmarks/bench_workspace.py
	$(BIN)/python benchmarks/bench_transmission.py
	$(BIN)/python benchmarks/bench_reach.py
	$(BIN)/python benchmarks/bench_follow.py
	$(BIN)/python benchmarks/bench_modes.py
	$(BIN)/python benchmarks/bench_homotopy.py
	$(BIN)/python benchmarks/bench_proof.py
	$(BIN)/python benchmarks/bench_page.py

# What docs/many_poses.md and docs/sweeps.md speak of.
bench-many: .venv/ready
	$(BIN)/python benchmarks/bench_planning.py
	$(BIN)/python benchmarks/bench_batch.py
	$(BIN)/python benchmarks/bench_avx2.py
	$(BIN)/python benchmarks/bench_cpp.py
	$(BIN)/python benchmarks/bench_mujoco.py
	$(BIN)/python benchmarks/bench_grid.py
	$(BIN)/python benchmarks/bench_sweep.py 1e7
	$(BIN)/python benchmarks/bench_parameters.py

screenshots: .venv/ready
	$(BIN)/python docs/make_screenshots.py
	$(BIN)/pmjac modes three_rps --from lecture_a -o docs/assembly_modes.png
	$(BIN)/pmjac workspace five_bar --plane x,y --measure dexterity --cells 201 -o docs/workspace.png --force
	$(BIN)/pmjac locus five_bar --plane theta1,theta2 -o docs/locus.png --force
	$(BIN)/pmjac transmission humanoid_ankle --joints pitch,roll --over pitch=-0.4:0.25,roll=-0.15:0.15 --limits 60,60 -o docs/transmission.png --force

readme: .venv/ready
	$(BIN)/python scripts/update_readme.py
	$(BIN)/python docs/draw_architecture.py

# The site in build/site, of pages and notebooks that are run. Once its tools are there, no network is used.
docs: .venv/docs
	rm -rf build/site build/gallery build/site_source build/site_doctrees
	$(BIN)/python docs/make_gallery.py build/gallery
	$(BIN)/python docs/website/stage.py build/site_source
	cp -r build/gallery/pages build/site_source/gallery
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -q -c docs/website -d build/site_doctrees build/site_source build/site

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

clean:
	rm -rf .venv build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis

.venv/ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

.venv/release: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[release]'
	touch $@

.venv/docs: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@
