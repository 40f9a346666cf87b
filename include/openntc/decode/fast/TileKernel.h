// SPDX-License-Identifier: MIT
// Stability: internal
// What the dispatcher asks of the kernel of one instruction set.
#pragma once

#include "openntc/decode/fast/LatentRows.h"
#include "openntc/decode/fast/PreparedNetwork.h"

#include <new>

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

/// The activation between layers, and the outputs: of the exact contract of generation 1, in binary16 (also
/// that of generation 2), and of generation 3.
enum class Epilogue { Binary32, Binary16, Generation3 };

/// A rectangle of at most kTileWidth × kTileHeight texels inside one mip.
struct TileJob {
    const PreparedNetwork* network = nullptr;
    const MipView* mip = nullptr;
    int left = 0;
    int top = 0;
    int width = 0;
    int height = 0;
    Epilogue epilogue = Epilogue::Binary32;
    float* outputs = nullptr;        ///< 16 values for the first texel of the tile
    std::size_t outputRowStride = 0; ///< in floats
};

struct TileKernel {
    void (*decode)(const TileJob& job, void* scratch) noexcept = nullptr;
    std::size_t scratchBytes = 0; ///< of memory aligned to 64 bytes, one block per thread
    OperandLayout layout = OperandLayout::SignedPairs;
    bool fuses = false; ///< has the activation with fused multiply-adds (PreparedLayer::fused)
};

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
