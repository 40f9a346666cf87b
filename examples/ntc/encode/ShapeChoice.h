// SPDX-License-Identifier: MIT
// Which known latent shape a file gets. Of generation 3 LibNTC derives the scale from the sizes in the file
// again, and refuses small files of which that gives other latents than they have.
#pragma once

#include "openntc/encode/AdaptiveSearch.h"
#include "openntc/texture_set/MipChain.h"

#include <functional>

namespace openntc::tool {

/// The known shape of a network whose bits per pixel are nearest, in proportion, of those that `accepts`,
/// where given; the empty shape if there is none.
LatentShape FindNearestShape(double bitsPerPixel, int networkVersion,
                             const std::function<bool(const KnownLatentShape&)>& accepts = {});

/// True if the latents that an encoder makes with this shape, of generation 3, are those that LibNTC expects:
/// FindRefusals then finds nothing.
bool IsShapeAccepted(const TextureSetDesc& desc, const LatentShape& shape);

/// Of generation 3: `wanted`, or where it is not accepted the nearest known shape that is, with `bitsPerPixel`
/// > 0 less than 25 % from that (PickLatentShape); `wanted` where there is none.
LatentShape FindAcceptedShape(const TextureSetDesc& desc, const LatentShape& wanted, double bitsPerPixel);

/// A search over the network's known shapes, of generation 3 over those that are accepted, or all where none
/// is. Throws CommandError(Usage) if no shape is as small as `maximumBits` (> 0).
encode::AdaptiveSearch MakeShapeSearch(const TextureSetDesc& desc, int networkVersion, double maximumBits);

} // namespace openntc::tool
