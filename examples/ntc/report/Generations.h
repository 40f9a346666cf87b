// SPDX-License-Identifier: MIT
// Generations of files beside each other: sets of generation 2, and how times compare.
#pragma once

#include "TextureSet.h"
#include "report/Report.h"

#include <cstddef>
#include <string>
#include <vector>

namespace openntc::report {

/// The axis whose cases are compared with generation 1.
inline constexpr const char* kGenerationAxis = "generation";

/// The file of a set of generation 3 as one of generation 2: latents as they are, networks filled up with outputs that nobody
/// reads. There is no encoder for generation 2, whose PSNR is therefore that of a network trained for other arithmetic.
/// Throws CommandError.
std::vector<std::byte> MakeGeneration2(tool::TextureSet& third);

/// Fills againstGeneration1 of the cases on the axis: repeat by repeat, since those were timed in turns.
void CompareGenerations(ReportRecord& report);

/// The generation of a network's name, 1 to 3.
int GetGenerationOfNetwork(const std::string& network);

/// Measured cases of a device on the axis by what they share (maths mode, bits per pixel, instruction set), then by
/// generation.
std::vector<const CaseRecord*> ListGenerations(const ReportRecord& report, const std::string& device);
/// "int8, 5 bpp, avx2": what cases of several generations share.
std::string DescribeShared(const CaseRecord& c);

} // namespace openntc::report
