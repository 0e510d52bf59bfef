# What is measured: rates, speed, memory, other codecs, quality. Nothing here is a test; what is printed is kept for `make
# quotes`.

MESHES ?= ../shared/meshes
LIST = tests/train/meshes.txt
ENCODE_SOURCES = $(patsubst %,examples/cqm/%.c,encode labels words border positions file) $(MESH_FILE)
ENCODE_HEADERS = $(CQM_HEADERS)
MEASURE_SOURCES = tests/measure/rates/measure.c $(ENCODE_SOURCES)
SPEED_SOURCES = tests/measure/speed/speed.c examples/cqm/decode.c examples/cqm/view.c examples/cqm/info.c $(ENCODE_SOURCES)

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

build/memory: tests/measure/memory/memory.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) $< $(LDLIBS) -o $@

build/memory-16: tests/measure/memory/memory.c $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) -DCQ_INDEX_BITS=16 $< $(LDLIBS) -o $@

build/table1 build/rates: build/%: tests/measure/rates/%.c tests/measure/rates/measure.h $(MEASURE_SOURCES) $(ENCODE_HEADERS)
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

# -- Bench ---------------------------------------------------------------------------------------------------------
#
# Codecs of tests/measure/bench from packages, on the same meshes; results in build/bench. Times depend on the machine: no test.

BENCH_PACKAGES = g++ libdraco-dev libmeshoptimizer-dev libzstd-dev libopenctm-dev python3-matplotlib \
    $(if $(shell command -v npm),,npm)
BENCH_OBJECTS = $(patsubst tests/measure/bench/%.cpp,build/bench/%.o,$(wildcard tests/measure/bench/*.cpp)) \
    $(MESH_FILE:examples/%.c=build/bench/%.o)

.PHONY: bench deps-bench
bench: deps-bench build/meshes build/meshgen ## compares size, speed, memory with other codecs; QUICK=1: a minute
	@$(MAKE) --no-print-directory -s build/bench/bench
	@$(call KEEP,tests/measure/bench/bench.sh)

deps-bench:
	$(call install,$(BENCH_PACKAGES))

build/bench/bench: $(BENCH_OBJECTS)
	$(CXX) $(LDFLAGS) $^ -ldraco -lmeshoptimizer -lzstd -lopenctm -lm -o $@

build/bench/%.o: tests/measure/bench/%.cpp $(wildcard tests/measure/bench/*.hpp examples/*.h) $(HEADER)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iinclude -Iexamples -O2 -c $< -o $@

build/bench/mesh_file/%.o: examples/mesh_file/%.c $(MESH_FILE_HEADERS)
	@mkdir -p $(@D)
	$(CC) -std=c99 $(WARNINGS) $(CPPFLAGS) -O2 -c $< -o $@

# -- Bytes of many meshes ------------------------------------------------------------------------------------------
#
# tests/measure/peers: ours and Draco's, by class of mesh; and of published files with seams, with all their attributes. All that
# was measured goes to build/peers/results.tsv and assets.tsv.

PEERS_PACKAGES = g++ libdraco-dev python3
PEERS_OBJECTS = build/peers/peers.o build/bench/draco.o build/bench/mesh.o $(MESH_FILE:examples/%.c=build/bench/%.o)

.PHONY: peers deps-peers
peers: deps-peers deps-assets build/meshes build/assets/venv/complete ## compares bytes with Draco's, by class; MESHES=DIR adds meshes
	@$(MAKE) --no-print-directory -s build/peers/peers build/peers/assets
	@$(call KEEP,(tests/measure/peers/peers.sh $(MESHES); status=$$?; echo; tests/measure/peers/assets.sh $(ASSETS) && exit $$status))

deps-peers:
	$(call install,$(PEERS_PACKAGES))

build/peers/peers: $(PEERS_OBJECTS)
	$(CXX) $(LDFLAGS) $^ -ldraco -lm -o $@

build/peers/assets: build/peers/assets.o $(MESH_FILE:examples/%.c=build/bench/%.o)
	$(CXX) $(LDFLAGS) $^ -ldraco -lm -o $@

build/peers/%.o: tests/measure/peers/%.cpp tests/measure/peers/files.hpp tests/measure/bench/bench.hpp tests/measure/bench/ours.hpp $(HEADER)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iinclude -Iexamples -O2 -c $< -o $@

# -- Quality -------------------------------------------------------------------------------------------------------
#
# tests/measure/quality: distance from the exact mesh against bytes, for each goal, Draco and meshoptimizer's simplifier, of
# meshes of the package and those in MESHES=DIR. Curves, contact sheets and targets go to build/quality.

QUALITY_PACKAGES = g++ libdraco-dev libmeshoptimizer-dev python3-venv libegl1
QUALITY_MESHES = $(patsubst %,build/meshes/%.off,fandisk bunny00 bear elephant lion)
QUALITY_MORE = $(filter-out $(addprefix %/,$(notdir $(QUALITY_MESHES))),$(wildcard $(MESHES)/*.off))

.PHONY: quality deps-quality
quality: deps-quality build/meshes build/cqm ## draws rate-distortion curves and contact sheets; MESHES=DIR adds meshes
	@$(MAKE) --no-print-directory -s build/quality/peers build/quality/lods build/quality/venv/complete
	@build/quality/venv/bin/python tests/measure/quality/surface_test.py
	@$(call KEEP,build/quality/venv/bin/python tests/measure/quality/regular.py build/cqm build/quality \
	    $(sort $(wildcard build/meshes/*.off) $(QUALITY_MORE)) && \
	build/quality/venv/bin/python tests/measure/quality/quality.py build/cqm build/quality/peers build/quality/lods \
	    build/quality $(QUALITY_MESHES) $(QUALITY_MORE))

deps-quality:
	$(call install,$(QUALITY_PACKAGES))

build/quality/peers: tests/measure/quality/peers.cpp $(MESH_FILE:examples/%.c=build/bench/%.o)
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Wall -Wextra $(CPPFLAGS) -Iexamples -O2 $^ $(LDFLAGS) -ldraco -lmeshoptimizer -lm -o $@

build/quality/lods: tests/measure/quality/lods.c $(MESH_FILE:examples/%.c=build/bench/%.o) $(HEADER)
	@mkdir -p $(@D)
	$(COMPILE) -Iexamples $(filter-out $(HEADER),$^) $(LDLIBS) -lm -o $@

# -- Published files -----------------------------------------------------------------------------------------------
#
# Files of other projects through cqm, and how trimesh reads them before and after: OBJ, PLY, STL and OFF of Debian's package
# assimp-testmodels, and of pybullet_data, which comes with the package pybullet. 1250 files, some minutes.
ASSETS = assimp-testmodels=/usr/share/assimp/models \
    pybullet_data=$$(echo build/assets/venv/lib/python3*/site-packages/pybullet_data)

.PHONY: assets deps-assets
assets: deps-assets build/cqm build/assets/venv/complete ## encodes 1250 published files, compares with trimesh's reading
	@$(call KEEP,build/assets/venv/bin/python -W ignore tests/measure/assets/assets.py build/cqm build/assets/files $(ASSETS))

deps-assets:
	$(call install,python3 python3-venv assimp-testmodels)
