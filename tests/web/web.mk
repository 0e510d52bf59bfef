# Tests of the package for npm and its page, in node and in a browser.

WEB_LOGS = web-module web-gltf web-browser web-viewer

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

# A controller that games show in the player's hand, the largest model with one texture of WEB_MODELS; a human with bones.
FIRST_PICTURE_PACKAGES = $(WEB_PACKAGES) zstd assimp-utils assimp-testmodels
FIRST_PICTURE_MODELS = ../models/node_modules/@webxr-input-profiles/assets/dist/profiles/htc-vive/none.glb \
    /usr/share/assimp/models/X/BCN_Epileptic.X

.PHONY: first-picture
first-picture: ## milliseconds until a mesh is seen and until it is exact, by ours and other codecs, and a plot
	$(call install,$(FIRST_PICTURE_PACKAGES))
	@$(MAKE) --no-print-directory -s $(WEB_TEST)/complete build/web/models/complete build/meshes
	@cp examples/web/viewer/codecs.js examples/web/viewer/off.js $(WEB_TEST)
	@$(call KEEP,(cd $(WEB_TEST) && node first-picture.js ../../meshes ../../first-picture $(FIRST_PICTURE_MODELS)))

.PHONY: readme-picture
readme-picture: ## draws README's picture of a mesh at 1, 5, 20, 100 % of its bytes
	$(call install,$(WEB_TEST_PACKAGES))
	@$(MAKE) --no-print-directory -s $(WEB_TEST)/complete $(SITE)/meshes/bunny00.cqm
	@cd $(WEB_TEST) && node strip.js ../site/meshes/bunny00.cqm ../../../examples/web/bunny.png ../../../README.md

.PHONY: web-test
web-test: ## tests the package in node, and it and the page in a browser; GLTF=DIR adds glTF files
	$(call install,$(WEB_TEST_PACKAGES))
	@$(MAKE) --no-print-directory run LOGS='$(WEB_LOGS:%=build/log/%.log)'

NODE_TEST = timeout 300 node --test --test-reporter=./reporter.js --test-concurrency=1

build/log/web-module.log: $(WEB_TEST)/complete build/cqm
build/log/web-browser.log build/log/web-gltf.log: $(WEB_TEST)/complete
build/log/web-viewer.log: $(WEB_TEST)/complete $(SITE)/complete README.md
build/log/web-%.log:
	$(call log,cd $(WEB_TEST) && $(NODE_TEST) $*.test.js)

# Files of others, there and back: the models of a package of npm.
WEB_MODELS = @webxr-input-profiles/assets@1.0.20

build/web/models/complete:
	@mkdir -p $(@D)
	echo '{ "private": true }' >$(@D)/package.json
	cd $(@D) && npm install --ignore-scripts --no-audit --no-fund --loglevel=error $(WEB_MODELS)
	@touch $@

build/log/web-models.log: $(WEB_TEST)/complete build/web/models/complete
	$(call log,cd $(WEB_TEST) && GLTF=build/web/models $(NODE_TEST:300=900) gltf.test.js)
