# conquest: a progressive mesh codec in one header. Everything that is built goes to build/.
#
# Here: programs, installation, packages that targets need, ways to run tests. What a test is and how it runs is
# said in tests/tests.mk; CONTRIBUTING.md says how to run one and how to add one. Other targets are beside their sources.

CFLAGS ?= -O2
CLANG ?= clang-19
CLANGXX = $(subst clang,clang++,$(CLANG))
JOBS ?= $(shell nproc)

WARNINGS = -Wall -Wextra -Wconversion -pedantic
COMPILE = $(CC) -std=c99 $(WARNINGS) $(CPPFLAGS) -Iinclude $(CFLAGS) $(LDFLAGS)
HEADER = include/conquest.h
MESH_FILE = $(wildcard examples/mesh_file/*.c)
MESH_FILE_HEADERS = examples/mesh_file.h examples/mesh_file/reader.h
CQM_SOURCES = $(wildcard examples/cqm/*.c) $(MESH_FILE)
CQM_HEADERS = $(HEADER) examples/cqm/cqm.h $(MESH_FILE_HEADERS)

.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all help clean install uninstall engine demo meshes ref_data check-ref

EXAMPLES = build/minimal_decode build/minimal_encode build/stream build/game_loop

all: build/cqm $(EXAMPLES) build/meshgen ## builds cqm, the examples and the mesh generator

help: ## lists the targets
	@awk -F ':.*## ' '/^[a-z0-9_-]+:.*## / { printf "make %-14s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

build/cqm: $(CQM_SOURCES) $(CQM_HEADERS)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples $(CQM_SOURCES) $(LDLIBS) -lm -o $@

$(EXAMPLES): build/%: examples/%.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

build/meshgen: ref_data/meshgen.c
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

clean: ## removes build/
	rm -rf build

# Runs a command and keeps what it prints for `make quotes`; its exit status counts.
KEEP = mkdir -p build/printed && { { $(1); echo $$? >build/printed/$@.status; } | tee build/printed/$@.txt; \
    exit $$(cat build/printed/$@.status); }

demo: build/cqm build/meshes ## encodes and decodes some meshes and prints a table
	@$(call KEEP,tests/cli/demo.sh)

meshes: build/meshes ## brings the 143 meshes of Debian's package libcgal-demo into build/meshes

build/meshes:
	@tests/meshes/fetch.sh $@

REF_DATA = build/cqm build/meshgen build/tests/reference/channels build/tests/reference/dump

ref_data: $(REF_DATA) ## makes the reference meshes and the streams of this format version again
	@ref_data/ref_data.sh make

check-ref: $(REF_DATA) ## decodes the reference streams of all versions and compares hashes
	@ref_data/ref_data.sh check

# -- Installation: also the package for CMake and pkg-config; examples/cmake has its parts -------------------------

PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
VERSION = $(shell sed -n 's/^.define CQ_VERSION_STRING "\(.*\)".*/\1/p' $(HEADER))
PACKAGE = examples/cmake
INSTALLED = $(PREFIX)/include/conquest.h $(LIBDIR)/libconquest.a $(LIBDIR)/pkgconfig/conquest.pc \
    $(LIBDIR)/cmake/conquest/conquestConfig.cmake $(LIBDIR)/cmake/conquest/conquestConfigVersion.cmake \
    $(PREFIX)/bin/cqm $(PREFIX)/share/man/man1/cqm.1

install: $(addprefix $(DESTDIR),$(INSTALLED)) ## header, library, packages for CMake and pkg-config, cqm: PREFIX=DIR

uninstall: ## removes what `make install` has installed
	rm -f $(addprefix $(DESTDIR),$(INSTALLED))

# $(1) folder, $(2) where its files are, $(3) mode
define install_from
$(DESTDIR)$(1)/%: $(2)/%
	install -D -m $(3) $$< $$@
endef
$(eval $(call install_from,$(PREFIX)/include,include,644))
$(eval $(call install_from,$(PREFIX)/bin,build,755))
$(eval $(call install_from,$(PREFIX)/share/man/man1,build,644))
$(eval $(call install_from,$(LIBDIR),build/package,644))
$(eval $(call install_from,$(LIBDIR)/cmake/conquest,build/package,644))

$(DESTDIR)$(LIBDIR)/pkgconfig/conquest.pc: $(PACKAGE)/conquest.pc.in $(HEADER)
	@mkdir -p $(@D)
	sed 's,@PREFIX@,$(PREFIX),; s,@LIBDIR@,$(LIBDIR:$(PREFIX)/%=$${prefix}/%),; s,@VERSION@,$(VERSION),' $< >$@

build/cqm.1: examples/cqm/manual.sh build/cqm
	$< build/cqm >$@

build/package/libconquest.a: $(patsubst $(PACKAGE)/%.c,build/package/%.o,$(wildcard $(PACKAGE)/*.c))
	$(AR) rcs $@ $^

build/package/%.o: $(PACKAGE)/%.c $(HEADER)
	@mkdir -p $(@D)
	$(CC) -std=c99 $(WARNINGS) $(CPPFLAGS) -Iinclude $(CFLAGS) -fPIC -c $< -o $@

build/package/%.cmake: $(PACKAGE)/%.cmake
	@mkdir -p $(@D)
	cp $< $@

build/package/%: $(PACKAGE)/%.in $(HEADER)
	@mkdir -p $(@D)
	sed 's,@VERSION@,$(VERSION),' $< >$@

# -- A game engine's loop: SDL2 and OpenGL 3.3 ---------------------------------------------------------------------

SDL = $(shell pkg-config --$(1) sdl2 epoxy)

engine: ## builds examples/engine, which draws a mesh while it streams
	$(call install,$(ENGINE_PACKAGES))
	@$(MAKE) --no-print-directory build/engine

build/engine: $(wildcard examples/engine/*) $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $(call SDL,cflags) $(filter %.c,$^) $(call SDL,libs) $(LDLIBS) -lm -o $@

# -- Packages that targets need (Debian and Ubuntu) ----------------------------------------------------------------

PACKAGES = gcc g++ shellcheck clang-19 libclang-rt-19-dev lld-19 librapidcheck-dev libcgal-dev \
    python3 python3-dev python3-venv cmake pkg-config man-db bsdextrautils xvfb xauth libgl1-mesa-dri \
    $(ENGINE_PACKAGES) $(WEB_TEST_PACKAGES) $(EMBEDDED_PACKAGES) $(PORTABILITY_PACKAGES)
ENGINE_PACKAGES = pkg-config libsdl2-dev libepoxy-dev libgl-dev
EMBEDDED_PACKAGES = gcc-arm-none-eabi qemu-system-arm gcc-riscv64-unknown-elf qemu-system-misc gcc-avr avr-libc simavr \
    tcc gcc-s390x-linux-gnu libc6-dev-s390x-cross qemu-user
# For -m32 (not gcc-multilib, which conflicts with the cross compilers), and for a big-endian machine.
GCC_MAJOR = $(shell gcc -dumpversion 2>/dev/null || echo 12)
PORTABILITY_PACKAGES = gcc-$(GCC_MAJOR)-multilib g++-$(GCC_MAJOR)-multilib libc6-dev-i386 gcc-s390x-linux-gnu \
    libc6-dev-s390x-cross qemu-user
VERIFY_PACKAGES = gcc-arm-linux-gnueabihf libc6-dev-armhf-cross gcc-riscv64-linux-gnu libc6-dev-riscv64-cross \
    gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-powerpc-linux-gnu libc6-dev-powerpc-cross llvm-19 \
    clang-14 lld-14 clang-16 lld-16 clang-22 libclang-rt-22-dev $(PROOF_PACKAGES) $(WINDOWS_PACKAGES)
PROOF_PACKAGES = cvc5
WINDOWS_PACKAGES = gcc-mingw-w64-x86-64 wine wine64 python3-venv
SUDO = $(if $(filter 0,$(shell id -u)),,sudo)

# Those of $(1) that are missing
missing = for p in $(1); do \
    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || echo $$p; done

# $(call install,PACKAGES): those that are missing
define install
	@missing=$$($(missing)); test -z "$$missing" || { $(SUDO) apt-get -q update && \
	    DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get -q install -y --no-install-recommends $$missing </dev/null; }
endef

.PHONY: deps verify-deps
deps: ## installs what the tests need, if missing
	$(call install,$(PACKAGES))

verify-deps: deps ## installs what `make verify` needs beside that
	$(call install,$(VERIFY_PACKAGES))

# $(call venv,NAME,FOLDER): build/NAME/venv with the packages of FOLDER/requirements.txt
define venv
build/$(1)/venv/complete: $(2)/requirements.txt
	@mkdir -p $$(@D)
	python3 -m venv $$(@D)
	$$(@D)/bin/pip install -q -r $$<
	@touch $$@
endef
$(foreach name,python batch portability,$(eval $(call venv,$(name),tests/$(name))))
$(foreach name,assets quality,$(eval $(call venv,$(name),tests/measure/$(name))))

# -- Tests ---------------------------------------------------------------------------------------------------------

include $(wildcard examples/*/*.mk tests/*.mk tests/*/*.mk fuzz/*.mk)

# A test is build/log/NAME.log, whose last line is `N passed, N failed`. `make check T=NAME` runs one. Long ones are first.
SCRIPTS = lint headers vendor python engine $(WEB_LOGS) ref_data examples channels inputs seams embedded meshes bases \
    reference portability fuzz fuzz-16 fuzz-msan fuzz-work quotes
LONG = exhaustive/payloads-3
TESTS = $(CGAL) $(filter-out $(LONG),$(EXHAUSTIVE)) $(SCRIPTS) $(PROGRAMS)
CHECKS = lint headers-quick ref_data $(QUICK_PROGRAMS)
VERIFY = $(VERIFY_PROGRAMS) $(LONG) verify/exhaustive-roundtrip verify/exhaustive-splits verify/exhaustive-symbols \
    verify/exhaustive-regular verify/exhaustive-seams verify/cgal-splits verify/fuzz-work verify/reference \
    batch web-models proof proof-bugs portability-all windows vendor-windows coverage mutation verify/quotes
LOGS = $(TESTS:%=build/log/%.log)

.PHONY: test check verify cgal exhaustive run summary

test: build/meshes ## runs everything under tests/; what it needs is installed by `make deps`
	@missing=$$($(call missing,$(PACKAGES))); test -z "$$missing" || echo make deps would install: $$missing
	@rm -rf build/log
	@$(MAKE) --no-print-directory run FIRST='$(filter-out %/quotes.log,$(LOGS))'

check: ## what to run before a commit, in a minute; T=unit/mesh: this test, T=unit: all of unit/
	@$(MAKE) --no-print-directory run LOGS='$(addprefix build/log/,$(addsuffix .log,$(or $(CHOSEN),$(NO_TEST),$(CHECKS))))'

ALL = $(sort $(TESTS) $(VERIFY) $(CHECKS))
CHOSEN = $(if $(T),$(or $(filter $(T),$(ALL)),$(filter $(T)/% $(T)-%,$(ALL))))
NO_TEST = $(if $(T),$(error no test is called $(T); all: $(ALL)))

verify: verify-deps build/meshes ## what takes hours: larger spheres, proofs, other machines, coverage, mutants
	@$(MAKE) --no-print-directory run LOGS='$(VERIFY:%=build/log/%.log)' \
	    FIRST='$(filter-out %/quotes.log,$(VERIFY:%=build/log/%.log))'

cgal: deps build/meshes ## compares each split and flip of real and random meshes with CGAL
	@$(MAKE) --no-print-directory run LOGS='$(CGAL:%=build/log/%.log)'

exhaustive: deps ## all small spheres, tori and discs: first gates, splits, regular levels; all small payloads
	@$(MAKE) --no-print-directory run LOGS='$(EXHAUSTIVE:%=build/log/%.log)'

# Runs the tests of $(LOGS), whatever ran before.
run:
	@rm -f $(LOGS)
	@$(MAKE) --no-print-directory -k $(if $(findstring -j,$(MAKEFLAGS)),,-j$(JOBS)) $(LOGS) || true
	@$(MAKE) --no-print-directory -s summary

# Sums the last lines. A log that is missing, ends in another line or counts nothing is one failure more.
summary:
	@for log in $(LOGS); do mkdir -p $$(dirname $$log); test -e $$log || echo 'not built' >$$log; done
	@awk ' \
	    { lines[FILENAME] = FNR } \
	    /^[0-9]+ passed, [0-9]+ failed$$/ { passed[FILENAME] = $$1; failed[FILENAME] = $$3; last[FILENAME] = FNR } \
	    END { \
	        for (i = 1; i < ARGC; ++i) { \
	            name = ARGV[i]; \
	            if (!failed[name] && (!passed[name] || last[name] != lines[name])) failed[name] = 1; \
	            if (failed[name]) { print "\nFAILED: " name; system("grep -av \"^ok \" " name " | head -n 30") } \
	            all_passed += passed[name]; all_failed += failed[name]; \
	        } \
	        print all_passed + 0 " passed, " all_failed + 0 " failed"; \
	        exit all_failed || !all_passed; \
	    }' $(LOGS)
