// SPDX-License-Identifier: MIT
// Cases of stochastic filtering in the exported suite: which texels of which mip a lookup reads, with which
// weights, from coordinates, derivatives, sizes and random numbers. Decisions of
// shaders/openntc/StochasticFiltering.h are made in integers, so that every bit is compared; only a
// Gaussian's weights are the device's.
#pragma once

#include "openntc/core/Expected.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::tool {
class JsonWriter;
}

namespace openntc::conformance {

inline constexpr int kMaxFilterLookups = 1024;            ///< of a request
inline constexpr std::size_t kMaxFilterTaps = 8 * 8 * 32; ///< of a lookup

/// Which texels of a filter are asked for: one, drawn by the random numbers; one or two, drawn for the
/// positive and the negative weights; all.
enum class FilterWay : std::uint8_t { One, Pair, All };

/// How a texture is filtered, and its sizes: NtcStfSampler and NtcStfExtent, whose numbers these are.
struct FilterRequest {
    FilterWay way = FilterWay::One;
    int kernel = 0, mips = 0, wrapX = 0, wrapY = 0;
    float sigma = 0.6f; ///< of a Gaussian, 0.5 … 1.35
    int radius = 2;     ///< of a Gaussian, 2 … 4
    int maxAnisotropy = 1;
    int lodBias = 0;
    int width = 1, height = 1, levels = 1;

    bool IsGaussian() const;
    bool IsValid() const;
};

struct FilterLookup {
    std::array<float, 2> uv{}, ddx{}, ddy{};
    std::array<std::uint32_t, 4> random{}; ///< 16 bits each
};

/// A texel and its factor. Outside, where the border's colour takes its place, its position is (-1, -1). Of a
/// pair without a second texel the second is all 0.
struct FilterTap {
    int x = 0, y = 0, mip = 0;
    float scale = 0;
    bool isBorder = false;
};

/// Of each lookup.
using FilterTaps = std::vector<std::vector<FilterTap>>;

/// One case of suite.json.
struct FilterSuiteCase {
    std::string name;
    std::string lookups; ///< file name of the lookups and what they give
    FilterRequest request;
    bool mustPass = false;
    std::string about;
};

/// The list `filtering` of suite.json; empty where there is none. Errors: Status::FileUnrecognized, naming
/// the member; file names that leave the folder are refused.
Expected<std::vector<FilterSuiteCase>> ReadFilterCases(std::span<const std::byte> json);
/// Writes the member.
void WriteFilterCases(tool::JsonWriter& json, std::span<const FilterSuiteCase> cases);

/// The cases of this version, and the lookups of one; the same on every machine.
std::vector<FilterSuiteCase> ListFilterSuite();
std::vector<FilterLookup> MakeFilterLookups(const FilterSuiteCase& filterCase);

/// The file of a case: "NTCF", u32 version 1, u32 number of lookups; of each six binary32 numbers (uv, ddx,
/// ddy), four u32 random numbers, u32 number of taps, and taps of 16 bytes: i32 x, y, mip (-1 - mip outside),
/// binary32 factor. Little-endian.
struct FilterFile {
    std::vector<FilterLookup> lookups;
    FilterTaps taps;
};
std::vector<std::byte> WriteFilterFile(const FilterFile& file);
/// Errors: Status::FileUnrecognized; every byte must be accounted for.
Expected<FilterFile> ReadFilterFile(std::span<const std::byte> bytes);

/// Words of the protocol: `one`, `catmull_rom`, `mirror`, …; -1 where there is none.
const char* GetFilterWayWord(FilterWay way);
const char* GetKernelWord(int kernel);
const char* GetMipsWord(int mips);
const char* GetWrapWord(int wrap);
int FindFilterWay(std::string_view word);
int FindKernel(std::string_view word);
int FindMips(std::string_view word);
int FindWrap(std::string_view word);

/// What integrations of filtering do wrong.
enum class FilterMistake : std::uint8_t {
    None,
    HalfTexel,
    NearestOfKernel,
    MissingWrap,
    MirrorAsRepeat,
    BorderAsClamp,
    OneWrap,
    SwappedAxes,
    RoundedMip,
    FlooredMip,
    ExtraMip,
    SquareDerivatives,
    TransposedDerivatives,
    DoubledLevel,
    BiasIgnored,
    BiasNegated,
    Isotropic,
    MinorAxis,
    ReusedForRow,
    ReusedForMip,
    ReusedForTap,
    EightBitRandom,
    InvertedRandom,
    SignDropped,
    SecondDropped,
    SmoothKernel,
    EightBitWeights,
    SwappedMipWeights,
};

struct FilterMistakeInfo {
    FilterMistake mistake;
    const char* name;     ///< of wrong_decoder
    const char* cause;    ///< what the filter does, and should do
    const char* caseName; ///< the exported case that is meant for it
};

/// Every mistake but None.
std::span<const FilterMistakeInfo> ListFilterMistakes();

/// What the header gives, compiled as C++, or an integration of it with a mistake.
FilterTaps RunFilter(const FilterRequest& request, std::span<const FilterLookup> lookups,
                     FilterMistake mistake = FilterMistake::None);

/// Where taps differ, whatever their order is.
struct FilterDifference {
    std::size_t different = 0; ///< lookups
    std::string first;         ///< "lookup 3: texel (4, 5) of mip 1 times 1: expected …"
};
FilterDifference CompareFilterTaps(const FilterRequest& request, const FilterTaps& taps,
                                   const FilterTaps& expected);

} // namespace openntc::conformance
