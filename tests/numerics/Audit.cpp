// SPDX-License-Identifier: MIT
// Which case or test covers each hard case that the requirements and the format specification name.
#include "HardCases.h"

namespace numerics {

namespace {

constexpr AuditRow kAudit[] = {
    // Geometry
    {"texels aligned with latents (corner slots are discontinuous)", "texels-on-latents", ""},
    {"near-integer positions, u * L against x * (L / W)", "texels-on-latents",
     "unit/decode/reference_coordinate_test.cpp"},
    {"clamped taps at edges; weights not altered by clamping", "clamped-taps",
     "unit/decode/reference_coordinate_test.cpp"},
    {"1 x N, N x 1, 1 x 1, 94 x 94, 257 x 33, 4096 x 2", "slivers", "unit/decode/fast_reference_test.cpp"},
    {"grids of one latent a side: both taps equal", "slivers, tail-mips", ""},
    {"odd sizes: grids that do not divide the image", "slivers, random-sets",
     "unit/texture_set/latent_shape_test.cpp"},
    {"derived gridSizeScale outside 2 to 8 (small and sliver images)", "slivers",
     "unit/texture_set/loading_test.cpp"},
    {"tail mips; level of detail beyond 1 clamps at 127; degenerate waves", "tail-mips",
     "unit/decode/fast_reference_test.cpp"},
    {"positionLod and positionScale that no encoder writes, not finite ones", "odd-positions",
     "unit/decode/reference_source_test.cpp, unit/decode/modes_test.cpp"},
    {"texel coordinates near 16384", "large-coordinates", "unit/decode/reference_coordinate_test.cpp"},
    {"texels outside the image, negative ones, mips out of range", "",
     "unit/decode/reference_source_test.cpp, unit/decode/fast_reference_test.cpp, shader/decode_test.cpp, "
     "conformance/suite/suite_test.cpp"},
    {"more than two latent images; mips whose images are in no order; grids of any size", "",
     "conformance/suite/suite_test.cpp"},
    {"bilinear weights that sum to 253 to 256, corners floored", "bilinear-weight-sums", ""},
    {"slots beyond the set's features, and the last two inputs, are zero", "random-sets",
     "conformance/suite/suite_test.cpp"},
    // Slices
    {"slices: pixels of half bytes in rows of odd length", "slices-half-bytes",
     "unit/decode/slices_test.cpp, conformance/suite/suite_test.cpp"},
    {"slices: sizes of mips that do not halve", "slices-sizes-that-do-not-halve",
     "unit/decode/slices_test.cpp, unit/inference/slices_test.cpp"},
    {"slices: one rounding per operation; the three cases of the specification", "slices-rounded-edges",
     "unit/inference/slices_test.cpp"},
    {"slices: any texel of any slice against the whole set", "",
     "unit/decode/slices_test.cpp, shader/slices/slices_test.cpp"},
    {"slices that LibNTC cuts, and those that it refuses by mistake", "", "conformance/slices_test.cpp"},
    // Tiles
    {"tiles: levels that do not halve, levels that do not nest", "tiles-levels-that-do-not-halve",
     "unit/streaming/tile_random_test.cpp, unit/streaming/tile_manager_test.cpp"},
    {"tiles: 1 x N, N x 1, 1 x 1", "tiles-slivers", "unit/streaming/tile_random_test.cpp"},
    {"tiles: all tail, two tiles of it, none", "tiles-all-tail", "unit/streaming/trace_test.cpp"},
    {"tiles: no heap, heaps of one tile, fewer slots than tails", "tiles-short-of-slots",
     "unit/streaming/tile_manager_test.cpp"},
    {"tiles: followers of another size", "tiles-followers", "unit/streaming/trace_test.cpp"},
    // Block compression
    {"blocks: one colour lossless or the nearest there is, at every level", "blocks-one-colour",
     "unit/bc/bc1_test.cpp, unit/bc/bc4_test.cpp, unit/bc/bc6_test.cpp, unit/bc/bc7_test.cpp"},
    {"blocks: two colours at the ends of the palette", "blocks-two-colours", "unit/bc/bc4_test.cpp"},
    {"blocks: gradients; no level worse than the one below", "blocks-ramps",
     "unit/bc/bc1_test.cpp, unit/bc/bc7_test.cpp, numerics/blocks/oracle_test.cpp"},
    {"blocks: opaque alpha stays 255, alpha 0 stays 0", "blocks-alpha-ends",
     "unit/bc/bc1_test.cpp, unit/bc/bc7_test.cpp"},
    {"blocks: BC1's alpha threshold", "blocks-alpha-threshold", "unit/bc/bc1_test.cpp"},
    {"blocks: NaN, +-Inf, negatives and -0 into BC6H; SF16", "blocks-half-numbers", "unit/bc/bc6_test.cpp"},
    {"blocks: two-channel normals with negative X; -128", "blocks-signed", "unit/bc/bc4_test.cpp"},
    {"blocks: 1 x 1, mips not multiples of 4, borders repeat the edge", "blocks-edges",
     "unit/bc/encoder_test.cpp, unit/bc/bc6_test.cpp, shader/bc/compress_test.cpp"},
    {"blocks: rectangles at odd block positions", "",
     "unit/bc/encoder_test.cpp, shader/bc/compress_test.cpp"},
    {"blocks: reserved and degenerate codes; every mode and partition against samplers",
     "blocks-degenerate-codes", "unit/bc/decoder_test.cpp, shader/bc/decoder_test.cpp"},
    {"blocks: the same from every compiler, vector width, number of threads and GPU", "blocks-determinism",
     "unit/bc/encoder_test.cpp, shader/bc/compress_test.cpp"},
    // Latents and weights
    {"numbers of features, bit widths and networks, every pair of them", "",
     "conformance/suite/suite_test.cpp"},
    {"every code of every quantisation, 8-bit codes 254 and 255; wrap, not saturate", "latent-codes",
     "unit/decode/fast_reference_test.cpp"},
    {"last word of a view that is not padded; sizes beyond 32 bits", "",
     "unit/decode/reference_source_test.cpp, unit/inference/inference_data_test.cpp, "
     "unit/texture_set/loading_test.cpp"},
    {"network weights of +-127 and -128", "extreme-weights", "unit/decode/reference_network_test.cpp"},
    {"accumulators and biases at their bounds: wrap, 24 bits of binary32", "accumulators",
     "unit/decode/fast_reference_test.cpp"},
    {"scales zero, huge, negative", "scales", ""},
    {"scales denormal", "subnormal-scales", ""},
    {"scales NaN and infinite, biases not finite, E4M3 NaN weights", "scales-not-finite",
     "unit/texture_set/loading_test.cpp"},
    {"legacy binary32 biases; scales of one without a view", "",
     "unit/texture_set/legacy_test.cpp, conformance/suite/suite_test.cpp"},
    {"views and chunks in any order, with gaps; absent members", "", "conformance/suite/suite_test.cpp"},
    {"what a decoder keeps of the set before", "", "conformance/suite/mistakes_test.cpp"},
    {"networks and features that do not fit, mixed networks", "", "unit/texture_set/loading_test.cpp"},
    // Activation
    {"activation ties and saturation, all halves; specification's CRCs and check values", "every-half",
     "unit/decode/reference_network_test.cpp"},
    {"every requantisation boundary in binary32", "requantisation-boundaries", ""},
    {"specification's vectors V1 and V2, whole images", "",
     "unit/decode/reference_specification_test.cpp, unit/decode/fast_specification_test.cpp, "
     "shader/decode_test.cpp"},
    {"rounding direction", "rounding-direction", "shader/modes_float_controls_test.cpp"},
    {"contraction", "contraction", "shader/modes_float_controls_test.cpp"},
    {"denormal flushing", "denormal-flushing, subnormal-scales", "shader/modes_float_controls_test.cpp"},
    {"which steps cannot differ", "rounding-direction, contraction, denormal-flushing", ""},
    {"binary32 to binary16: ties, overflow, double rounding", "half-conversion",
     "unit/core/float_codecs_test.cpp"},
    {"half epilogue: overflow, -infinity x 0", "infinite-activations", ""},
    {"half outputs have 11 bits", "every-half", "unit/decode/reference_specification_test.cpp"},
    // Formats
    {"E4M3: all 256 x 256 products, saturation, NaN, subnormals", "e4m3-products, fp8-network",
     "unit/core/float_codecs_test.cpp"},
    {"FP8 accumulation order by intervals; median, 99th percentile and maximum on real sets",
     "fp8-accumulation-order", "unit/decode/fp8_interval_test.cpp, conformance/modes_test.cpp"},
    {"FP8 on hardware: results recorded on a GPU, intervals in the conformance suite",
     "fp8-accumulation-order", "unit/decode/fp8_interval_test.cpp, conformance/suite/suite_test.cpp"},
    {"binary16 and binary32 networks: order of sums", "fp16-network, fp32-network",
     "unit/decode/modes_test.cpp"},
    // Colour
    {"sRGB knee +-1 ULP", "srgb-knee", "unit/decode/reference_color_test.cpp"},
    {"HLG negatives", "hlg-negatives", "unit/decode/reference_color_test.cpp"},
    {"65504, 12.0, NaN, overflow of exp", "large-light", "shader/functions_test.cpp"},
    {"colour curves monotone, continuous, round trip", "colour-curves", ""},
    {"colour space of each channel, not of a texture's first", "", "shader/effects/effects_test.cpp"},
    {"constant channels through shuffling, values beyond its range", "",
     "unit/inference/inference_data_test.cpp"},
    // Encoder
    {"encoder: constant channels, black, white, one texel", "encoder-flat",
     "unit/encode/hard_cases_test.cpp"},
    {"encoder: noise", "encoder-noise", "unit/encode/hard_cases_test.cpp"},
    {"encoder: huge HDR range, negative values", "encoder-huge-range", "unit/encode/hard_cases_test.cpp"},
    {"encoder: masks", "encoder-masks", "unit/encode/hard_cases_test.cpp"},
    {"encoder: divergence of training, NaN guard and recovery", "encoder-divergence",
     "unit/encode/fp8_test.cpp"},
    {"encoder: decoded PSNR is the one that training reports", "encoder-noise, encoder-huge-range",
     "unit/encode/round_trip_test.cpp"},
    // Determinism
    {"same bytes across runs, threads, gcc and clang, -O levels, SIMD targets", "determinism",
     "unit/decode/modes_test.cpp, unit/decode/fast_interface_test.cpp"},
    {"same bytes from the encoder across threads, and of its portable kernel across compilers", "",
     "unit/encode/round_trip_test.cpp, unit/encode/hard_cases_test.cpp"},
    {"every decoder against an independent double-precision model", "random-sets",
     "unit/decode/modes_test.cpp, conformance/suite/suite_test.cpp"},
};

} // namespace

std::span<const AuditRow> ListAudit() {
    return kAudit;
}

} // namespace numerics
