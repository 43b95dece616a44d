# make demo | test | extremes | mutants | test-slurm | bench | distributed | format: each installs what is missing, configures, builds and runs.
.DEFAULT_GOAL := demo
.PHONY: deps release programs demo test extremes mutants test-slurm bench distributed format

deps:
	@deploy/install-deps.sh

release: deps
	@test -f build/release/build.ninja || cmake --preset release

programs: release
	@cmake --build --preset release --target lucernad lucerna

demo: programs
	@deploy/demo.sh build/release

test: release
	@cmake --build --preset release
	@ctest --preset release

extremes: release
	@cmake --build --preset release --target lights_extremes_test server_extremes_test
	@tests/extremes_page.py build/release

# In a copy of the sources: build/mutants.
mutants: release
	@tests/mutants/run.py

# A cluster of its own on the loopback interface: tests/slurm.
test-slurm: programs
	@deploy/install-deps.sh slurm-wlm munge
	@/usr/bin/python3 tests/slurm/slurm_test.py build/release

bench: release
	@cmake --build --preset release --target bench
	@build/release/tests/bench/bench

# Wants a machine that does nothing else.
distributed: release
	@cmake --build --preset release --target lucernad lucerna client_test
	@deploy/install-deps.sh slurm-wlm munge
	@tests/bench/distributed.py build/release --page docs/distributed.md

format:
	@command -v clang-format >/dev/null || deploy/install-deps.sh clang-format
	@git ls-files '*.h' '*.cpp' | xargs clang-format -i
