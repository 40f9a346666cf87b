// SPDX-License-Identifier: MIT
// Textures and texture sets of a scene on the device.
#pragma once

#include "renderer/gpu/MaterialPlan.h"
#include "renderer/gpu/ShaderCache.h"
#include "renderer/scene/Scene.h"

#include "Failure.h"
#include "TextureSet.h"
#include "vulkan_harness/Vulkan.h"

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace openntc::renderer {

/// The value, or CommandError: NoDevice for what the device lacks and for memory that it refuses, else Failed.
template <typename T>
T RequireDevice(Expected<T>&& value) {
    const bool isDevice = !value && (value.error().GetStatus() == Status::Unsupported ||
                                     value.error().GetStatus() == Status::OutOfMemory);
    if (isDevice)
        throw tool::CommandError(tool::ExitCode::NoDevice, "vulkan", value.error().GetText());
    return tool::Require(std::move(value), tool::ExitCode::Failed, "vulkan");
}

/// Bytes on the device by what they are for.
struct MemoryUse {
    std::uint64_t sourceTextures = 0;
    std::uint64_t decodedTextures = 0; ///< of texture sets, uncompressed
    std::uint64_t blockTextures = 0;   ///< of texture sets, block-compressed
    std::uint64_t latents = 0;
    std::uint64_t weights = 0; ///< with constants
};

/// A texture set that shaders decode.
struct DeviceSet {
    harness::Buffer constants;
    harness::Buffer latents;
    harness::Buffer weights;
};

class TextureStore {
public:
    /// Opens the scene's texture sets; what cannot be used gets an error in Scene::textureSets.
    TextureStore(harness::Context& context, ShaderCache& shaders, Scene& scene, const RenderOptions& options);

    const std::vector<LoadedSetInfo>& GetSets() const { return sets_; }
    const DeviceFeatures& GetFeatures() const { return features_; }

    /// Makes all textures of the plans: uploads, decodes, compresses. Throws CommandError.
    void Load(const std::vector<MaterialPlan>& plans);

    /// The texture of a slot whose source is Image or Decoded, after Load.
    const harness::Image& GetImage(const SlotPlan& slot, std::size_t index) const;
    const DeviceSet& GetSet(int set) const { return deviceSets_.at(set); }

    const MemoryUse& GetMemory() const { return memory_; }
    double GetDecodeSeconds() const { return decodeSeconds_; }       ///< of the device, on load
    double GetTranscodeSeconds() const { return transcodeSeconds_; } ///< likewise

private:
    /// Textures that are equal: what is read, at which channels, as a colour or not.
    using Key = std::tuple<TexelSource, int, int, int, bool, bool>;
    static Key MakeKey(const SlotPlan& slot, std::size_t index);

    harness::Image UploadSource(const SourceImage& image, bool isColor, bool isLinear);
    harness::Image UploadNeutral(std::size_t index);
    void UploadSet(int set);
    void DecodeSet(int set, const std::vector<std::pair<Key, SlotPlan>>& textures);
    /// The blocks of a decoded texture, or the texture itself where none are asked for.
    harness::Image Compress(harness::Image image, const SlotPlan& slot);

    harness::Context& context_;
    ShaderCache& shaders_;
    Scene& scene_;
    const RenderOptions& options_;
    DeviceFeatures features_;
    std::vector<std::unique_ptr<tool::TextureSet>> files_; // parallel to the scene's
    std::vector<LoadedSetInfo> sets_;
    std::map<Key, harness::Image> images_;
    std::map<int, DeviceSet> deviceSets_;
    MemoryUse memory_;
    double decodeSeconds_ = 0.0;
    double transcodeSeconds_ = 0.0;
};

} // namespace openntc::renderer
