// SPDX-License-Identifier: MIT
// An independent decoder, written from the format specification in plain integers and double precision; it shares no
// arithmetic with the shaders and the fast decoder. Three uses: tests compare every decoder with it; it can make one
// deliberate mistake, which tests the conformance suite itself; and the suite asks which mistake would explain a
// decoder's wrong values.
#pragma once

#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace openntc::conformance {

/// What decoders get wrong. The table in ModelMistakes.cpp names and explains each.
enum class Mistake : std::uint8_t {
    None,
    TruncatedRequantisation,
    HalfAwayTies,
    WrappedTaps,
    SwappedCorners,
    MissingLodClamp,
    WrongBitOrder,
    Offset112,
    RoundedWeights,
    Contraction,
    SrgbTwice,
    UnusedSlotsNotZeroed,
    FP8SaturationMissing,
    FP8SubnormalsFlushed,
    TruncatedShift,
    SeparateLowResShifts,
    RoundedWaves,
    HalfTexelWaves,
    ReorderedCoordinates,
    FormulaLatentImage,
    UnroundedHalfOutputs,
    HalfInfinity,
    SaturatedLatents,
    NarrowAccumulator,
    HlgWithoutSign,
};

struct MistakeInfo {
    Mistake mistake;
    const char* name;     ///< of the switch, words joined by underscores
    const char* cause;    ///< what the decoder does, and should do
    const char* caseName; ///< the exported case that is meant for it
};

/// Every mistake but None.
std::span<const MistakeInfo> ListMistakes();

/// Decodes single texels of one set.
class Model {
public:
    /// `file` holds every byte of the file that `metadata` was loaded from. Both must outlive the model.
    Model(const TextureSetMetadata& metadata, std::span<const std::byte> file)
        : metadata_(metadata), file_(file) {}

    /// The 16 outputs of one texel. The set must have the weights that `math` reads, and the texel must lie within
    /// +-2^22. Conversion to linear is computed in double precision and rounded once.
    std::array<float, 16> Decode(DecodeMath math, bool linear, int mip, int x, int y,
                                 Mistake mistake = Mistake::None) const;

private:
    const TextureSetMetadata& metadata_;
    std::span<const std::byte> file_;
};

/// Number formats of the model, by scaling and rounding doubles.
double RoundToBinary32(double x);
double RoundToHalf(double x);    ///< ties to even; infinite from 65520 on
double RoundToE4M3(double x);    ///< saturates at 448
double WidenHalf(unsigned code); ///< bits of a finite half

/// Stored to linear in double precision. `colorSpace`: NTC_COLOR_SPACE_*.
double ConvertToLinear(double stored, ColorSpace colorSpace);

} // namespace openntc::conformance
