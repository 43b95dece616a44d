# make demo | test | deb | test-deb | web | fuzz | tidy | tsan | soak | reliability | extremes | mutants | test-slurm | bench
#    | tradeoff | automatic | fit | distributed | format
# Each target installs missing packages, configures, builds and runs.
.DEFAULT_GOAL := demo
.PHONY: deps release programs demo test deb test-deb web fuzz wire tidy tsan oracle soak reliability extremes mutants test-slurm bench tradeoff automatic fit distributed format

deps:
	@deploy/install-deps.sh

release: deps
	@test -f build/release/build.ninja || cmake --preset release

programs: release
	@cmake --build --preset release --target lucernad lucerna

demo: programs
	@deploy/demo.sh build/release

test: release
	@deploy/install-deps.sh --tests
	@cmake --build --preset release
	@ctest --preset release
	@$(MAKE) --no-print-directory wire

# Writes the Debian packages to build/deb, and checks them.
deb: programs
	@deploy/install-deps.sh dpkg-dev file lintian
	@cmake --build --preset release --target lucerna_packaged
	@rm -rf build/deb
	@cpack --config build/release/CPackConfig.cmake -B build/deb
	@/usr/bin/python3 tests/packages/packages_test.py build/deb

# Installs the packages in a new Debian that mmdebstrap makes, asks a question there, and purges them.  Needs root.
test-deb: deb
	@deploy/install-deps.sh mmdebstrap
	@/usr/bin/python3 tests/packages/clean_root_test.py build/deb

# Fuzzes every reader of input with libFuzzer and sanitizers: 60 s each, or RUNS runs each.
fuzz: deps
	@deploy/install-deps.sh clang-16 llvm-16 libclang-rt-16-dev
	@test -f build/fuzz/build.ninja || cmake --preset fuzz
	@cmake --build --preset fuzz --target fuzz_targets
	@tests/fuzz/run_fuzz.py $(if $(RUNS),RUNS=$(RUNS),SHORT)

# Sends random extreme items to every light and every query of a server with AddressSanitizer and
# UndefinedBehaviorSanitizer.
ITEMS ?= 1000000
wire: deps
	@test -f build/asan/build.ninja || cmake --preset asan
	@cmake --build --preset asan --target wire_property_test
	@LUCERNA_WIRE_ITEMS=$(ITEMS) build/asan/tests/server/extremes/wire_property_test

# Checks with clang-tidy the rooms that all others include.  The preset `tidy` checks any target.
tidy: deps
	@deploy/install-deps.sh clang-14 clang-tidy-14
	@test -f build/tidy/build.ninja || cmake --preset tidy
	@cmake --build --preset tidy --target lucerna_lights_maths lucerna_server_runtime

# Runs the tests of lanes and threads with ThreadSanitizer.
tsan: deps
	@test -f build/tsan/build.ninja || cmake --preset tsan
	@cmake --build --preset tsan --target runtime_test
	@TSAN_OPTIONS=suppressions=tests/tsan.supp build/tsan/tests/server/runtime_test

# Compares the server's answers about random scenes with right answers.
SCENES ?= 1000000
ROOMS ?= 100000
oracle: release
	@cmake --build --preset release --target oracle_test
	@LUCERNA_ORACLE_SCENES=$(SCENES) LUCERNA_ORACLE_ROOMS=$(ROOMS) build/release/tests/oracle/oracle_test

# What takes long: ten times the items, ten times the rays in the shadow tests, four times the repeats in the interval
# tests, four times the samples of reference pictures, all mutants, and the figures of docs/reliability.md.
soak: release
	@cmake --build --preset release --target server_extremes_test coverage_test estimate_test reliability
	@ctest --preset release -C Soak -L soak
	@$(MAKE) --no-print-directory reliability
	@$(MAKE) --no-print-directory wire ITEMS=10000000

# Prints the figures of docs/reliability.md.  Requires an idle machine.  ROWS: some of them, such as "priority drain".
ROWS ?=
reliability: release
	@cmake --build --preset release --target reliability
	@build/release/tests/reliability/reliability $(ROWS)

extremes: release
	@cmake --build --preset release --target lights_extremes_test server_extremes_test
	@tests/extremes_page.py build/release

# Works in a copy of the sources, build/mutants.
mutants: release
	@tests/mutants/run_mutants.py

# Starts its own Slurm cluster on the loopback interface (tests/slurm).
test-slurm: programs
	@deploy/install-deps.sh slurm-wlm munge
	@/usr/bin/python3 tests/slurm/slurm_test.py build/release

# Prints the table of docs/performance.md, and writes it there if it has all rows.  Requires an idle machine.  ROWS: some of them, such as "load version".
bench: release
	@cmake --build --preset release --target lucernad lucerna visibility_bench wire_bench load_bench many_lights_bench \
	  path_bench equal_error_bench
	@tests/bench/performance.py build/release $(if $(ROWS),$(ROWS),--page docs/performance.md)

# Measures error against time in the five scenes.  Requires an idle machine.
BUDGET ?= 240s
tradeoff: programs
	@cmake --build --preset release --target lucerna-tradeoff
	@deploy/install-deps.sh chromium
	@deploy/tradeoff.sh build/release docs/tradeoff $(BUDGET)

# Measures the time of automatic divided by the time of the best setting, with a new seed.  QUERY=render studies
# pictures, which docs/tradeoff does not have.  Requires an idle machine.
automatic: programs
	@cmake --build --preset release --target lucerna-tradeoff
	@deploy/tradeoff.sh build/release build/automatic $(BUDGET) $$(date +%s)
	@tests/bench/automatic_table.py build/automatic $(if $(QUERY),,docs/tradeoff)

# Like automatic, in the small scenes from which the rules of automatic were derived.
fit: programs
	@cmake --build --preset release --target lucerna-tradeoff
	@SCENES=tests/data/reference deploy/tradeoff.sh build/release build/fit 30s 1 \
	  $(notdir $(basename $(wildcard tests/data/reference/*.pbrt)))
	@tests/bench/automatic_table.py build/fit

# Measures jobs on several servers.  Requires an idle machine.
distributed: release
	@cmake --build --preset release --target lucernad lucerna client_test
	@deploy/install-deps.sh slurm-wlm munge
	@tests/bench/distributed.py build/release --page docs/distributed.md

# Starts lucernad with the demo scene, and the page for browsers, until Ctrl-C.  LISTEN=HOST:PORT: where.
LISTEN ?= 127.0.0.1:8080
web: programs
	@command -v npm >/dev/null || deploy/install-deps.sh nodejs npm
	@deploy/web/build.sh
	@deploy/web/run.sh build/release $(LISTEN)

format:
	@command -v clang-format >/dev/null || deploy/install-deps.sh clang-format
	@git ls-files '*.h' '*.cpp' | xargs clang-format -i
