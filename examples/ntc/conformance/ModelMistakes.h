// SPDX-License-Identifier: MIT
// What decoders get wrong: one deliberate mistake at a time, made by the independent model.
#pragma once

#include <cstdint>
#include <span>

namespace openntc::conformance {

/// The table in ModelMistakes.cpp names and explains each. Ranges of enumerators matter to Model::GetSet.
enum class Mistake : std::uint8_t {
    None,
    // Arithmetic.
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
    SaturatedAccumulator,
    ShortAccumulator,
    SaturatedPairs,
    TruncatedSum,
    UnsignedWeights,
    ClippedWeights,
    ColumnMajorWeights,
    LayerScale,
    MissingBiases,
    ActivatedOutputs,
    UnclampedActivation,
    TruncatedHalfOutputs,
    HalfOutputsInFloatMode,
    Code255As254,
    UnsignedLatents,
    SymmetricOneBit,
    SymmetricTwoBits,
    SymmetricFourBits,
    NearestLatents,
    TruncatedCells,
    ReversedTaps,
    SwappedWaves,
    WaveOrder,
    WavePhase,
    ReversedFrequencies,
    PositionScaleIgnored,
    LodOnce,
    TruncatedFractions,
    TruncatedE4M3,
    E4M3TiesAway,
    E4M3Max480,
    E4M3WeightsFlushed,
    E5M2Weights,
    FP8LodClamped,
    FP8HiddenE4M3,
    UnusedSlotsOf8,
    // Arithmetic of generations 2 and 3.
    ClampedBorders,
    ReversedLayers,
    ReversedTexelCodes,
    SixteenSteps,
    OneLatentMip,
    AbsentLayersAsCodes,
    TriangleWaves,
    FrequenciesOfGeneration1,
    FlooredWaves,
    LatentsOfOtherGeneration,
    FloatEpilogueOfGeneration2,
    HalfEpilogueOfGeneration3,
    OffsetBeforeRounding,
    ExactThird,
    // The set.
    TwoLatentImages,
    ImageOffByOneAtScale3,
    ImageOffByOneAtScale5,
    ImageOffByOneAtScale6,
    ImageOffByOneAtScale7,
    ImageOffByOneAtScale8,
    LowResOfImage0,
    ImageOfEarlierMip,
    FormulaGrids,
    FormulaPositions,
    RoundedUpMips,
    PixelsOfPowerOfTwo,
    TwelveByOneAsSixteen,
    TwelveByTwoZero,
    SixteenByEightZero,
    SwappedBitWidths,
    RowsPaddedToBytes,
    RowsPaddedToWords,
    SharedColorSpace,
    ColorSpaceOfTexture,
    // Reading the file.
    SequentialViews,
    FixedViews,
    BinaryBehindJson,
    LegacyBiasBits,
    LegacyTypeOfNetwork,
    LegacyTypeOfLayer,
    LegacyTruncatedBias,
    LegacyTiesToEven,
    LegacyZeroScale,
    LegacyChannelScale,
    AbsentScalesZero,
    AbsentPositionsZero,
    FirstNetworkIsInt8,
    // The request.
    NextMip,
    FlippedRows,
    TransposedTexels,
    WholeMipPaddedRows,
    WholeMipByColumns,
    WholeMipFromMip1,
    WholeMipPartialBlocks,
    ClampedTexels,
    UnsignedTexels,
    TruncatedWaves,
    RebasedSlices,
    SlicesWithoutBorder,
    SliceRowsAtBytes,
    SliceMipsUnshifted,
    SliceMipsReversed,
    SliceLatentsOfCoarsest,
    SliceLatentsOfFinest,
    SliceImagesAtStart,
    // Outputs and colours.
    SwappedChannels,
    ReversedColors,
    RotatedChannels,
    UndeclaredZero,
    ClampedOutputs,
    InfinityAsNan,
    InfinityAsMaximum,
    Channel15Stored,
    Gamma22,
    SrgbNegativeZero,
    SrgbKnee,
    HlgConstantA,
    HlgConstantB,
    HlgClamped,
    // State left from the set before.
    KeptWeights,
    KeptScales,
    KeptBiases,
    KeptLatents,
    KeptBitWidths,
    KeptFeatures,
    KeptLods,
    KeptImages,
    KeptColorSpaces,
    KeptSizes,
};

enum class MistakeKind : std::uint8_t {
    Values, ///< explained by the set alone: wrong values name it
    State,  ///< depends on the set before
};

struct MistakeInfo {
    Mistake mistake;
    const char* name;     ///< of the switch, words joined by underscores
    const char* cause;    ///< what the decoder does, and should do
    const char* caseName; ///< the exported case that is meant for it
    MistakeKind kind = MistakeKind::Values;
};

/// Every mistake but None.
std::span<const MistakeInfo> ListMistakes();

} // namespace openntc::conformance
