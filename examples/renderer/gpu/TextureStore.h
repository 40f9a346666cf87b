// SPDX-License-Identifier: MIT
// Textures and texture sets of a scene on the device.
#pragma once

#include "renderer/gpu/DeviceSet.h"
#include "renderer/gpu/FeedbackStore.h"
#include "renderer/gpu/MaterialPlan.h"
#include "renderer/gpu/MathChoice.h"
#include "renderer/gpu/RequireDevice.h"
#include "renderer/gpu/ShaderCache.h"
#include "renderer/scene/Scene.h"

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

/// Bytes on the device by what they are for.
struct MemoryUse {
    std::uint64_t sourceTextures = 0;
    std::uint64_t decodedTextures = 0; ///< of texture sets, uncompressed
    std::uint64_t blockTextures = 0;   ///< of texture sets, block-compressed
    std::uint64_t latents = 0;
    std::uint64_t weights = 0; ///< with constants
    FeedbackMemory feedback;   ///< of textures that are decoded on demand
};

class TextureStore {
public:
    /// Opens the scene's texture sets; what cannot be used gets an error in Scene::textureSets. Chooses the maths mode: what is not
    /// as it was asked for is a warning of the scene. Throws CommandError(NoDevice) where no mode passes the self-test.
    TextureStore(harness::Context& context, ShaderCache& shaders, Scene& scene, const RenderOptions& options);

    const std::vector<LoadedSetInfo>& GetSets() const { return sets_; }
    /// As far as shaders use them.
    const DeviceFeatures& GetFeatures() const { return features_; }
    const MathChoice& GetMath() const { return math_; }

    /// Makes the textures of the plans that are not there: uploads, decodes, compresses. Throws CommandError.
    void Load(const std::vector<MaterialPlan>& plans);

    /// The texture of a slot whose source is Image or Decoded, after Load.
    const harness::Image& GetImage(const SlotPlan& slot, std::size_t index) const;
    const DeviceSet& GetSet(int set) const { return deviceSets_.at(set); }

    /// What is decoded on demand; null in other modes, and if there is nothing.
    FeedbackStore* GetFeedback() const { return feedback_.get(); }
    /// NtcrLookup::tiles of a set of the scene, or of none with -1.
    std::int32_t FindTiles(int set) const {
        return feedback_ && set >= 0 ? static_cast<std::int32_t>(feedback_->GetTexture(set)) : -1;
    }

    MemoryUse GetMemory() const;
    double GetDecodeSeconds() const { return decodeSeconds_; }       ///< of the device, on load
    double GetTranscodeSeconds() const { return transcodeSeconds_; } ///< likewise

private:
    /// Textures that are equal: what is read, at which channels, as a colour or not, stored how, with which mips.
    using Key = std::tuple<TexelSource, int, int, int, bool, bool, bool, float>;
    void ChooseMath();
    /// The sets that have the weights of a maths mode. Why there is none, where others could be used; else nothing.
    std::string OpenSets(int math);
    /// What is wrong with the device's numbers, or nothing; integer dot products that are wrong are done without, with a warning
    /// of the scene.
    std::string TestDecoding(int math);
    static Key MakeKey(const SlotPlan& slot, std::size_t index);

    harness::Image UploadSource(const SlotPlan& slot, bool isColor);
    harness::Image UploadNeutral(std::size_t index);
    void UploadSet(int set);
    void DecodeSet(int set, const std::vector<std::pair<Key, SlotPlan>>& textures);
    void StreamSet(int set, const std::vector<std::pair<Key, SlotPlan>>& textures);
    /// The blocks of a decoded texture, or the texture itself where none are asked for.
    harness::Image Compress(harness::Image image, const SlotPlan& slot);

    harness::Context& context_;
    ShaderCache& shaders_;
    Scene& scene_;
    const RenderOptions& options_;
    DeviceFeatures features_;
    MathChoice math_;
    std::vector<std::unique_ptr<tool::TextureSet>> files_; // parallel to the scene's
    std::vector<LoadedSetInfo> sets_;
    std::map<Key, harness::Image> images_;
    std::map<int, DeviceSet> deviceSets_;
    std::unique_ptr<FeedbackStore> feedback_;
    std::map<Key, std::size_t> streamed_; // numbers of textures in their set
    MemoryUse memory_;
    double decodeSeconds_ = 0.0;
    double transcodeSeconds_ = 0.0;
};

} // namespace openntc::renderer
