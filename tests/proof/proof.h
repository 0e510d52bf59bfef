/* What all harnesses share: the real header, with its assertions as proof obligations, and values that the verifier
 * chooses. A harness is a function `void claim_NAME(void)`; README.md lists them with their bounds.
 *
 * ASSUME narrows what the verifier may choose: every ASSUME of a harness is a precondition that the table names.
 * PROVE must hold for all that is left. REACHED must be reachable: a proof whose preconditions contradict each other
 * proves nothing, so the driver asks for a run that gets there. */
#ifndef PROOF_H
#define PROOF_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define ASSUME(condition) __CPROVER_assume(condition)
#ifdef PROOF_REACH
#define PROVE(condition) ((void)(condition))
#define REACHED() __CPROVER_assert(0, "reached")
#else
#define PROVE(condition) __CPROVER_assert(condition, #condition)
#define REACHED() ((void)0)
#ifndef CQ_ASSERT
#define CQ_ASSERT(condition) __CPROVER_assert(condition, "CQ_ASSERT(" #condition ")")
#endif
#endif
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

int nondet_int(void);
uint8_t nondet_u8(void);
uint16_t nondet_u16(void);
uint32_t nondet_u32(void);
uint64_t nondet_u64(void);
size_t nondet_size(void);

static int any_between(int low, int high)
{
    int x = nondet_int();
    ASSUME(x >= low && x <= high);
    return x;
}

static cq_index any_index(void) { return (cq_index)nondet_u32(); }

/* In place of cqi_code_raw: any number of so many bits. */
uint32_t stub_code_raw(cq_decoder *of, uint32_t value, int bits)
{
    const uint32_t x = nondet_u32();
    (void)of, (void)value;
    PROVE(bits >= 0 && bits <= 32);
    ASSUME(bits == 32 || x >> bits == 0);
    return x;
}

/* Bytes of any contents, at most `limit`; a block of exactly that size, so that a read behind it is found. */
static uint8_t *any_bytes(size_t size)
{
    uint8_t *bytes = (uint8_t *)malloc(size);
    ASSUME(bytes != NULL);
    return bytes;
}

#endif
