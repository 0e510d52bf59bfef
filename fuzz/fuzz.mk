# `make fuzz` runs libFuzzer. The committed inputs are part of the tests and need no libFuzzer: fuzz, fuzz-16 and
# fuzz-msan run all of them, under MemorySanitizer in the last; fuzz-work counts what hostile meshes and streams cost, of a million faces in verify/fuzz-work.
# What codes meshes is compiled as one unit, the header once; mutator.c needs a header whose functions that decode have
# other names.

FUZZ_OTHER = mesh_file range_coder
FUZZ_CODEC = $(filter-out $(FUZZ_OTHER) run work mutator,$(patsubst fuzz/%.c,%,$(wildcard fuzz/*.c)))
FUZZ_DEPENDS = $(HEADER) $(wildcard fuzz/*.h) $(MESH_FILE) $(MESH_FILE_HEADERS)
COUNT_WORK = -DFUZZ_COUNTS_WORK -fsanitize-coverage=trace-pc
SECONDS ?= 120

.PHONY: fuzz
fuzz: deps ## runs all fuzz targets, or TARGETS, for SECONDS=n in all, and reports executions and coverage of each
	@$(call KEEP,CLANG=$(CLANG) fuzz/fuzz.sh $(SECONDS) $(TARGETS))

.PHONY: fuzz-coverage
fuzz-coverage: verify-deps ## what the inputs of each target reach in the header
	@$(call KEEP,CLANG=$(CLANG) fuzz/fuzz.sh coverage)

# $(1) suffix, $(2) flags
define fuzz_variant
build/fuzz/codec$(1).o: $$(FUZZ_CODEC:%=fuzz/%.c) $$(FUZZ_DEPENDS)
	@mkdir -p $$(@D)
	@for t in $$(FUZZ_CODEC); do \
	    printf '#undef LLVMFuzzerTestOneInput\n#define LLVMFuzzerTestOneInput fuzz_%s\n#include "%s.c"\n' $$$$t $$$$t; \
	done >$$(@:.o=.c)
	$(CLANG) -std=c99 -Ifuzz $$(TEST_FLAGS) $(2) -c $$(@:.o=.c) -o $$@
build/fuzz/%$(1).o: fuzz/%.c $$(FUZZ_DEPENDS)
	@mkdir -p $$(@D)
	$(CLANG) -std=c99 $$(TEST_FLAGS) $(2) -DLLVMFuzzerTestOneInput=fuzz_$$* -c $$< -o $$@
build/fuzz/mutator$(1).o: fuzz/mutator.c fuzz/asked.sh $$(FUZZ_DEPENDS)
	@fuzz/asked.sh $$(HEADER) build/fuzz/asked$(1)
	$(CLANG) -std=c99 -Ibuild/fuzz/asked$(1) $$(TEST_FLAGS) $(2) -c $$< -o $$@
build/fuzz/run$(1): $$(patsubst %,build/fuzz/%$(1).o,codec $$(FUZZ_OTHER) mutator run)
	$(CLANG) $(2) $$^ -lm -o $$@
build/log/fuzz$(1).log: build/fuzz/run$(1) $$(wildcard fuzz/seeds/*/* fuzz/regressions/*/*)
	$$(call log,$$<)
endef
$(eval $(call fuzz_variant,,$(SANITIZERS) $(ALL_CHECKS) $(COUNT_WORK)))
$(eval $(call fuzz_variant,-16,$(SANITIZERS) $(ALL_CHECKS) $(COUNT_WORK) -DCQ_INDEX_BITS=16))
$(eval $(call fuzz_variant,-msan,-O1 -fsanitize=memory -fno-sanitize-recover=all))

build/fuzz/work: fuzz/work.c $(FUZZ_DEPENDS)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) -O1 $(COUNT_WORK) $< -o $@

build/log/fuzz-work.log: build/fuzz/work
	$(call log,$<)

build/log/verify/fuzz-work.log: build/fuzz/work
	$(call log,$< 1000000)
