// SPDX-License-Identifier: MIT
#include "renderer/gpu/SetDecoding.h"

#include <algorithm>
#include <sstream>

namespace openntc::renderer {

using harness::ImageFormat;

std::vector<std::string> SplitDefines(std::string_view text) {
    std::istringstream words{std::string(text)};
    std::vector<std::string> defines;
    for (std::string word; words >> word;)
        defines.push_back(word);
    return defines;
}

std::vector<std::string> ListDefines(const DecompressionPass& pass) {
    std::vector<std::string> defines = SplitDefines(pass.permutation.key.ToDefines().View());
    if (!pass.convertsColors)
        defines.emplace_back(pass.GetOwnDefines());
    return defines;
}

DecompressionOutput MakeOutput(const SlotPlan& slot, bool isColor) {
    DecompressionOutput output;
    output.firstChannel = slot.firstChannel;
    output.numChannels = std::min(slot.channels, 4);
    output.rgbColorSpace = isColor && !slot.isLinear ? ColorSpace::sRGB : ColorSpace::Linear;
    output.unormBits = slot.isLinear ? 0 : 8;
    return output;
}

ImageFormat GetTexelFormat(const SlotPlan& slot) {
    return slot.isLinear ? ImageFormat::RGBA16F : ImageFormat::RGBA8;
}

ImageFormat GetStoredFormat(const SlotPlan& slot) {
    return slot.block
               ? static_cast<ImageFormat>(static_cast<int>(ImageFormat::BC1) + static_cast<int>(*slot.block))
               : GetTexelFormat(slot);
}

bc::BlockCompressionDesc MakeBlockDesc(const SlotPlan& slot, tool::BlockEffort effort,
                                       const DeviceFeatures& device) {
    bc::BlockCompressionDesc desc;
    desc.format = *slot.block;
    desc.quality = tool::ToBlockQuality(effort);
    desc.integerDotProduct = device.integerDotProduct && !device.isCpu;
    if (desc.format == bc::BlockFormat::Bc1 && slot.channels == 4)
        desc.alphaThreshold = tool::kBc1OpaqueAlpha - 1;
    return desc;
}

} // namespace openntc::renderer
