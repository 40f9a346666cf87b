// SPDX-License-Identifier: MIT
// Stability: internal
// What an encoder asks of its input before it begins.
#pragma once

#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Checks, and returns the shape of latents that the options mean.
inline Expected<LatentShape> CheckEncodeOptions(const Material& material, const EncodeOptions& options) {
    if (!material.IsComplete())
        return Fail(Status::InvalidArgument, "material: a channel lacks a mip: all are needed");
    const int generation = GetGeneration(options.networkVersion);
    if (generation != 1 && generation != 3)
        return Fail(Status::OutOfRange, "network: %d: must be %d ... %d or %d", options.networkVersion,
                    NTC_NETWORK_SMALL, NTC_NETWORK_XLARGE, NTC_NETWORK_GENERATION_3);
    if (options.compress && generation != 3)
        return Fail(Status::OutOfRange, "compress: 1: only sets of generation 3 have compressed latents");
    if (options.maskChannel >= 0 && (options.maskChannel >= Material::kMaxChannels ||
                                     (material.GetDeclaredChannels() >> options.maskChannel & 1u) == 0))
        return Fail(Status::OutOfRange, "maskChannel: %d: belongs to no texture", options.maskChannel);
    if (options.threads < 0 || options.threads > kMaxThreads)
        return Fail(Status::OutOfRange, "threads: %d: must be 0 ... %d", options.threads, kMaxThreads);
    if (options.batchTexels < 0 || options.batchTexels > 65536 || options.batchTexels % 1024 != 0)
        return Fail(Status::OutOfRange, "batchTexels: %d: must be a multiple of 1024 up to 65536, or 0",
                    options.batchTexels);
    LatentShape shape = options.latentShape;
    if (shape.IsEmpty()) {
        OPENNTC_ASSIGN(const KnownLatentShape known,
                       PickLatentShape(options.bitsPerPixel, options.networkVersion));
        shape = known.shape;
    }
    OPENNTC_CHECK(ValidateLatentShape(shape, options.networkVersion));
    return shape;
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
