// SPDX-License-Identifier: MIT
// What the passes TrainTexels and TrainUpdate are given: numbers and structures of the encoder on a device,
// shared by shaders and C++ (encode/TrainingDevice.h). All members are words, so that their places are the
// same everywhere.
#ifndef OPENNTC_TRAIN_CONSTANTS_H
#define OPENNTC_TRAIN_CONSTANTS_H

// A tile is 16 x 8 texels; a workgroup trains strips of two of its rows, 32 texels, one after the other.
#define NTC_TRAIN_TILE_WIDTH 16
#define NTC_TRAIN_TILE_TEXELS 128
#define NTC_TRAIN_STRIP 32
#define NTC_TRAIN_STRIPS_OF_TILE 4
#define NTC_TRAIN_GROUP 256 // lanes of a workgroup, both passes
// Rows of weights: three hidden layers of 64 and 16 outputs.
#define NTC_TRAIN_ROWS 208
// Numbers that a workgroup gives beside the gradients of weights: of biases, and squared errors of outputs.
#define NTC_TRAIN_TAIL (NTC_TRAIN_ROWS + 16)
// Workgroups of TrainUpdate that step the network: eight rows each.
#define NTC_TRAIN_COLUMNS 26
// Gradients of latents are whole numbers of 1 / NTC_TRAIN_LATENT_UNIT, so that their sums do not depend on
// the order.
#define NTC_TRAIN_LATENT_UNIT 1024.0
// Flags of NtcTrainStep.
#define NTC_TRAIN_ROUND 1u     // latents are rounded; otherwise they carry noise of one step
#define NTC_TRAIN_LATENTS 2u   // latents are trained
#define NTC_TRAIN_NETWORK 4u   // the network is trained
#define NTC_TRAIN_MOVE 8u      // a class of latent pixels is moved, to be tried
#define NTC_TRAIN_STREAMED 16u // references are those of the submission's tiles, in its order
#define NTC_TRAIN_WRAPS 32u    // of TrainMoves: latents wrap around, as those of generation 3
// Lanes of a workgroup of TrainMoves, a latent pixel each.
#define NTC_TRAIN_MOVES 64

#if defined(__cplusplus)
// With a space: bundlers of web engines paste every #include that they see, whatever #if it is under.
// clang-format off
# include <cstddef>
# include <cstdint>
// clang-format on
namespace openntc {
#define NTC_FIELD_INT std::int32_t
#define NTC_FIELD_UINT std::uint32_t
#define NTC_FIELD_FLOAT float
#else
#define NTC_FIELD_INT int
#define NTC_FIELD_UINT uint
#define NTC_FIELD_FLOAT float
#endif

/// Quantisation of a latent grid: see encode/detail/Geometry.h.
struct NtcTrainQuantiser {
    NTC_FIELD_FLOAT scale;      // a value times this is a level
    NTC_FIELD_FLOAT levelInput; // network input of a level
    NTC_FIELD_FLOAT lowest;     // levels
    NTC_FIELD_FLOAT highest;
    NTC_FIELD_FLOAT minimum; // values
    NTC_FIELD_FLOAT maximum;
};

/// What stays over a training.
struct NtcTrainConstants {
    NtcTrainQuantiser high;
    NtcTrainQuantiser low;
    NTC_FIELD_INT highFeatures;
    NTC_FIELD_INT lowFeatures;
    NTC_FIELD_INT channels;            // of a reference
    NTC_FIELD_INT maskIndex;           // channel that discards texels of other channels where it is 0, or -1
    NTC_FIELD_INT oneSided;            // channel that is an alpha mask, or -1
    NTC_FIELD_INT channelOf[16];       // of an output: channel of the reference, or -1
    NTC_FIELD_FLOAT gain[16];          // of an output: gradient of a unit of error
    NTC_FIELD_FLOAT squaredRange[16];  // of an output
    NTC_FIELD_FLOAT smallestScale[16]; // of an output's row
};

/// A grid of latents: planes of features, rows one after the other. Of generation 3 the grids are two latent
/// mips, the even one "high".
struct NtcTrainGrid {
    NTC_FIELD_UINT base; // first latent
    NTC_FIELD_UINT width;
    NTC_FIELD_UINT height;
    NTC_FIELD_UINT plane; // latents of a feature
    NTC_FIELD_UINT tapsX; // first tap of the mip's texels along this axis
    NTC_FIELD_UINT tapsY;
    NTC_FIELD_UINT rangesX; // first range of texels, of the pixels along this axis
    NTC_FIELD_UINT rangesY;
};

struct NtcTrainMip {
    NTC_FIELD_INT width;
    NTC_FIELD_INT height;
    NTC_FIELD_UINT neuralMip;
    NTC_FIELD_UINT firstTile;
    NtcTrainGrid high;
    NtcTrainGrid low;
    NTC_FIELD_INT lodInput;
    NTC_FIELD_INT waves[96];       // [wave][phase][coordinate mod 16], of generation 1
    NTC_FIELD_FLOAT positionScale; // of generation 3, whose waves do not repeat
};

/// Push constants of all passes, 72 bytes.
struct NtcTrainStep {
    NTC_FIELD_UINT firstTile; // of the batch, in the list of tiles
    NTC_FIELD_UINT tiles;     // of the batch
    NTC_FIELD_UINT groups;    // workgroups of TrainTexels
    NTC_FIELD_UINT strips;    // of a workgroup; groups * strips = tiles * NTC_TRAIN_STRIPS_OF_TILE
    NTC_FIELD_UINT lossSlot;  // where squared errors go: 16 numbers
    NTC_FIELD_UINT noise;     // seed
    NTC_FIELD_UINT flags;     // NTC_TRAIN_*
    NTC_FIELD_FLOAT maskPush;
    NTC_FIELD_FLOAT networkRate;   // learning rates, with the first moment's correction
    NTC_FIELD_FLOAT networkSecond; // the second moment's correction
    NTC_FIELD_FLOAT networkBeta2;
    NTC_FIELD_FLOAT latentRate;
    NTC_FIELD_FLOAT latentSecond;
    NTC_FIELD_FLOAT latentBeta2;
    NTC_FIELD_UINT move;      // of TryMoves and TrainMoves: feature * 8 + 4 * odd y + 2 * odd x + low grid
    NTC_FIELD_FLOAT levels;   // -1 or 1
    NTC_FIELD_UINT neuralMip; // of TrainMoves
    NTC_FIELD_UINT turn;      // of generation 3: sweeps before, see encode/detail/LatentRefiner.h
};

#if defined(__cplusplus)
static_assert(sizeof(NtcTrainConstants) == 4 * (12 + 5 + 64));
static_assert(sizeof(NtcTrainMip) == 4 * (4 + 16 + 1 + 96 + 1));
static_assert(sizeof(NtcTrainStep) == 72);
static_assert(offsetof(NtcTrainStep, maskPush) == 28);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT
#undef NTC_FIELD_FLOAT

#endif
