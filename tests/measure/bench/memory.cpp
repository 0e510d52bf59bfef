// memory.cpp - counts what all libraries of the process allocate. SPDX-License-Identifier: MIT
//
// The functions of malloc.h are replaced by ones that count and pass on to those of glibc; operator new calls them too.
#include "bench.hpp"

#include <algorithm>
#include <cerrno>
#include <malloc.h>

extern "C" {
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);
void __libc_free(void *);
}

namespace {

size_t now, peak;

void *taken(void *block)
{
    now += block ? malloc_usable_size(block) : 0;
    peak = std::max(peak, now);
    return block;
}

void given_back(void *block) { now -= block ? malloc_usable_size(block) : 0; }

} // namespace

size_t memory_now() { return now; }
size_t memory_peak() { return peak; }
void memory_reset_peak() { peak = now; }

extern "C" {

void *malloc(size_t size) { return taken(__libc_malloc(size)); }
void *calloc(size_t count, size_t size) { return taken(__libc_calloc(count, size)); }
void *memalign(size_t alignment, size_t size) { return taken(__libc_memalign(alignment, size)); }
void *aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }

int posix_memalign(void **block, size_t alignment, size_t size)
{
    *block = memalign(alignment, size);
    return *block ? 0 : ENOMEM;
}

void *realloc(void *block, size_t size)
{
    given_back(block);
    return taken(__libc_realloc(block, size));
}

void free(void *block)
{
    given_back(block);
    __libc_free(block);
}
}
