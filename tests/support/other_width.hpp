// The library a second time in one program, with the other index width, in namespace other_width. Its functions have C
// linkage and get another prefix so that both copies can live side by side. Include conquest.h, with its
// implementation, before.
#ifndef CQ_TESTS_OTHER_WIDTH_HPP
#define CQ_TESTS_OTHER_WIDTH_HPP

#include <string.h>

#pragma push_macro("CQ_INDEX_BITS")
#pragma push_macro("CQ_API")
#pragma push_macro("CQ_NONE")
#pragma push_macro("CQ_MAX_BITS")
#if CQ_INDEX_BITS == 32
#undef CQ_INDEX_BITS
#define CQ_INDEX_BITS 16
#else
#undef CQ_INDEX_BITS
#define CQ_INDEX_BITS 32
#endif
#undef CQ_API
#define CQ_API static inline
#undef CQ_NONE
#undef CQ_MAX_BITS
#undef CQ_CONQUEST_H
#undef CONQUEST_IMPLEMENTATION_DONE
#undef CONQUEST_IMPLEMENTATION
#define CONQUEST_IMPLEMENTATION

#define cq_result_string ow_result_string
#define cq_mesh_bytes ow_mesh_bytes
#define cq_mesh_build ow_mesh_build
#define cq_mesh_check ow_mesh_check
#define cq_mesh_can_collapse ow_mesh_can_collapse
#define cq_mesh_collapse ow_mesh_collapse
#define cq_mesh_split ow_mesh_split
#define cq_mesh_changes ow_mesh_changes
#define cq_mesh_triangles ow_mesh_triangles
#define cq_next ow_next
#define cq_prev ow_prev
#define cq_target ow_target
#define cq_clockwise ow_clockwise
#define cq_counterclockwise ow_counterclockwise
#define cq_is_virtual ow_is_virtual
#define cq_range_encoder_init ow_range_encoder_init
#define cq_range_decoder_init ow_range_decoder_init
#define cq_encode_bit ow_encode_bit
#define cq_decode_bit ow_decode_bit
#define cq_encode_freq ow_encode_freq
#define cq_decode_slot ow_decode_slot
#define cq_decode_freq ow_decode_freq
#define cq_encode_raw ow_encode_raw
#define cq_decode_raw ow_decode_raw
#define cq_range_encoder_finish ow_range_encoder_finish
#define cq_peek ow_peek
#define cq_decoder_bytes ow_decoder_bytes
#define cq_decoder_init ow_decoder_init
#define cq_decode ow_decode
#define cq_encoder_bytes ow_encoder_bytes
#define cq_encode ow_encode
#define cq_fit_grid ow_fit_grid
#define cq_align_grid ow_align_grid
#define cq_quantise ow_quantise
#define cq_reconstruct ow_reconstruct
#define cq_quantise_normals ow_quantise_normals
#define cq_reconstruct_normals ow_reconstruct_normals
#define cqi_plan ow_plan   /* `struct cqi_plan *` would find the one outside the namespace */

namespace other_width {
#include "conquest.h"
#undef CQ_TESTS_CODEC_H
#include "codec.h"
}  // namespace other_width

#undef cq_result_string
#undef cq_mesh_bytes
#undef cq_mesh_build
#undef cq_mesh_check
#undef cq_mesh_can_collapse
#undef cq_mesh_collapse
#undef cq_mesh_split
#undef cq_mesh_changes
#undef cq_mesh_triangles
#undef cq_next
#undef cq_prev
#undef cq_target
#undef cq_clockwise
#undef cq_counterclockwise
#undef cq_is_virtual
#undef cq_range_encoder_init
#undef cq_range_decoder_init
#undef cq_encode_bit
#undef cq_decode_bit
#undef cq_encode_freq
#undef cq_decode_slot
#undef cq_decode_freq
#undef cq_encode_raw
#undef cq_decode_raw
#undef cq_range_encoder_finish
#undef cq_peek
#undef cq_decoder_bytes
#undef cq_decoder_init
#undef cq_decode
#undef cq_encoder_bytes
#undef cq_encode
#undef cq_fit_grid
#undef cq_align_grid
#undef cq_quantise
#undef cq_reconstruct
#undef cq_quantise_normals
#undef cq_reconstruct_normals
#undef cqi_plan

#pragma pop_macro("CQ_MAX_BITS")
#pragma pop_macro("CQ_NONE")
#pragma pop_macro("CQ_API")
#pragma pop_macro("CQ_INDEX_BITS")

#endif
