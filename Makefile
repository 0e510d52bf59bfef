# conquest: a progressive mesh codec in one header. Everything that is built goes to build/.

CFLAGS ?= -O2
CLANG ?= clang-19
JOBS ?= $(shell nproc)

WARNINGS = -Wall -Wextra -Wconversion -pedantic
COMPILE = $(CC) -std=c99 $(WARNINGS) $(CPPFLAGS) -Iinclude $(CFLAGS) $(LDFLAGS)
HEADER = include/conquest.h
MESH_FILE = $(wildcard examples/mesh_file/*.c)
MESH_FILE_HEADERS = examples/mesh_file.h examples/mesh_file/reader.h
CQM_SOURCES = $(wildcard examples/cqm/*.c) $(MESH_FILE)
CQM_HEADERS = $(HEADER) examples/cqm/cqm.h $(MESH_FILE_HEADERS)

.DELETE_ON_ERROR:
.PHONY: all help clean install uninstall demo deps meshes ref_data check-ref test run summary

EXAMPLES = build/minimal_decode build/stream build/game_loop

all: build/cqm $(EXAMPLES) build/meshgen ## builds cqm, the examples and the mesh generator

help: ## lists the targets
	@awk -F ':.*## ' '/^[a-z0-9_-]+:.*## / { printf "make %-13s %s\n", $$1, $$2 }' Makefile

build/cqm: $(CQM_SOURCES) $(CQM_HEADERS)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples $(CQM_SOURCES) $(LDLIBS) -lm -o $@

$(EXAMPLES): build/%: examples/%.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

build/meshgen: tests/meshgen/meshgen.c
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

# -- Installation: also the package for CMake and pkg-config; examples/cmake has its parts --

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

clean: ## removes build/
	rm -rf build

# -- A game engine's loop: SDL2 and OpenGL 3.3 --

ENGINE_PACKAGES = pkg-config libsdl2-dev libepoxy-dev libgl-dev
SDL = $(shell pkg-config --$(1) sdl2 epoxy)

.PHONY: engine
engine: ## builds examples/engine, which draws a mesh while it streams
	$(call install,$(ENGINE_PACKAGES))
	@$(MAKE) --no-print-directory build/engine

build/engine: $(wildcard examples/engine/*) $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $(call SDL,cflags) $(filter %.c,$^) $(call SDL,libs) $(LDLIBS) -lm -o $@

# -- Web: WebAssembly by clang and lld, an ES module, three.js; the page --
#
# build/web/package is what npm packs, build/web/site what `make serve` shows. Packages of npm are in build/web/npm. clang
# runs wasm-opt of binaryen, which takes a tenth off.

WEB = build/web/package
WEB_PACKAGES = clang-19 lld-19 binaryen $(if $(shell command -v npm),,nodejs npm)
WEB_TEST_PACKAGES = $(WEB_PACKAGES) chromium
WEB_SOURCES = $(filter-out examples/web/serve.js,$(wildcard examples/web/*.js)) $(wildcard examples/web/*.json) \
    examples/web/README.md
WASM = $(CLANG) --target=wasm32 -std=c99 -flto -fuse-ld=lld -mbulk-memory -nostdlib -ffreestanding $(WARNINGS) \
    -Wno-unused-function -Iexamples/web/libc -Iinclude \
    -Wl,--no-entry,--import-memory,--initial-memory=196608,--stack-first,-z,stack-size=32768,--strip-all

.PHONY: web
web: ## builds the package for npm in build/web/package, and the page that shows it in build/web/site
	$(call install,$(WEB_PACKAGES))
	@$(MAKE) --no-print-directory build/web/complete $(SITE)/complete

build/web/complete: $(WEB)/types/conquest.d.ts
	@touch $@

build/web/npm/complete: tests/web/package.json tests/web/package-lock.json tests/web/.npmrc
	@mkdir -p $(@D)
	cp $^ $(@D)
	cd $(@D) && npm ci --ignore-scripts --loglevel=error
	@touch $@

# The small decoder begins; streams that are long, have seams or regular levels go on with the full one.
build/web/%.wasm: OPTIMISE = -O2
build/web/decoder.wasm: OPTIMISE = -Oz -DCQ_NO_WEDGES -DCQ_NO_REGULAR
build/web/decoder.wasm build/web/full.wasm: examples/web/decoder.c
build/web/encoder.wasm: examples/web/encoder.c
build/web/%.wasm: examples/web/libc/string.h $(HEADER)
	@mkdir -p $(@D)
	$(WASM) $(OPTIMISE) $(filter %.c,$^) -o $@

$(WEB)/%.wasm.js: build/web/%.wasm
	@mkdir -p $(@D)
	{ printf '/** @type {string} */\nconst code = "'; base64 -w 0 $<; printf '";\nexport default code;\n'; } >$@

$(WEB)/types/conquest.d.ts: $(WEB_SOURCES) $(patsubst %,$(WEB)/%.wasm.js,decoder full encoder) build/web/npm/complete \
    tests/web/tsconfig.json
	cp $(WEB_SOURCES) LICENSE $(WEB)
	@ln -sfn npm/node_modules build/web/node_modules
	build/web/npm/node_modules/.bin/tsc -p tests/web/tsconfig.json
	@touch $@

# The page: static files, meshes of build/meshes encoded by cqm.
SITE = build/web/site
SITE_MESHES = bunny00 elephant fandisk camel lion
SITE_LIBRARIES = three/build/three.module.js three/build/three.core.js three/examples/jsm/controls/OrbitControls.js \
    $(patsubst %,three/examples/jsm/loaders/%Loader.js,OBJ PLY STL) \
    three/examples/jsm/utils/BufferGeometryUtils.js meshoptimizer/meshopt_encoder.js meshoptimizer/meshopt_decoder.mjs \
    $(patsubst %,draco3d/draco_%,encoder_nodejs.js decoder_nodejs.js encoder.wasm decoder.wasm)
PORT ?= 8000

.PHONY: serve
serve: web ## shows examples/web/viewer on a loopback port: PORT=8000
	node examples/web/serve.js $(SITE) $(PORT)

$(SITE)/complete: build/web/complete build/web/npm/complete $(wildcard examples/web/viewer/*) \
    $(SITE_MESHES:%=$(SITE)/meshes/%.cqm)
	@mkdir -p $(SITE)/conquest
	cp examples/web/viewer/* $(SITE)
	cp $(WEB)/*.js $(SITE)/conquest
	cd build/web/npm/node_modules && cp --parents $(SITE_LIBRARIES) $(CURDIR)/$(SITE)
	@cd $(SITE)/meshes && printf '["%s"]\n' "$$(echo $(SITE_MESHES:%=%.cqm) | sed 's/ /", "/g')" >list.json
	@touch $@

$(SITE)/meshes/%.cqm: build/meshes/%.off build/cqm
	@mkdir -p $(@D)
	build/cqm encode --bits 14 $< $@

build/meshes/%.off: | build/meshes
	@test -e $@

# What npm packs, installed beside the tests, as a page or a program has it.
WEB_TEST = build/web/test
WEB_TESTS = $(wildcard tests/web/*.js tests/web/*.ts tests/web/*.html)

$(WEB_TEST)/complete: build/web/complete $(WEB_TESTS)
	@rm -rf $(WEB_TEST)
	@mkdir -p $(WEB_TEST)
	cp $(WEB_TESTS) examples/web/serve.js $(WEB_TEST)
	echo '{ "private": true, "type": "module" }' >$(WEB_TEST)/package.json
	cd $(WEB) && npm pack --silent --pack-destination ../test >/dev/null
	cd $(WEB_TEST) && npm install --offline --no-audit --no-fund --omit=peer --loglevel=error ./conquest-mesh-*.tgz
	@touch $@

FIRST_PICTURE_PACKAGES = $(WEB_PACKAGES) zstd

.PHONY: first-picture
first-picture: ## milliseconds until a mesh is seen and until it is exact, by ours and other codecs, and a plot
	$(call install,$(FIRST_PICTURE_PACKAGES))
	@$(MAKE) --no-print-directory -s $(WEB_TEST)/complete build/meshes
	@cp examples/web/viewer/codecs.js examples/web/viewer/off.js $(WEB_TEST)
	@$(call KEEP,(cd $(WEB_TEST) && node first-picture.js ../../meshes ../../first-picture))

.PHONY: readme-picture
readme-picture: ## draws README's picture of a mesh at 1, 5, 20, 100 % of its bytes
	$(call install,$(WEB_TEST_PACKAGES))
	@$(MAKE) --no-print-directory -s $(WEB_TEST)/complete $(SITE)/meshes/bunny00.cqm
	@cd $(WEB_TEST) && node strip.js ../site/meshes/bunny00.cqm ../../../examples/web/bunny.png

.PHONY: web-test
web-test: ## tests the package in node, and it and the page in a browser; GLTF=DIR adds glTF files
	$(call install,$(WEB_TEST_PACKAGES))
	@$(MAKE) --no-print-directory run LOGS='$(WEB_LOGS:%=build/log/%.log)'

WEB_LOGS = web-module web-gltf web-browser web-viewer
NODE_TEST = timeout 300 node --test --test-reporter=./reporter.js --test-concurrency=1

build/log/web-module.log: $(WEB_TEST)/complete build/cqm
	@mkdir -p $(@D)
	@cd $(WEB_TEST) && $(NODE_TEST) module.test.js >../../../$@ 2>&1 || true
	@echo "web-module: $$(tail -n 1 $@)"

build/log/web-browser.log: $(WEB_TEST)/complete
build/log/web-viewer.log: $(WEB_TEST)/complete $(SITE)/complete
build/log/web-gltf.log: $(WEB_TEST)/complete
build/log/web-gltf.log build/log/web-browser.log build/log/web-viewer.log: build/log/web-%.log:
	@mkdir -p $(@D)
	@cd $(WEB_TEST) && $(NODE_TEST) $*.test.js >../../../$@ 2>&1 || true
	@echo "web-$*: $$(tail -n 1 $@)"

# -- Meshes --------------------------------------------------------------------------------------------------------

meshes: build/meshes ## brings the 143 meshes of Debian's package libcgal-demo into build/meshes

build/meshes:
	@tests/meshes/fetch.sh $@

# Runs a command and keeps what it prints for `make quotes`; its exit status counts.
KEEP = mkdir -p build/printed && { { $(1); echo $$? >build/printed/$@.status; } | tee build/printed/$@.txt; \
    exit $$(cat build/printed/$@.status); }

demo: build/cqm build/meshes ## encodes and decodes some meshes and prints a table
	@$(call KEEP,tests/demo/demo.sh)

REF_DATA = build/cqm build/meshgen build/tests/reference/channels build/tests/reference/dump

ref_data: $(REF_DATA) ## makes the reference meshes and the streams of this format version again
	@ref_data/ref_data.sh make

check-ref: $(REF_DATA) ## decodes the reference streams of all versions and compares hashes
	@ref_data/ref_data.sh check

# -- Rates and priors ----------------------------------------------------------------------------------------------

MESHES ?= ../shared/meshes
LIST = tests/train/meshes.txt
ENCODE_SOURCES = $(patsubst %,examples/cqm/%.c,encode labels words border positions file) $(MESH_FILE)
ENCODE_HEADERS = $(CQM_HEADERS)
MEASURE_SOURCES = tests/table1/measure.c $(ENCODE_SOURCES)
SPEED_SOURCES = tests/speed/speed.c examples/cqm/decode.c examples/cqm/view.c examples/cqm/info.c $(ENCODE_SOURCES)

# $(call manifolds,CONDITION): the oriented manifolds of build/meshes, by what the round trip of all meshes expects: of others
# something is told, even of their connectivity alone.
manifolds = $(shell awk '{ alone = $$0; sub(/.*but --connectivity: /, "", alone) } \
    /^build.meshes/ && $$2 == "ok" && alone !~ /told/ && $(1) { print $$1 }' tests/meshes/expected.tsv)
MANIFOLDS = $(call manifolds,$$3 >= 300)
ALL_MANIFOLDS = $(call manifolds,1)

.PHONY: table1 rates train check-train effects memory speed

table1: build/table1 build/generated/torus_270x135.off ## the paper's Table 1 beside ours; MESHES=DIR has its models
	@$(call KEEP,build/table1 $(MESHES) build/generated/torus_270x135.off)

rates: build/rates build/meshes ## bits per vertex of meshes that the priors were trained on, and of the others
	@$(call KEEP,build/rates $(LIST) $(MANIFOLDS))

train: build/train build/meshes ## fits the priors in the header to the meshes of tests/train/meshes.txt
	@tests/train/priors.sh write

check-train: build/train build/meshes ## checks that training gives the priors in the header
	@tests/train/priors.sh check

effects: build/train build/meshes build/generated/torus_270x135.off ## what each part of the split model is worth
	@build/train --effects $$(sed '/^#/d; s,^,build/meshes/,' $(LIST)) -- $(MESHES)/*.off build/generated/torus_270x135.off

memory: build/memory build/memory-16 ## bytes that the decoder and the encoder need
	@$(call KEEP,build/memory && build/memory-16)

speed: build/speed build/meshes ## microseconds per split of the decoder, for some meshes
	@$(call KEEP,build/speed $(SPEED_MESHES) $(wildcard $(MESHES)/horse.off))

SPEED_MESHES = $(patsubst %,build/meshes/%.off,fandisk bunny00 camel)

build/speed: $(SPEED_SOURCES) $(ENCODE_HEADERS)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples/cqm $(SPEED_SOURCES) $(LDLIBS) -lm -o $@

build/memory: tests/memory/memory.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

build/memory-16: tests/memory/memory.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) -DCQ_INDEX_BITS=16 $< $(LDLIBS) -o $@

build/table1 build/rates: build/%: tests/table1/%.c tests/table1/measure.h $(MEASURE_SOURCES) $(ENCODE_HEADERS)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples/cqm $< $(MEASURE_SOURCES) $(LDLIBS) -lm -o $@

build/train: tests/train/train.c $(ENCODE_SOURCES) $(ENCODE_HEADERS)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples/cqm $< $(ENCODE_SOURCES) $(LDLIBS) -lm -o $@

build/generated/torus_270x135.off: build/meshgen
	@mkdir -p $(@D)
	@build/meshgen torus 270 135 >$@

# -- Triangles instead of edges ------------------------------------------------------------------------------------
#
# tests/measure/face_collapse: the experiment that the paper leaves to others, with its own encoder and decoder. The
# paper's models come from MESHES=DIR.

FACE_COLLAPSE = tests/measure/face_collapse

.PHONY: face-collapse deps-face-collapse
face-collapse: deps-face-collapse build/meshes build/generated/torus_270x135.off ## removes triangles, not edges
	@$(MAKE) --no-print-directory -s build/face_collapse
	@build/face_collapse $(MESHES) build/generated/torus_270x135.off build/meshes/*

deps-face-collapse:
	$(call install,g++ libcgal-dev)

build/face_collapse: $(FACE_COLLAPSE)/face_collapse.cpp $(wildcard $(FACE_COLLAPSE)/*.hpp)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -O2 $< $(LDFLAGS) -o $@

# -- Tests ---------------------------------------------------------------------------------------------------------
#
# A test is a program or a recipe that writes build/log/NAME.log, whose last line is `N passed, N failed`. Each C or C++
# file of tests/unit and tests/property is a program that is built four times; `make build/tests/unit/mesh` builds one.
#
#     unit/mesh      clang, sanitizers for addresses and undefined behaviour, assertions
#     unit/mesh-16   the same with 16-bit indices, but for unit/words: cqm has 32
#     unit/mesh-O3   gcc, optimised, no assertions
#     unit/mesh-O0   gcc, not optimised, assertions

PROGRAMS = $(basename $(patsubst tests/%,%,$(wildcard tests/unit/*.c tests/unit/*.cpp tests/property/*.cpp)))
EXHAUSTIVE = exhaustive/roundtrip exhaustive/splits exhaustive/symbols exhaustive/regular exhaustive/payloads \
    exhaustive/payloads-3
CGAL = cgal/splits
TESTS = headers vendor python engine $(WEB_LOGS) ref_data examples channels inputs seams \
    embedded meshes bases reference portability fuzz fuzz-16 fuzz-msan fuzz-work \
    $(CGAL) $(EXHAUSTIVE) \
    $(filter-out unit/words-16,$(foreach suffix,- -16 -O3 -O0,$(PROGRAMS:%=%$(suffix:-=))))
LOGS = $(TESTS:%=build/log/%.log)

test: deps build/meshes ## installs what the tests need and runs everything under tests/
	@rm -rf build/log
	@$(MAKE) --no-print-directory run

# What takes longer than a test may: make verify.
VERIFY = verify/exhaustive-roundtrip verify/exhaustive-splits verify/exhaustive-symbols verify/exhaustive-regular \
    verify/cgal-splits \
    batch proof proof-bugs portability-all windows vendor-windows coverage mutation
VERIFY_LOGS = $(VERIFY:%=build/log/%.log)

.PHONY: cgal exhaustive verify
cgal: deps build/meshes ## compares each split and flip of real and random meshes with CGAL
	@$(MAKE) --no-print-directory run LOGS='$(CGAL:%=build/log/%.log)'

exhaustive: deps ## all small spheres, tori and discs: first gates, splits, regular levels; all small payloads
	@$(MAKE) --no-print-directory run LOGS='$(EXHAUSTIVE:%=build/log/%.log)'

verify: verify-deps build/meshes ## what takes hours: larger spheres, proofs, other machines, coverage, mutants
	@$(MAKE) --no-print-directory run LOGS='$(VERIFY_LOGS)'

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

build/log/%.log: build/tests/%
	@mkdir -p $(@D)
	@ASAN_OPTIONS=handle_sigill=1 $< >$@ 2>&1 || echo "exit status $$?" >>$@
	@echo "$*: $$(tail -n 1 $@)"

# A test that is written and not run is an unused function.
TEST_FLAGS = $(WARNINGS) -Werror=unused-function -g -Iinclude -Iexamples -Itests/support
TEST_DEPENDS = $(HEADER) $(wildcard tests/support/* examples/*.h examples/mesh_file/*)
ASSERTIONS = '-DCQ_ASSERT(c)=((c) ? (void)0 : __builtin_trap())'
SANITIZERS = -O1 -fsanitize=address,undefined -fno-sanitize-recover=all $(ASSERTIONS)

# $(1) suffix, $(2) C compiler, $(3) C++ compiler, $(4) flags
define variant
build/tests/%$(1): tests/%.c $$(TEST_DEPENDS)
	@mkdir -p $$(@D)
	$(2) -std=c99 $$(TEST_FLAGS) $(4) $$< -lm -o $$@
build/tests/%$(1): tests/%.cpp $$(TEST_DEPENDS)
	@mkdir -p $$(@D)
	$(3) -std=c++17 $$(TEST_FLAGS) $(4) $$< -lrapidcheck -o $$@
endef
CLANGXX = $(subst clang,clang++,$(CLANG))
$(eval $(call variant,,$(CLANG),$(CLANGXX),$(SANITIZERS)))
$(eval $(call variant,-16,$(CLANG),$(CLANGXX),$(SANITIZERS) -DCQ_INDEX_BITS=16))
$(eval $(call variant,-O3,gcc,g++,-O3 -DNDEBUG))
$(eval $(call variant,-O0,gcc,g++,-O0 $(ASSERTIONS)))
.SECONDARY:

PACKAGES = gcc g++ clang-19 libclang-rt-19-dev lld-19 librapidcheck-dev libcgal-dev \
    python3 python3-dev python3-venv cmake pkg-config man-db bsdextrautils xvfb xauth libgl1-mesa-dri \
    $(ENGINE_PACKAGES) $(WEB_TEST_PACKAGES) $(EMBEDDED_PACKAGES) $(PORTABILITY_PACKAGES)
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

# $(call install,PACKAGES): those that are missing
define install
	@missing=$$(for p in $(1); do \
	    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || echo $$p; done); \
	test -z "$$missing" || { $(SUDO) apt-get -q update && \
	    DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get -q install -y --no-install-recommends $$missing </dev/null; }
endef

deps: ## installs what the tests need, if missing (Debian and Ubuntu)
	$(call install,$(PACKAGES))

.PHONY: verify-deps
verify-deps: deps ## installs what `make verify` needs beside that
	$(call install,$(VERIFY_PACKAGES))

build/log/ref_data.log: $(REF_DATA)
	@mkdir -p $(@D)
	@ref_data/ref_data.sh check >$@ 2>&1 || true
	@echo "ref_data: $$(tail -n 1 $@)"

VENDOR = build/cqm.1 build/package/libconquest.a $(HEADER) $(wildcard examples/cmake/* tests/vendor/* tests/vendor/*/*)

build/log/vendor.log: $(VENDOR)
	@mkdir -p $(@D)
	@CLANG=$(CLANG) tests/vendor/vendor.sh >$@ 2>&1 || true
	@echo "vendor: $$(tail -n 1 $@)"

build/log/vendor-windows.log: $(VENDOR)
	@mkdir -p $(@D)
	@tests/vendor/vendor.sh windows >$@ 2>&1 || true
	@echo "vendor-windows: $$(tail -n 1 $@)"

# The package is built as a wheel and installed, beside what it is tested with.
PYTHON = build/python/venv/bin/python
PYTEST = pytest -q -p no:cacheprovider -o pythonpath=../support -p last_line
PYTHON_SOURCES = $(HEADER) $(wildcard examples/python/* examples/python/conquest/* examples/python/conquest/*/*) $(CQM_SOURCES) $(CQM_HEADERS)

build/python/venv/complete: tests/python/requirements.txt
	@mkdir -p $(@D)
	python3 -m venv $(@D)
	$(@D)/bin/pip install -q -r $<
	@touch $@

build/python/installed: build/python/venv/complete $(PYTHON_SOURCES)
	@rm -rf build/python/wheels
	$(PYTHON) -m pip wheel -q --no-deps --no-build-isolation -w build/python/wheels ./examples/python
	$(PYTHON) -m pip install -q --no-deps --force-reinstall build/python/wheels/*.whl
	@touch $@

build/log/python.log: build/python/installed build/cqm README.md $(wildcard tests/python/*)
	@mkdir -p $(@D)
	@cd tests/python && CQM=../../build/cqm ../../$(PYTHON) -m $(PYTEST) >../../$@ 2>&1 || true
	@echo "python: $$(tail -n 1 $@)"

# conquest.batch, with a scheduler and workers on loopback: what it needs has a virtual environment of its own.
build/batch/venv/complete: tests/batch/requirements.txt
	@mkdir -p $(@D)
	python3 -m venv $(@D)
	$(@D)/bin/pip install -q -r $<
	@touch $@

build/log/batch.log: build/batch/venv/complete build/python/installed $(wildcard tests/batch/*)
	@mkdir -p $(@D)
	@build/batch/venv/bin/pip install -q --no-deps --force-reinstall build/python/wheels/*.whl
	@cd tests/batch && ../../build/batch/venv/bin/python -m $(PYTEST) >../../$@ 2>&1 || true
	@echo "batch: $$(tail -n 1 $@)"

build/log/engine.log: build/engine build/cqm build/meshes build/python/venv/complete tests/engine/engine.py
	@mkdir -p $(@D)
	@xvfb-run -a -s "-screen 0 1024x768x24" $(PYTHON) tests/engine/engine.py build/engine build/cqm \
	    build/meshes/bunny00.off build/engine-test >$@ 2>&1 || true
	@echo "engine: $$(tail -n 1 $@)"

build/log/examples.log: build/cqm $(EXAMPLES) build/tests/minimal_decode-16
	@mkdir -p $(@D)
	@tests/demo/examples.sh >$@ 2>&1 || true
	@echo "examples: $$(tail -n 1 $@)"

build/log/channels.log: build/tests/cqm build/meshgen tests/demo/channels.py tests/demo/checks.py
	@mkdir -p $(@D)
	@python3 tests/demo/channels.py build/tests/cqm build/meshgen build/channels >$@ 2>&1 || true
	@echo "channels: $$(tail -n 1 $@)"

build/log/inputs.log: build/tests/cqm tests/demo/inputs.py tests/demo/checks.py
	@mkdir -p $(@D)
	@python3 tests/demo/inputs.py build/tests/cqm build/inputs >$@ 2>&1 || true
	@echo "inputs: $$(tail -n 1 $@)"

build/log/seams.log: build/tests/cqm tests/demo/seams.py tests/demo/meshes.py tests/demo/checks.py
	@mkdir -p $(@D)
	@python3 tests/demo/seams.py build/tests/cqm build/seams >$@ 2>&1 || true
	@echo "seams: $$(tail -n 1 $@)"

build/log/meshes.log: build/tests/cqm build/meshgen build/meshes
	@mkdir -p $(@D)
	@tests/meshes/check.sh build/tests/cqm >$@ 2>&1 || true
	@echo "meshes: $$(tail -n 1 $@)"

build/log/bases.log: build/cqm build/meshes tests/meshes/bases.py
	@mkdir -p $(@D)
	@python3 tests/meshes/bases.py build/cqm build/bases $(ALL_MANIFOLDS) >$@ 2>&1 || true
	@echo "bases: $$(tail -n 1 $@)"

# Files of other projects through cqm, and how trimesh reads them before and after: OBJ, PLY, STL and OFF of Debian's package
# assimp-testmodels, and of pybullet_data, which comes with the package pybullet. 1250 files, some minutes.
ASSETS = assimp-testmodels=/usr/share/assimp/models \
    pybullet_data=$$(echo build/assets/venv/lib/python3*/site-packages/pybullet_data)

.PHONY: assets deps-assets
assets: deps-assets build/cqm build/assets/venv/complete ## encodes 1250 published files, compares with trimesh's reading
	@$(call KEEP,build/assets/venv/bin/python -W ignore tests/assets/assets.py build/cqm build/assets/files $(ASSETS))

deps-assets:
	$(call install,python3 python3-venv assimp-testmodels)

build/assets/venv/complete: tests/assets/requirements.txt
	@mkdir -p $(@D)
	python3 -m venv $(@D)
	$(@D)/bin/pip install -q -r $<
	@touch $@

# The second decoder, tests/reference/decoder.py, must agree; SPEC.md must have the header's tables.
REFERENCE = $(wildcard tests/reference/*.py) SPEC.md build/cqm build/tests/reference/dump build/tests/reference/channels
COMPARE = tests/reference/compare.py build/cqm build/tests/reference

build/log/reference.log: $(REFERENCE) build/meshes
	@mkdir -p $(@D)
	@python3 $(COMPARE) >$@ 2>&1 || true
	@echo "reference: $$(tail -n 1 $@)"

.PHONY: reference
reference: deps $(REFERENCE) build/meshes ## compares both decoders on larger meshes and 15 000 random streams
	@python3 $(COMPARE) --all

build/tests/minimal_decode-16: examples/minimal_decode.c $(HEADER)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) $(SANITIZERS) -DCQ_INDEX_BITS=16 $< -o $@

build/tests/cqm: $(CQM_SOURCES) $(CQM_HEADERS)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) $(SANITIZERS) $(CQM_SOURCES) -lm -o $@

# -- Devices -------------------------------------------------------------------------------------------------------
#
# tests/embedded: examples/microcontroller for each device, in qemu, against the host; budgets and exact figures.

EMBEDDED = build/cqm build/meshgen $(HEADER) tests/memory/memory.c \
    $(wildcard examples/microcontroller/* tests/embedded/*)

.PHONY: embedded figures
embedded: deps build/cqm build/meshgen ## decodes on devices in emulators, checks budgets of code, stack, RAM
	@tests/embedded/embedded.sh check

figures: deps build/cqm build/meshgen ## measures code, stack, RAM, instructions; writes README's tables
	@tests/embedded/embedded.sh figures

build/log/embedded.log: $(EMBEDDED)
	@mkdir -p $(@D)
	@tests/embedded/embedded.sh check >$@ 2>&1 || true
	@echo "embedded: $$(tail -n 1 $@)"

# -- Bench ---------------------------------------------------------------------------------------------------------
#
# Codecs of tests/bench from packages, on the same meshes; results in build/bench. Times depend on the machine: no test.

BENCH_PACKAGES = g++ libdraco-dev libmeshoptimizer-dev libzstd-dev libopenctm-dev python3-matplotlib \
    $(if $(shell command -v npm),,npm)
BENCH_OBJECTS = $(patsubst tests/bench/%.cpp,build/bench/%.o,$(wildcard tests/bench/*.cpp)) \
    $(MESH_FILE:examples/%.c=build/bench/%.o)

.PHONY: bench deps-bench
bench: deps-bench build/meshes build/meshgen ## compares size, speed, memory with other codecs; QUICK=1: a minute
	@$(MAKE) --no-print-directory -s build/bench/bench
	@$(call KEEP,tests/bench/bench.sh)

deps-bench:
	$(call install,$(BENCH_PACKAGES))

build/bench/bench: $(BENCH_OBJECTS)
	$(CXX) $(LDFLAGS) $^ -ldraco -lmeshoptimizer -lzstd -lopenctm -lm -o $@

build/bench/%.o: tests/bench/%.cpp $(wildcard tests/bench/*.hpp examples/*.h) $(HEADER)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iinclude -Iexamples -O2 -c $< -o $@

build/bench/mesh_file/%.o: examples/mesh_file/%.c $(MESH_FILE_HEADERS)
	@mkdir -p $(@D)
	$(CC) -std=c99 $(WARNINGS) $(CPPFLAGS) -O2 -c $< -o $@

# -- Bytes of many meshes ------------------------------------------------------------------------------------------
#
# tests/peers: ours and Draco's, by class of mesh; and of published files with seams, with all their attributes. All that
# was measured goes to build/peers/results.tsv and assets.tsv.

PEERS_PACKAGES = g++ libdraco-dev python3
PEERS_OBJECTS = build/peers/peers.o build/bench/draco.o build/bench/mesh.o $(MESH_FILE:examples/%.c=build/bench/%.o)

.PHONY: peers deps-peers
peers: deps-peers deps-assets build/meshes build/assets/venv/complete ## compares bytes with Draco's, by class; MESHES=DIR adds meshes
	@$(MAKE) --no-print-directory -s build/peers/peers build/peers/assets
	@$(call KEEP,(tests/peers/peers.sh $(MESHES); status=$$?; echo; tests/peers/assets.sh $(ASSETS) && exit $$status))

deps-peers:
	$(call install,$(PEERS_PACKAGES))

build/peers/peers: $(PEERS_OBJECTS)
	$(CXX) $(LDFLAGS) $^ -ldraco -lm -o $@

build/peers/assets: build/peers/assets.o $(MESH_FILE:examples/%.c=build/bench/%.o)
	$(CXX) $(LDFLAGS) $^ -ldraco -lm -o $@

build/peers/%.o: tests/peers/%.cpp tests/bench/bench.hpp tests/bench/ours.hpp $(HEADER)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iinclude -Iexamples -O2 -c $< -o $@

# -- Quality -------------------------------------------------------------------------------------------------------
#
# tests/quality: distance from the exact mesh against bytes, for each goal, Draco and meshoptimizer's simplifier, of
# meshes of the package and those in MESHES=DIR. Curves, contact sheets and targets go to build/quality.

QUALITY_PACKAGES = g++ libdraco-dev libmeshoptimizer-dev python3-venv libegl1
QUALITY_MESHES = $(patsubst %,build/meshes/%.off,fandisk bunny00 bear elephant lion)
QUALITY_MORE = $(filter-out $(addprefix %/,$(notdir $(QUALITY_MESHES))),$(wildcard $(MESHES)/*.off))

.PHONY: quality deps-quality
quality: deps-quality build/meshes build/cqm ## draws rate-distortion curves and contact sheets; MESHES=DIR adds meshes
	@$(MAKE) --no-print-directory -s build/quality/peers build/quality/lods build/quality/venv/complete
	@build/quality/venv/bin/python tests/quality/surface_test.py
	@$(call KEEP,build/quality/venv/bin/python tests/quality/quality.py build/cqm build/quality/peers build/quality/lods \
	    build/quality $(QUALITY_MESHES) $(QUALITY_MORE))

deps-quality:
	$(call install,$(QUALITY_PACKAGES))

build/quality/peers: tests/quality/peers.cpp $(MESH_FILE:examples/%.c=build/bench/%.o)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iexamples -O2 $^ $(LDFLAGS) -ldraco -lmeshoptimizer -lm -o $@

build/quality/lods: tests/quality/lods.c $(MESH_FILE:examples/%.c=build/bench/%.o) $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples $(filter-out $(HEADER),$^) $(LDLIBS) -lm -o $@

build/quality/venv/complete: tests/quality/requirements.txt
	@mkdir -p $(@D)
	python3 -m venv $(@D)
	$(@D)/bin/pip install -q -r $<
	@touch $@

# -- Proof by cases ------------------------------------------------------------------------------------------------
#
# tests/exhaustive: everything that is small; payloads also counts basic blocks. tests/cgal: an independent library
# does the same. Optimised, with assertions.

EXHAUSTIVE_DEPENDS = $(TEST_DEPENDS) $(wildcard tests/exhaustive/*.hpp)
OPTIMISED = -std=c++17 $(TEST_FLAGS) -O2 $(ASSERTIONS)
TEST_NAME = $(@:build/log/%.log=%)
RUN_TO_LOG = @mkdir -p $(@D); $(1) >$@ 2>&1 || echo "exit status $$?" >>$@; echo "$(TEST_NAME): $$(tail -n 1 $@)"

build/tests/exhaustive/%: tests/exhaustive/%.cpp $(EXHAUSTIVE_DEPENDS)
	@mkdir -p $(@D)
	$(CLANGXX) $(OPTIMISED) $< -o $@

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
	$(call RUN_TO_LOG,$< 3)

build/log/verify/exhaustive-%.log: build/tests/exhaustive/%
	$(call RUN_TO_LOG,$< all)

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

build/tests/cgal/%: tests/cgal/%.cpp $(TEST_DEPENDS)
	@mkdir -p $(@D)
	g++ $(OPTIMISED) $< -o $@

build/log/cgal/splits.log: build/tests/cgal/splits build/meshes $(SUBDIVIDED)
	$(call RUN_TO_LOG,$< 250 $(OFF_MANIFOLDS) $(SUBDIVIDED))

build/log/verify/cgal-splits.log: build/tests/cgal/splits build/meshes $(SUBDIVIDED)
	$(call RUN_TO_LOG,$< 1000 $(OFF_MANIFOLDS) $(SUBDIVIDED))

# -- Verification --------------------------------------------------------------------------------------------------
#
# What takes too long for `make test`. Each target also runs alone; all end with `N passed, N failed`.

.PHONY: proof proof-bugs portability windows mutation coverage quotes

quotes: ## compares the numbers in README and SECURITY with what the commands that they name printed last
	@python3 tests/quotes/quotes.py

proof: ## proves the claims of tests/proof/README.md with CBMC, which it fetches
	$(call install,$(PROOF_PACKAGES))
	@tests/proof/prove.sh

proof-bugs: ## plants bugs into the header and checks that the proofs fail
	$(call install,$(PROOF_PACKAGES))
	@tests/proof/prove.sh --bugs

portability: verify-deps ## compares streams and decoded meshes of all compilers, options and emulated machines
	@CLANG=$(CLANG) tests/portability/portability.sh all

build/log/portability.log: $(HEADER) $(wildcard tests/portability/*)
	@mkdir -p $(@D)
	@CLANG=$(CLANG) tests/portability/portability.sh native >$@ 2>&1 || true
	@echo "portability: $$(tail -n 1 $@)"

build/log/portability-all.log: $(HEADER) $(wildcard tests/portability/*)
	@mkdir -p $(@D)
	@CLANG=$(CLANG) tests/portability/portability.sh all >$@ 2>&1 || true
	@echo "portability-all: $$(tail -n 1 $@)"

windows: ## builds cqm for Windows and macOS, compares what it does under wine with what it does here
	$(call install,$(WINDOWS_PACKAGES))
	@$(MAKE) --no-print-directory build/log/windows.log build/log/vendor-windows.log

build/portability/venv/complete: tests/portability/requirements.txt
	@mkdir -p $(@D)
	python3 -m venv $(@D)
	$(@D)/bin/pip install -q -r $<
	@touch $@

build/log/windows.log: tests/portability/windows.sh build/portability/venv/complete build/cqm $(EXAMPLES) \
    $(wildcard examples/*.c)
	@mkdir -p $(@D)
	@tests/portability/windows.sh >$@ 2>&1 || true
	@echo "windows: $$(tail -n 1 $@)"

mutation: deps ## 300 small changes of the header: do the tests notice? MUTANTS=n for another number
	@CLANG=$(CLANG) tests/mutation/mutation.sh $(MUTANTS)

MUTANTS = 300

build/log/mutation.log: $(HEADER) $(wildcard tests/mutation/*)
	@mkdir -p $(@D)
	@CLANG=$(CLANG) tests/mutation/mutation.sh $(MUTANTS) >$@ 2>&1 || true
	@echo "mutation: $$(tail -n 1 $@)"

coverage: verify-deps ## lines and branches of the header that the tests reach; fails below 100 % and 98 %
	@CLANG=$(CLANG) tests/coverage/coverage.sh

build/log/coverage.log: $(HEADER) $(wildcard tests/coverage/* tests/unit/* tests/property/*)
	@mkdir -p $(@D)
	@CLANG=$(CLANG) tests/coverage/coverage.sh >$@ 2>&1 || true
	@echo "coverage: $$(tail -n 1 $@)"

build/log/proof.log: $(HEADER) $(wildcard tests/proof/*)
	@mkdir -p $(@D)
	@tests/proof/prove.sh >$@ 2>&1 || true
	@echo "proof: $$(tail -n 1 $@)"

build/log/proof-bugs.log: $(HEADER) $(wildcard tests/proof/*)
	@mkdir -p $(@D)
	@tests/proof/prove.sh --bugs >$@ 2>&1 || true
	@echo "proof-bugs: $$(tail -n 1 $@)"

# -- Fuzzing -------------------------------------------------------------------------------------------------------
#
# `make fuzz` runs libFuzzer. The committed inputs are part of the tests and need no libFuzzer: fuzz, fuzz-16 and
# fuzz-msan run all of them, under MemorySanitizer in the last; fuzz-work counts what hostile meshes and streams cost.
# mutator.c needs a header whose functions that decode have other names.

FUZZ_TARGETS = $(patsubst fuzz/%.c,%,$(filter-out fuzz/run.c fuzz/work.c fuzz/mutator.c,$(wildcard fuzz/*.c)))
FUZZ_DEPENDS = $(HEADER) $(wildcard fuzz/*.h) $(MESH_FILE) $(MESH_FILE_HEADERS)
COUNT_WORK = -DFUZZ_COUNTS_WORK -fsanitize-coverage=trace-pc
SECONDS ?= 120

.PHONY: fuzz
fuzz: deps ## runs all fuzz targets for SECONDS=n in all, and reports executions and coverage of each
	@$(call KEEP,CLANG=$(CLANG) fuzz/fuzz.sh $(SECONDS))

.PHONY: fuzz-coverage
fuzz-coverage: verify-deps ## what the inputs of each target reach in the header
	@$(call KEEP,CLANG=$(CLANG) fuzz/fuzz.sh coverage)

# $(1) suffix, $(2) flags
define fuzz_variant
build/fuzz/%$(1).o: fuzz/%.c $$(FUZZ_DEPENDS)
	@mkdir -p $$(@D)
	$(CLANG) -std=c99 $$(TEST_FLAGS) $(2) -DLLVMFuzzerTestOneInput=fuzz_$$* -c $$< -o $$@
build/fuzz/mutator$(1).o: fuzz/mutator.c fuzz/asked.sh $$(FUZZ_DEPENDS)
	@fuzz/asked.sh $$(HEADER) build/fuzz/asked$(1)
	$(CLANG) -std=c99 -Ibuild/fuzz/asked$(1) $$(TEST_FLAGS) $(2) -c $$< -o $$@
build/fuzz/run$(1): $$(FUZZ_TARGETS:%=build/fuzz/%$(1).o) build/fuzz/mutator$(1).o build/fuzz/run$(1).o
	$(CLANG) $(2) $$^ -lm -o $$@
build/log/fuzz$(1).log: build/fuzz/run$(1) $$(wildcard fuzz/seeds/*/* fuzz/regressions/*/*)
	@mkdir -p $$(@D)
	@$$< >$$@ 2>&1 || true
	@echo "fuzz$(1): $$$$(tail -n 1 $$@)"
endef
$(eval $(call fuzz_variant,,$(SANITIZERS) $(COUNT_WORK)))
$(eval $(call fuzz_variant,-16,$(SANITIZERS) $(COUNT_WORK) -DCQ_INDEX_BITS=16))
$(eval $(call fuzz_variant,-msan,-O1 -fsanitize=memory -fno-sanitize-recover=all))

build/fuzz/work: fuzz/work.c $(FUZZ_DEPENDS)
	@mkdir -p $(@D)
	$(CLANG) -std=c99 $(TEST_FLAGS) -O1 $(COUNT_WORK) $< -o $@

build/log/fuzz-work.log: build/fuzz/work
	@mkdir -p $(@D)
	@$< >$@ 2>&1 || true
	@echo "fuzz-work: $$(tail -n 1 $@)"

# -- The header in every way that it may be compiled ---------------------------------------------------------------

define first_unit
#include "conquest.h"
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "conquest.h"
extern const char *second_unit(void);
int main(void) { return second_unit() != cq_result_string(CQ_DONE); }
endef

define second_unit
#include "conquest.h"
#include "conquest.h"
extern const char *second_unit(void);
const char *second_unit(void) { return cq_result_string(CQ_DONE); }
endef

define private_unit
#define CQ_API static inline
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
int main(void) { return !cq_result_string(CQ_DONE); }
endef

export first_unit second_unit private_unit

# Files that disagree about the width of indices do not link; libraries of both widths do.
#
# What the compiled header asks of the system, and what it keeps in writable memory: nothing but these two. And no
# floating point beside the quantiser: a compiler that may not use it has nothing to say.
FREESTANDING = gcc -x c -std=c99 -Os -ffreestanding -fno-stack-protector -fno-pic
IMPORTS = memcpy|memset|second_unit

# All combinations as words: gcc/c99/16 ...
HEADER_BUILDS = $(foreach c,gcc $(CLANG),$(foreach s,c99 c11 c++11 c++17,$(foreach b,16 32,$(c)/$(s)/$(b))))

build/log/headers.log: $(HEADER)
	@mkdir -p $(@D) build/headers
	@passed=0; failed=0; cd build/headers; \
	for unit in first second private; do printenv $${unit}_unit >$$unit; done; \
	check() { if "$$@"; then passed=$$((passed + 1)); else failed=$$((failed + 1)); echo "FAIL $$*"; fi; }; \
	for build in $(HEADER_BUILDS); do \
	    compiler=$${build%%/*} bits=$${build##*/} standard=$${build#*/}; standard=$${standard%/*}; \
	    language=$${standard%%[0-9]*}; \
	    options="-x $$language -std=$$standard -DCQ_INDEX_BITS=$$bits -O2 $(WARNINGS) -Werror -I../../include"; \
	    check $$compiler $$options first second -o program && check ./program; \
	    check $$compiler $$options private -o program && check ./program; \
	done >../log/headers.log 2>&1; \
	check $(FREESTANDING) -I../../include -c first -o first.o >>../log/headers.log 2>&1; \
	check $(FREESTANDING) -I../../include -mgeneral-regs-only -DCQ_NO_QUANTISER -c first -o integers.o \
	    >>../log/headers.log 2>&1; \
	for bits in 16 32; do \
	    gcc -x c -std=c99 -I../../include -DCQ_INDEX_BITS=$$bits -c first -o first-$$bits.o; \
	    gcc -x c -std=c99 -I../../include -DCQ_INDEX_BITS=$$bits -c second -o second-$$bits.o; \
	    gcc -x c -std=c99 -I../../include -DCQ_INDEX_BITS=$$bits -Dmain=other_main -c first -o library-$$bits.o; \
	done >>../log/headers.log 2>&1; \
	unresolved() { ! "$$@" >link.log 2>&1 && grep -q 'undefined reference to .cq_result_string' link.log; }; \
	for bits in 16 32; do \
	    check unresolved gcc first-$$bits.o second-$$((48 - bits)).o -o program; \
	    check gcc first-$$bits.o second-$$bits.o library-$$((48 - bits)).o -o program && check ./program; \
	done >>../log/headers.log 2>&1; \
	check test -z "$$(nm first.o | grep -E ' [BbCDdU] ' | grep -Evw '$(IMPORTS)')" >>../log/headers.log; \
	echo "$$passed passed, $$failed failed" >>../log/headers.log
	@echo "headers: $$(tail -n 1 $@)"
