// SPDX-License-Identifier: MIT
// The comparisons of one conformance case.
#pragma once

#include "Comparison.h"
#include "Subject.h"
#include "Suite.h"
#include "VectorFiles.h"

#include <optional>
#include <string>
#include <vector>

namespace openntc::conformance {

/// Counts of what was compared and equal, and the first difference.
struct MetadataResult {
    int fields = 0;
    int fusedMips = 0;
    int streamRanges = 0;
    int constants = 0; ///< buffers of 624 bytes
    int weights = 0;
    std::string difference; ///< empty: everything equal
};

/// Compares sizes, latent shape, masks, fused mips, stream ranges, and for both kinds of weights the packed
/// constants of all mips and the size and CRC-32 of the weight buffer.
MetadataResult CheckMetadata(const Expectations& expectations, const TextureSetMetadata& metadata);

struct TexelResult {
    std::size_t exact = 0; ///< records compared
    double worstFloat = 0; ///< |decoded - recorded|, Int8 with float epilogue: 0 when all are the same bits
    double worstHalf = 0;
    double worstLinearRatio = 0; ///< in units of the derived bound: at most 1
    double worstLinear = 0;
    std::optional<double> psnr;      ///< decoded against source, declared channels, over the records; dB
    std::optional<double> psnrExact; ///< the same for the recorded exact values
    std::string difference;
};

/// Decodes every record three ways and compares. Records outside the image make a difference, not a crash.
/// The subject has opened the set. Throws what its member functions throw.
TexelResult CheckTexels(const std::vector<TexelRecord>& records, const TextureSetMetadata& metadata,
                        Subject& subject);

struct SuiteResult {
    std::size_t texels = 0;
    std::size_t differentTexels = 0;
    double worst = 0;         ///< largest |decoded - expected| that is not accepted
    double worstAccepted = 0; ///< within the bound of conversion to linear, or flushed
    std::string difference;   ///< the first; empty: everything accepted
    std::string cause;        ///< the one mistake that explains every value that was looked at
};

class Diagnosis;

/// Decodes the texels of one case of the project's own vectors; `model` is of its set, which the subject has opened.
/// Texels lie where the case says. Throws what the subject's member functions throw.
SuiteResult CheckSuiteCase(const SuiteCase& suiteCase, std::span<const ValueRecord> records,
                           const Model& model, Subject& subject, Diagnosis& diagnosis);

} // namespace openntc::conformance
