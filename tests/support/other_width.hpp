// The library a second time in one program, with the other index width, in namespace other_width. Include conquest.h
// before, and link both widths. Functions of both widths differ in the names that macros give them (CQI_SYMBOL), so
// that `other_width::` is for types, and for functions of codec.h, which call the right ones.
#ifndef CQ_TESTS_OTHER_WIDTH_HPP
#define CQ_TESTS_OTHER_WIDTH_HPP

#include <string.h>

#pragma push_macro("CQ_INDEX_BITS")
#pragma push_macro("CQI_SYMBOL")
#pragma push_macro("CQ_NONE")
#pragma push_macro("CQ_MAX_BITS")
#if CQ_INDEX_BITS == 32
#undef CQ_INDEX_BITS
#define CQ_INDEX_BITS 16
#else
#undef CQ_INDEX_BITS
#define CQ_INDEX_BITS 32
#endif
#undef CQI_SYMBOL
#undef CQ_NONE
#undef CQ_MAX_BITS
#undef CQ_CONQUEST_H

namespace other_width {
#include "conquest.h"
#undef CQ_TESTS_CODEC_H
#include "codec.h"
}  // namespace other_width

#pragma pop_macro("CQ_MAX_BITS")
#pragma pop_macro("CQ_NONE")
#pragma pop_macro("CQI_SYMBOL")
#pragma pop_macro("CQ_INDEX_BITS")

#endif
