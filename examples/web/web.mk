# Web: WebAssembly by clang and lld, an ES module, three.js; the page that shows it.
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

# The small decoder begins; streams that are long, have attributes, seams or regular levels go on with the full one.
build/web/full.wasm: OPTIMISE = -O3
build/web/encoder.wasm: OPTIMISE = -O2
build/web/decoder.wasm: OPTIMISE = -Oz -DCQ_NO_WEDGES -DCQ_NO_REGULAR -DCQ_NO_ATTRIBUTES
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
	cp -R $(WEB_SOURCES) examples/web/CONQUEST_mesh_progressive LICENSE $(WEB)
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
