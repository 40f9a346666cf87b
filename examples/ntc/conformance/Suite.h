// SPDX-License-Identifier: MIT
// The project's own conformance vectors: what `ntc conformance export` writes and `run` reads. docs/conformance.md
// documents the files: suite.json, mustpass.txt, NAME.ntc, NAME.values.
#pragma once

#include "Subject.h"

#include "openntc/core/Expected.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::conformance {

/// Version 2 added cases with intervals; version 3 slices, texels outside the image, and whole mips of which only some
/// texels are compared; version 4 slices of several mips; version 5 blocks (BlockSuite.h); version 6 textures and filtering (TextureSuite.h,
/// FilterSuite.h); version 7 sets of generations 2 and 3. All are read.
inline constexpr int kSuiteVersion = 7;
inline constexpr const char* kSuiteFile = "suite.json";

/// One case: some texels of one set, decoded in one way.
struct SuiteCase {
    std::string name;
    std::string set;    ///< file name of the texture set
    std::string values; ///< file name of the expected values
    DecodeMath math = DecodeMath::Int8;
    bool linear = false;
    bool wholeMip = false; ///< the decoder is asked for a whole mip; the values are texels of it
    std::optional<Rect>
        slice;         ///< the decoder is asked for this rectangle of a mip; the values are texels of it
    int sliceMip = -1; ///< of slices of several mips: the first, in texels of which the rectangle is; else -1
    int sliceMips = 1; ///< how many mips; the values are texels of what the slice holds of each
    bool outside = false; ///< texels may lie outside the mip
    bool interval =
        false; ///< a range is expected of every output: FP8, which hardware adds up in its own way
    bool mustPass = false; ///< a decoder that has the maths mode at all must pass
    std::string about;     ///< what it covers, in a sentence

    RequestKind GetKind() const {
        return wholeMip ? RequestKind::WholeMip : slice ? RequestKind::Slice : RequestKind::Texels;
    }
    /// The mip that the rectangle counts texels of; `valueMip`: of any of the values.
    int GetSliceMip(int valueMip) const { return sliceMip < 0 ? valueMip : sliceMip; }
    ModelRequest MakeRequest(const tool::Texel& texel) const {
        return {math,
                linear,
                texel.mip,
                texel.x,
                texel.y,
                GetKind(),
                slice.value_or(Rect{}),
                GetSliceMip(texel.mip),
                sliceMips};
    }
};

/// A texel and its 16 outputs.
struct ValueRecord {
    tool::Texel texel;
    Outputs outputs{};
    Outputs low{}, high{}; ///< of cases with intervals
};

/// Parses suite.json. Fails with Status::FileUnrecognized, naming the key; file names that leave the folder are refused.
Expected<std::vector<SuiteCase>> ReadSuite(std::span<const std::byte> json);
/// The optional parts of a suite.
struct SuiteParts {
    std::vector<BlockSuiteCase> blocks;
    std::vector<TextureSuiteCase> textures;
    std::vector<FilterSuiteCase> filtering;
};
/// Without indentation, which was an eighth of it.
std::string WriteSuite(std::span<const SuiteCase> cases, const SuiteParts& parts);

/// The .values format: "NTCV", u32 version (1; with intervals 2), u32 maths mode (NTC_MATH), u32 1 if linear, u32 count; a
/// record is i32 mip, x, y and 16 binary32 outputs, in version 2 followed by the 16 least and the 16 greatest ones.
/// Little-endian. The record count must account for every byte.
Expected<std::vector<ValueRecord>> ReadValues(std::span<const std::byte> file, const SuiteCase& suiteCase);
std::vector<std::byte> WriteValues(std::span<const ValueRecord> records, const SuiteCase& suiteCase);

/// The suite as made by this version: sets by file name, cases, and the texels of each case.
struct Suite {
    struct Set {
        std::string file;
        std::vector<std::byte> bytes;
    };
    std::vector<Set> sets;
    std::vector<SuiteCase> cases;
    std::vector<std::vector<tool::Texel>> texels; ///< per case
};

/// The same on every machine.
Suite MakeSuite();

struct ExportedFiles {
    std::size_t cases = 0;
    std::vector<std::filesystem::path> files; ///< all that were written, `folder` in front
};

/// Writes all files of the suite with the values of the reference decoder.
ExportedFiles ExportSuite(const std::filesystem::path& folder);

} // namespace openntc::conformance
