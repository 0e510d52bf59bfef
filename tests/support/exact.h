/* Memory of exactly the size asked for. Under AddressSanitizer every byte beyond it is an error at once; without it, a
 * guard on both sides is compared when the block is freed, so that overruns are also seen on emulated targets. Fresh
 * memory holds 0xa5: nothing may rely on zeros. */
#ifndef CQ_TESTS_EXACT_H
#define CQ_TESTS_EXACT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define EXACT_SANITIZER 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define EXACT_SANITIZER 1
#endif

enum { EXACT_GUARD = 64 };  /* bytes on each side; the first holds the size. A multiple of every alignment in use */

static inline void *exact_alloc(size_t size)
{
#ifdef EXACT_SANITIZER
    void *block = malloc(size > 0 ? size : 1);
    if (block == NULL) abort();
    memset(block, 0xa5, size);
    return block;
#else
    unsigned char *block = (unsigned char *)malloc(size + 2 * EXACT_GUARD);
    if (block == NULL) abort();
    memset(block, 0x5a, EXACT_GUARD);
    memcpy(block, &size, sizeof size);
    memset(block + EXACT_GUARD, 0xa5, size);
    memset(block + EXACT_GUARD + size, 0x5a, EXACT_GUARD);
    return block + EXACT_GUARD;
#endif
}

/* A copy of `size` bytes in a block of their own; data may be NULL if size is 0. */
static inline void *exact_copy(const void *data, size_t size)
{
    void *block = exact_alloc(size);
    if (size > 0) memcpy(block, data, size);
    return block;
}

static inline void exact_free(void *memory)
{
#ifdef EXACT_SANITIZER
    free(memory);
#else
    unsigned char *block;
    size_t size, i;
    if (memory == NULL) return;
    block = (unsigned char *)memory - EXACT_GUARD;
    memcpy(&size, block, sizeof size);
    for (i = 0; i < EXACT_GUARD; ++i) {
        int before = i < sizeof size || block[i] == 0x5a;
        int after = block[EXACT_GUARD + size + i] == 0x5a;
        if (!before || !after) {
            printf("memory of %lu bytes was overrun\n", (unsigned long)size);
            fflush(stdout);
            abort();
        }
    }
    free(block);
#endif
}

#endif
