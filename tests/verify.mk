# What takes too long for `make test`. Each target also runs alone; all end with `N passed, N failed`.

.PHONY: proof proof-bugs portability windows mutation coverage quotes

# `make test` compares what its own logs have, once they are there ($(FIRST)).
quotes: ## compares the numbers in README and SECURITY with what the commands that they name printed last
	@python3 tests/quotes/quotes.py

build/log/quotes.log: | build/printed/memory.txt $(FIRST)
	$(call log,python3 tests/quotes/quotes.py --gate)

build/log/verify/quotes.log: | build/printed/memory.txt $(FIRST)
	$(call log,python3 tests/quotes/quotes.py)

build/printed/memory.txt: build/memory build/memory-16
	@$(MAKE) --no-print-directory -s memory >/dev/null

proof: ## proves the claims of tests/proof/README.md with CBMC, which it fetches
	$(call install,$(PROOF_PACKAGES))
	@tests/proof/prove.sh

proof-bugs: ## plants bugs into the header and checks that the proofs fail
	$(call install,$(PROOF_PACKAGES))
	@tests/proof/prove.sh --bugs

build/log/proof.log: $(HEADER) $(wildcard tests/proof/*)
	$(call log,tests/proof/prove.sh)

build/log/proof-bugs.log: $(HEADER) $(wildcard tests/proof/*)
	$(call log,tests/proof/prove.sh --bugs)

portability: verify-deps ## compares streams and decoded meshes of all compilers, options and emulated machines
	@CLANG=$(CLANG) tests/portability/portability.sh all

PORTABILITY = $(HEADER) $(wildcard tests/portability/*)

build/log/portability.log: $(PORTABILITY)
	$(call log,CLANG=$(CLANG) tests/portability/portability.sh native)

build/log/portability-all.log: $(PORTABILITY)
	$(call log,CLANG=$(CLANG) tests/portability/portability.sh all)

windows: ## builds cqm for Windows and macOS, compares what it does under wine with what it does here
	$(call install,$(WINDOWS_PACKAGES))
	@$(MAKE) --no-print-directory build/log/windows.log build/log/vendor-windows.log

build/log/windows.log: tests/portability/windows.sh build/portability/venv/complete build/cqm $(EXAMPLES) \
    $(wildcard examples/*.c)
	$(call log,tests/portability/windows.sh)

MUTANTS = 300

mutation: deps build/meshes $(SUBDIVIDED) ## 300 small changes of the header: do the tests notice? MUTANTS=n for another number
	@CLANG=$(CLANG) tests/mutation/mutation.sh $(MUTANTS)

build/log/mutation.log: build/meshes $(SUBDIVIDED) $(HEADER) $(wildcard tests/mutation/*)
	$(call log,CLANG=$(CLANG) tests/mutation/mutation.sh $(MUTANTS))

coverage: verify-deps ## lines and branches of the header that the tests reach; fails below 100 % and 99 %
	@CLANG=$(CLANG) tests/coverage/coverage.sh

build/log/coverage.log: $(HEADER) $(wildcard tests/coverage/* tests/unit/* tests/property/*)
	$(call log,CLANG=$(CLANG) tests/coverage/coverage.sh)
