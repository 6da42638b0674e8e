# Needs make, a C library and Python 3.11 or 3.13; everything else goes into .venv.
#   make render BLEND=path/to/file.blend      make PYTHON=python3.13 test

PYTHON ?=
# A Blender's executable, for `make acceptance`.
BLENDER ?= blender
# What starts Xvfb, for `make window`, `make cycles` and `make guide`.
XVFB ?= Xvfb
BLEND ?= sample_blends/cornell_corridor.blend
# More arguments for `photonmap render` or pytest.
ARGS ?=

BIN := .venv/bin
# Two processes share the files of tests; more would not fit the memory of small machines.
PYTEST := python -m pytest -n 2 --dist loadfile

.PHONY: help env env-core bpy render test test-slow test-core accuracy bench-env bench \
	bench-quick budgets bench-references lint extension acceptance window cycles guide samples gallery clean

help:
	@echo "make render [BLEND=file.blend]  render it to renders/*.png and *.exr"
	@echo "make test                       lint, types and all tests but the slow ones"
	@echo "make test-slow                  the tests that take minutes each"
	@echo "make test-core                  the tests that need no Blender, without bpy"
	@echo "make accuracy                   the long comparisons (under an hour): docs/accuracy.md"
	@echo "make bench                      speed against error (under 30 minutes): docs/benchmarks.md"
	@echo "make bench-quick                a part of it (under 5 minutes)"
	@echo "make budgets                    start-up, compiling, threads, bare Embree, memory"
	@echo "make bench-references           better references of the benchmark (hours)"
	@echo "make lint                       ruff and mypy"
	@echo "make extension                  dist/*.zip for Blender: one a platform and Python"
	@echo "make acceptance BLENDER=path    install and try the fitting one in that Blender"
	@echo "make window BLENDER=path        drive that Blender's window under Xvfb, with shots"
	@echo "make cycles BLENDER=path        fifty renders cancelled, edited, undone, loaded over"
	@echo "make guide BLENDER=path         follow the user guide in that Blender's window"
	@echo "make gallery                    the pictures of docs/gallery.md (under 20 minutes)"
	@echo "make samples                    build sample_blends/*.blend again (Python 3.11)"
	@echo "make clean                      remove everything that make made"
	@echo "PYTHON=python3.13 chooses the Python, ARGS='...' adds arguments to the command."

env:
	@tools/make_env.sh .venv blender,cli,dev "3.11 3.13" "$(PYTHON)"

env-core:
	@tools/make_env.sh .venv-core cli,dev "3.11 3.12 3.13" "$(PYTHON)"

# Says which of the system's libraries Blender's module lacks.
bpy: env
	@$(BIN)/python -m photon_map.blender_libraries

render: bpy
	@mkdir -p renders
	@name=$$(basename "$(BLEND)" .blend) && $(BIN)/photonmap render "$(BLEND)" \
		-o "renders/$$name.png" -o "renders/$$name.exr" $(ARGS)

# mypy wants to see the root under the package's name.
lint: env
	@mkdir -p .cache/types && ln -sfn ../.. .cache/types/photon_map
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: lint bpy
	$(BIN)/$(PYTEST) -m "not slow" $(ARGS)

# Slopes of convergence and closed forms at many passes: minutes each.
test-slow: bpy
	$(BIN)/$(PYTEST) -m slow $(ARGS)

test-core: env-core
	.venv-core/bin/$(PYTEST) -m "not blender and not slow" \
		--ignore=tests/blender $(ARGS)

# Both Blenders where both Pythons are at hand; the document says which one was not.
accuracy:
	@tools/make_env.sh .venv-accuracy blender,cli,dev "3.11 3.13" "$(PYTHON)"
	@.venv-accuracy/bin/python -m photon_map.blender_libraries
	@case "$$(.venv-accuracy/bin/python -V)" in *3.11*) other=3.13;; *) other=3.11;; esac; \
		tools/make_env.sh .venv-accuracy-other blender,cli,dev "$$other" || true; \
		.venv-accuracy/bin/python benchmarks/accuracy.py \
			--python .venv-accuracy-other/bin/python $(ARGS)

# The peers' wheels fit Python 3.11 only together with bpy 5.0.
bench-env:
	@tools/make_env.sh .venv-bench blender,cli,dev,bench "3.11" "$(PYTHON)"
	@.venv-bench/bin/python -m photon_map.blender_libraries

bench bench-quick: bench-env
	@.venv-bench/bin/python benchmarks/speed.py \
		$(if $(filter bench,$@),--docs docs,--quick) $(ARGS)

# ARGS='--only linux-x64-cp313' builds that one only; wheels/ keeps what was downloaded.
extension: env
	@$(BIN)/python tools/extension.py $(ARGS)

acceptance: bpy
	@$(BIN)/python tools/acceptance.py "$(BLENDER)" $(ARGS)

window: bpy
	@$(BIN)/python tools/window_test.py "$(BLENDER)" --xvfb "$(XVFB)" $(ARGS)

cycles: bpy
	@$(BIN)/python tools/cycles_test.py "$(BLENDER)" --xvfb "$(XVFB)" $(ARGS)

guide: bpy
	@$(BIN)/python tools/guide_walk.py "$(BLENDER)" --xvfb "$(XVFB)" $(ARGS)

# `make bench` puts what this measured into its page.
budgets: bench-env
	@.venv-bench/bin/python benchmarks/speed_budgets.py

# Hours on a quiet machine; it goes on where it was stopped.
bench-references: bench-env
	@.venv-bench/bin/python benchmarks/speed_reference.py --seconds 14400 $(ARGS)

# ARGS='pool gem' renders those pictures only.
gallery: bpy
	@$(BIN)/python sample_blends/gallery.py $(ARGS)

# bpy 4.2 writes files that Blender 4.2 to 5.2 open.
samples:
	@tools/make_env.sh .venv-samples samples "3.11" "$(PYTHON)"
	@for script in sample_blends/scripts/*.py; do \
		name=$$(basename "$$script" .py); \
		[ "$$name" = common ] || .venv-samples/bin/python "$$script" \
			"sample_blends/$$name.blend" || exit 1; \
	done

clean:
	rm -rf .venv .venv-* .cache .mypy_cache .pytest_cache .ruff_cache \
		.hypothesis build dist renders *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
