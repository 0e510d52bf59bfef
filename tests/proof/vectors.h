/* Vectors of the verifier's choice, for the claims about predictions and what is coded by them. */
#ifndef PROOF_VECTORS_H
#define PROOF_VECTORS_H

#include "proof.h"

/* Any number of so many bits and a sign; as the verifier sees best which bits are equal. */
static int32_t any_signed(int bits) { return (int32_t)(nondet_u32() << (31 - bits)) >> (31 - bits); }

static int fits(int64_t x, int bits) { return x >= -((int64_t)1 << bits) && x < (int64_t)1 << bits; }

static int within(int64_t x, int64_t most) { return x >= -most && x <= most; }

static cqi_vector any_vector(int bits)
{
    cqi_vector v;
    v.x = any_signed(bits);
    v.y = any_signed(bits);
    v.z = any_signed(bits);
    return v;
}

static int vector_fits(cqi_vector v, int bits) { return fits(v.x, bits) && fits(v.y, bits) && fits(v.z, bits); }

static int near_zero(cqi_vector a, int32_t most)
{
    return within(a.x, most) && within(a.y, most) && within(a.z, most);
}

static cqi_vector any_near_zero(int32_t most)
{
    const cqi_vector a = any_vector(31);
    ASSUME(near_zero(a, most));
    return a;
}

static cq_value any_value(void) { return (cq_value)(nondet_u32() & 0xffffff); }

/* The linear prediction, 13 times features of 20 bits, and where the place is at most: what an encoder knows. */
#define MOST_LINEAR (13 << 20)
#define MOST_PLACE ((1 << 30) + CQI_FAR)

#endif
