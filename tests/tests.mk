# What a test is: a program or a script whose last line is `N passed, N failed`. build/log/NAME.log keeps what it prints.
#
# Each C or C++ file of tests/unit and tests/property is a program that is built in four ways, and needs no line here;
# `make build/tests/unit/mesh` builds one. A script gets a rule here, $(call log,COMMAND), and its name in the Makefile.
#
#     unit/mesh      clang, sanitizers for addresses and undefined behaviour, assertions
#     unit/mesh-16   the same with 16-bit indices; not those that have no indices or both kinds
#     unit/mesh-O3   gcc, optimised, no assertions; what is linked at -O3, an implementation of its own at -O1
#     unit/mesh-O0   gcc, not optimised, assertions; but for levels and regular levels, which take long

# A recipe that writes a log. An exit status that is not 0 counts, whatever was printed.
log = @mkdir -p $(@D); ( $(1) ) >$@ 2>&1 || echo "exit status $$?" >>$@; times >$(@:.log=.times); \
    echo "$(TEST_NAME): $$(tail -n 1 $@)"
TEST_NAME = $(@:build/log/%.log=%)

.PHONY: times
times: ## seconds of processor time of each test that ran last, without those of its compiler
	@find build/log -name '*.times' | while read -r file; do \
	    awk -v name="$${file#build/log/}" 'NR == 2 { gsub(/[ms]/, " "); printf "%8.1f  %s\n", $$1 * 60 + $$2 + $$3 * 60 + $$4, \
	        substr(name, 1, length(name) - 6) }' "$$file"; done | sort -rn

build/log/%.log: build/tests/%
	$(call log,ASAN_OPTIONS=handle_sigill=1 $<)

# Properties are tried with a seed that the log names; RC_PARAMS='seed=...' repeats a run, max_success=1000 makes it longer.
# Two builds take fewer cases here, and many in `make verify`.
build/log/property/%-16.log build/log/property/%-O0.log: export RC_PARAMS ?= max_success=30

build/log/verify/property-%.log: build/tests/property/%
	$(call log,RC_PARAMS=max_success=2000 $<)

SOURCES_OF_PROGRAMS = $(wildcard tests/unit/*.c tests/property/*.cpp)
BARE = $(basename $(SOURCES_OF_PROGRAMS:tests/%=%))
NARROW = $(filter-out unit/mesh_file unit/polygon unit/words property/index_width,$(BARE))
LONG_PROGRAMS = unit/levels-O0 unit/regular-O0
QUICK_PROGRAMS = $(filter-out $(LONG_PROGRAMS),$(BARE:%=%-O0))
PROGRAMS = $(BARE) $(NARROW:%=%-16) $(BARE:%=%-O3) $(QUICK_PROGRAMS)
VERIFY_PROGRAMS = $(LONG_PROGRAMS) $(patsubst property/%,verify/property-%,$(filter property/%,$(BARE) $(NARROW:%=%-16)))

# A test that is written and not run is an unused function.
TEST_FLAGS = $(WARNINGS) -Werror=unused-function -g1 -Iinclude -Iexamples -Itests/support
TEST_DEPENDS = $(HEADER) $(wildcard tests/support/* examples/*.h examples/mesh_file/*)
ASSERTIONS = '-DCQ_ASSERT(c)=((c) ? (void)0 : __builtin_trap())'
# Three checks cost an optimising compiler half of its time, and are made in programs that are not optimised: who reads at
# a null pointer or behind an object is found by the address sanitizer, and who adds to a null pointer by the others.
SANITIZERS = -O1 -fsanitize=address,undefined -fno-sanitize=null,object-size,alignment -fno-sanitize-recover=all \
    $(ASSERTIONS)
ALL_CHECKS = -O0 -fsanitize=undefined # behind these flags

# The implementation is compiled once for each way to build, for both widths of indices. Programs that look at what is
# private compile their own, and so do those with assertions or parts of their own: $(call linked,FLAGS,OTHERS) are the
# flags for those, and for the others. A C program that is linked needs no optimising compiler; nor does an implementation
# with sanitizers, where that takes longer than what it saves, 15 seconds, but for regular levels, which take two minutes
# without.
NEEDS_OWN = cqi_|CQI_|define CQ_(ASSERT|NO_)
own = $(if $(filter unit/regular,$*),-O1,$(ALL_CHECKS))
linked = $(if $(shell grep -lE '$(NEEDS_OWN)' $<),$(1),$(2) -DCONQUEST_IMPLEMENTATION_DONE)

# $(1) suffix, $(2) C compiler, $(3) C++ compiler, $(4) flags
define library
build/tests/conquest$(1).o build/tests/conquest_16$(1).o: build/tests/%$(1).o: examples/cmake/%.c examples/cmake/conquest.c $$(HEADER)
	@mkdir -p $$(@D)
	$(2) -std=c99 $$(TEST_FLAGS) $(4) -c $$< -o $$@
build/tests/libconquest$(1).a: build/tests/conquest$(1).o build/tests/conquest_16$(1).o
	@rm -f $$@
	$$(AR) rcs $$@ $$^
endef

# The same, and $(5) suffix of its library, $(6) flags of programs with an implementation of their own
define variant
build/tests/%$(1): tests/%.c build/tests/libconquest$(5).a $$(TEST_DEPENDS)
	@mkdir -p $$(@D)
	$(2) -std=c99 $$(TEST_FLAGS) $(4) $$(call linked,$(6),-O0) $$< build/tests/libconquest$(5).a -lm -o $$@
build/tests/%$(1): tests/%.cpp build/tests/libconquest$(5).a $$(TEST_DEPENDS)
	@mkdir -p $$(@D)
	$(3) -std=c++17 $$(TEST_FLAGS) $(4) $$(call linked,$(6)) $$< build/tests/libconquest$(5).a -lrapidcheck -o $$@
endef
$(eval $(call library,,$(CLANG),$(CLANGXX),$(SANITIZERS)))
$(eval $(call library,-O3,gcc,g++,-O3 -DNDEBUG))
$(eval $(call library,-O0,gcc,g++,-O0 $(ASSERTIONS)))
$(eval $(call variant,,$(CLANG),$(CLANGXX),$(SANITIZERS),,$$(own)))
$(eval $(call variant,-16,$(CLANG),$(CLANGXX),$(SANITIZERS) -DCQ_INDEX_BITS=16,,$$(own)))
$(eval $(call variant,-O3,gcc,g++,-O3 -DNDEBUG,-O3,-O1))
$(eval $(call variant,-O0,gcc,g++,-O0 $(ASSERTIONS),-O0))

# -- Scripts -------------------------------------------------------------------------------------------------------

build/log/ref_data.log: $(REF_DATA)
	$(call log,ref_data/ref_data.sh check)

.PHONY: lint
lint: ## tabs, lengths of lines, names in the header, order of its functions, scripts
	@tests/lint/lint.sh

build/log/lint.log:
	$(call log,tests/lint/lint.sh)

build/log/headers.log: $(HEADER) tests/headers/headers.sh
	$(call log,CLANG=$(CLANG) tests/headers/headers.sh)

build/log/headers-quick.log: $(HEADER) tests/headers/headers.sh
	$(call log,CLANG=$(CLANG) tests/headers/headers.sh quick)

VENDOR = build/cqm.1 build/package/libconquest.a $(HEADER) $(wildcard examples/cmake/* tests/vendor/* tests/vendor/*/*)

build/log/vendor.log: $(VENDOR)
	$(call log,CLANG=$(CLANG) tests/vendor/vendor.sh)

build/log/vendor-windows.log: $(VENDOR)
	$(call log,tests/vendor/vendor.sh windows)

# The package is built as a wheel and installed, beside what it is tested with.
PYTHON = build/python/venv/bin/python
PYTEST = pytest -q -p no:cacheprovider -o pythonpath=../support -p last_line
PYTHON_SOURCES = $(HEADER) $(wildcard examples/python/* examples/python/conquest/* examples/python/conquest/*/*) \
    $(CQM_SOURCES) $(CQM_HEADERS)

build/python/installed: build/python/venv/complete $(PYTHON_SOURCES)
	@rm -rf build/python/wheels
	$(PYTHON) -m pip wheel -q --no-deps --no-build-isolation -w build/python/wheels ./examples/python
	$(PYTHON) -m pip install -q --no-deps --force-reinstall build/python/wheels/*.whl
	@touch $@

build/log/python.log: build/python/installed build/cqm README.md $(wildcard tests/python/*)
	$(call log,cd tests/python && CQM=../../build/cqm ../../$(PYTHON) -m $(PYTEST))

# conquest.batch, with a scheduler and workers on loopback: what it needs has a virtual environment of its own.
build/log/batch.log: build/batch/venv/complete build/python/installed $(wildcard tests/batch/*)
	@build/batch/venv/bin/pip install -q --no-deps --force-reinstall build/python/wheels/*.whl
	$(call log,cd tests/batch && ../../build/batch/venv/bin/python -m $(PYTEST))

build/log/engine.log: build/engine build/cqm build/meshes build/python/venv/complete tests/engine/engine.py
	$(call log,xvfb-run -a -s "-screen 0 1024x768x24" $(PYTHON) tests/engine/engine.py build/engine build/cqm \
	    build/meshes/bunny00.off build/engine-test)

# cqm and the smallest examples with sanitizers
build/tests/cqm: $(CQM_SOURCES) $(CQM_HEADERS)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) $(SANITIZERS) $(CQM_SOURCES) -lm -o $@

build/tests/minimal_decode-16: examples/minimal_decode.c $(HEADER)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) $(SANITIZERS) -DCQ_INDEX_BITS=16 $< -o $@

build/tests/minimal_encode: examples/minimal_encode.c $(HEADER)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) $(SANITIZERS) $< -o $@

build/log/examples.log: build/cqm $(EXAMPLES) build/meshgen build/tests/minimal_decode-16 build/tests/minimal_encode README.md CONTRIBUTING.md $(wildcard tests/doors/*)
	$(call log,tests/cli/examples.sh)

build/log/channels.log: build/meshgen
	$(call log,python3 tests/cli/channels.py build/tests/cqm build/meshgen build/channels)

build/log/inputs.log build/log/seams.log: build/log/%.log:
	$(call log,python3 tests/cli/$*.py build/tests/cqm build/$*)

build/log/channels.log build/log/inputs.log build/log/seams.log: build/tests/cqm $(wildcard tests/cli/*.py)

build/log/meshes.log: build/tests/cqm build/meshgen build/meshes
	$(call log,tests/meshes/check.sh build/tests/cqm)

build/log/bases.log: build/cqm build/meshes tests/meshes/bases.py
	$(call log,python3 tests/meshes/bases.py build/cqm build/bases $(ALL_MANIFOLDS))

# The second decoder, tests/reference/decoder.py, must agree; SPEC.md must have the header's tables.
# Programs with sanitizers take ten times as long to start, and thousands are: they are for longer runs.
SECOND_DECODER = $(wildcard tests/reference/*.py) SPEC.md build/meshes
QUICK_COMPARED = build/cqm build/tests/reference/dump-O0 build/tests/reference/channels-O0
COMPARED = build/cqm build/tests/reference/dump build/tests/reference/channels

build/log/reference.log: $(SECOND_DECODER) $(QUICK_COMPARED)
	$(call log,python3 tests/reference/compare.py $(QUICK_COMPARED))

build/log/verify/reference.log: $(SECOND_DECODER) $(COMPARED)
	$(call log,python3 tests/reference/compare.py --all $(COMPARED))

.PHONY: reference embedded figures
reference: deps $(SECOND_DECODER) $(COMPARED) ## compares both decoders on larger meshes and 21 000 random streams
	@python3 tests/reference/compare.py --all $(COMPARED)

# tests/embedded: examples/microcontroller for each device, in qemu, against the host; budgets and exact figures.
EMBEDDED = build/cqm build/meshgen $(HEADER) tests/measure/memory/memory.c \
    README.md $(wildcard examples/microcontroller/* tests/embedded/* tests/doors/*)

embedded: deps build/cqm build/meshgen ## decodes on devices in emulators, checks budgets of code, stack, RAM
	@tests/embedded/embedded.sh check

figures: deps build/cqm build/meshgen ## measures code, stack, RAM, instructions; writes README's tables
	@tests/embedded/embedded.sh figures

build/log/embedded.log: $(EMBEDDED)
	$(call log,tests/embedded/embedded.sh check)

# -- Proof by cases ------------------------------------------------------------------------------------------------
#
# tests/exhaustive: everything that is small; payloads also counts basic blocks. tests/cgal: an independent library
# does the same. Optimised, with assertions.

EXHAUSTIVE = exhaustive/roundtrip exhaustive/seams exhaustive/splits exhaustive/symbols exhaustive/regular exhaustive/payloads \
    exhaustive/payloads-3
CGAL = cgal/splits
EXHAUSTIVE_DEPENDS = build/tests/libconquest-O2.a $(TEST_DEPENDS) $(wildcard tests/exhaustive/*.hpp)
OPTIMISED = -std=c++17 $(TEST_FLAGS) -O2 $(ASSERTIONS)

$(eval $(call library,-O2,$(CLANG),$(CLANGXX),-O2 $(ASSERTIONS)))

build/tests/exhaustive/%: tests/exhaustive/%.cpp $(EXHAUSTIVE_DEPENDS)
	@mkdir -p $(@D)
	$(CLANGXX) $(OPTIMISED) $(call linked) $< build/tests/libconquest-O2.a -o $@

build/tests/exhaustive/payloads: tests/exhaustive/payloads.cpp $(EXHAUSTIVE_DEPENDS)
	@mkdir -p $(@D)
	$(CLANGXX) $(OPTIMISED) -DCOUNT_WORK -fsanitize-coverage=trace-pc $< -o $@

build/tests/exhaustive/payloads-3: tests/exhaustive/payloads.cpp $(EXHAUSTIVE_DEPENDS)
	@mkdir -p $(@D)
	$(CLANGXX) $(OPTIMISED) $< -o $@

build/tests/exhaustive/regular: tests/exhaustive/regular.cpp fuzz/asked.sh $(EXHAUSTIVE_DEPENDS)
	@mkdir -p $(@D)
	@fuzz/asked.sh $(HEADER) build/tests/exhaustive/asked
	$(CLANGXX) -Ibuild/tests/exhaustive/asked $(OPTIMISED) $< -o $@

build/log/exhaustive/payloads-3.log: build/tests/exhaustive/payloads-3
	$(call log,$< 3)

build/log/verify/exhaustive-%.log: build/tests/exhaustive/%
	$(call log,$< all)

# $(call manifolds,CONDITION): the oriented manifolds of build/meshes, by what the round trip of all meshes expects: of others
# something is told, even of their connectivity alone.
manifolds = $(shell awk '{ alone = $$0; sub(/.*but --connectivity: /, "", alone) } \
    /^build.meshes/ && $$2 == "ok" && alone !~ /told/ && $(1) { print $$1 }' tests/meshes/expected.tsv)
MANIFOLDS = $(call manifolds,$$3 >= 300)
ALL_MANIFOLDS = $(call manifolds,1)

# With positions nothing may be set aside or turned over: what is decoded would be another mesh.
OFF_MANIFOLDS = $(filter %.off,$(call manifolds,!/set aside|turned over/))

# Meshes with regular levels: a name is what meshgen gets.
SUBDIVIDED = $(patsubst %,build/generated/subdivided/%.off,sphere_3 torus_21_17 cylinder_17_12 annulus_16_3 \
    split_2_torus_5_4 split_2_grid_5_4_100 split_1_random_300_1 loop_3_octahedron loop_3_genus_2 loop_2_annulus_7_2 \
    loop_2_diagonals_1_cylinder_7_3 diagonals_0_cylinder_17_11 diagonals_1_grid_32_20_100 diagonals_2_grid_16_20_100 \
    diagonals_2_torus_21_17 components_3_split_2_pyramid_9)

build/generated/subdivided/%.off: build/meshgen
	@mkdir -p $(@D)
	@build/meshgen $(subst _, ,$*) >$@

build/tests/cgal/%: tests/cgal/%.cpp build/tests/libconquest-O2.a $(TEST_DEPENDS)
	@mkdir -p $(@D)
	g++ $(OPTIMISED) $(call linked) $< build/tests/libconquest-O2.a -o $@

build/log/cgal/splits.log: build/tests/cgal/splits build/meshes $(SUBDIVIDED)
	$(call log,$< 250 $(OFF_MANIFOLDS) $(SUBDIVIDED))

build/log/verify/cgal-splits.log: build/tests/cgal/splits build/meshes $(SUBDIVIDED)
	$(call log,$< 1000 $(OFF_MANIFOLDS) $(SUBDIVIDED))
