// SPDX-License-Identifier: MIT
#include "Verification.h"

#include "Failure.h"
#include "Interrupt.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <tuple>
#include <vector>

namespace openntc::landscape {

namespace {

void CheckPixel(const DecodeSource& source, const LandscapePixel& pixel, Check& check) {
    float outputs[NTC_MAX_CHANNELS];
    const int mip = static_cast<int>(pixel.state & 255u);
    const auto decoded = DecodeReference(source, mip, {pixel.x, pixel.y, 1, 1}, {}, outputs);
    ++check.texels;
    if (!decoded || std::memcmp(outputs, pixel.outputs, sizeof(outputs)) != 0)
        ++check.wrong;
}

} // namespace

Check CheckPixels(const Landscape& landscape, std::span<const LandscapePixel> pixels, std::size_t step) {
    // Fields with the same latents together: those take longer to make than texels to decode.
    std::map<std::tuple<std::size_t, int, int>, std::vector<const LandscapePixel*>> groups;
    for (std::size_t i = 0; i < pixels.size(); i += step) {
        if (pixels[i].field >= landscape.GetFields().size() || (pixels[i].state & LANDSCAPE_DECODED) == 0)
            continue;
        const Field& field = landscape.GetFields()[pixels[i].field];
        groups[{field.set, field.phase.x, field.phase.y}].push_back(&pixels[i]);
    }
    Check check;
    for (const auto& [key, members] : groups) {
        tool::ThrowIfInterrupted();
        const RepeatedSet& set = *landscape.GetSets()[std::get<0>(key)];
        const std::vector<std::byte> latents = set.MakeLatents({std::get<1>(key), std::get<2>(key)});
        const DecodeSource source = {&set.GetConstants(), latents, set.GetWeights(),
                                     landscape.GetNetworkVersion()};
        for (const LandscapePixel* pixel : members)
            CheckPixel(source, *pixel, check);
    }
    return check;
}

} // namespace openntc::landscape
