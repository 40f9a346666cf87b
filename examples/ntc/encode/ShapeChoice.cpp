// SPDX-License-Identifier: MIT
#include "encode/ShapeChoice.h"

#include "Failure.h"

#include "openntc/texture_set/TextureSetLoader.h"

#include <cmath>
#include <utility>

namespace openntc::tool {

LatentShape FindNearestShape(double bitsPerPixel, int networkVersion,
                             const std::function<bool(const KnownLatentShape&)>& accepts) {
    LatentShape nearest;
    double smallest = 0.0;
    for (int i = 0; i < GetKnownLatentShapeCount(networkVersion); ++i) {
        const KnownLatentShape known = *EnumerateKnownLatentShapes(i, networkVersion);
        if (accepts && !accepts(known))
            continue;
        const double distance = std::fabs(std::log(static_cast<double>(known.bitsPerPixel) / bitsPerPixel));
        if (nearest.IsEmpty() || distance < smallest) {
            nearest = known.shape;
            smallest = distance;
        }
    }
    return nearest;
}

bool IsShapeAccepted(const TextureSetDesc& desc, const LatentShape& shape) {
    const int made = shape.gridSizeScale;
    container::LatentImageRecord finest;
    finest.width = static_cast<std::uint32_t>(GetLatentMipDimension(desc.width, made, 0));
    finest.height = static_cast<std::uint32_t>(GetLatentMipDimension(desc.height, made, 0));
    const int derived = detail::DeriveGridSizeScale(desc, finest);
    if (derived < 1 || derived > kMaxLayeredGridSizeScale)
        return false;
    const int count = GetLatentMipCount(desc, made);
    bool isSame = count == GetLatentMipCount(desc, derived);
    for (const int dimension : {desc.width, desc.height})
        isSame = isSame &&
                 GetLatentMipDimension(dimension, made, 0) == GetLatentMipDimension(dimension, derived, 0);
    for (int mip = 0; mip < desc.mips; ++mip)
        isSame = isSame &&
                 GetLatentMipForColorMip(mip, made, count) == GetLatentMipForColorMip(mip, derived, count);
    return isSame;
}

LatentShape FindAcceptedShape(const TextureSetDesc& desc, const LatentShape& wanted, double bitsPerPixel) {
    if (IsShapeAccepted(desc, wanted))
        return wanted;
    constexpr double kFarthest = 0.25;
    const LatentShape found =
        FindNearestShape(static_cast<double>(GetLatentShapeBitsPerPixel(wanted)), NTC_NETWORK_GENERATION_3,
                         [&](const KnownLatentShape& known) {
                             const double distance =
                                 std::fabs(static_cast<double>(known.bitsPerPixel) - bitsPerPixel);
                             return IsShapeAccepted(desc, known.shape) &&
                                    (bitsPerPixel <= 0.0 || distance < kFarthest * bitsPerPixel);
                         });
    return found.IsEmpty() ? wanted : found;
}

encode::AdaptiveSearch MakeShapeSearch(const TextureSetDesc& desc, int networkVersion, double maximumBits) {
    if (GetGeneration(networkVersion) == 3) {
        auto search =
            encode::AdaptiveSearch::Create(networkVersion, 0.0, maximumBits, [&](const LatentShape& shape) {
                return IsShapeAccepted(desc, shape);
            });
        if (search)
            return std::move(*search);
    }
    return Require(encode::AdaptiveSearch::Create(networkVersion, 0.0, maximumBits), ExitCode::Usage,
                   "--target-psnr");
}

} // namespace openntc::tool
