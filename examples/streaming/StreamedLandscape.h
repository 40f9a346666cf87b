// SPDX-License-Identifier: MIT
// A landscape whose tiles a demand loader brings, and a frame of it.
#pragma once

#include "Renderer.h"
#include "Session.h"

#include "openntc/streaming/DemandLoader.h"

#include <memory>
#include <optional>
#include <vector>

namespace openntc::landscape {

class StreamedLandscape {
public:
    /// Throws CommandError: Usage for a budget without room for the tails; NoDevice.
    StreamedLandscape(harness::Context& context, const Landscape& landscape, const SessionOptions& options);

    /// Passes of one frame, as many as it takes or the options allow. Throws CommandError.
    FrameRecord DrawFrame(LandscapeScene scene);

    Renderer& GetRenderer() noexcept { return *renderer_; }
    const DemandLoader& GetLoader() const noexcept { return *loader_; }
    std::span<const std::uint32_t> GetTextureIds() const noexcept { return textureIds_; }
    void Describe(Report& report) const;

private:
    void CreateLoader();
    void AddTextures();
    void DrawPass(LandscapeScene& scene, FrameRecord& record);
    void WaitFor(const DemandTicket& ticket) const;
    void ReportErrors();

    const Landscape& landscape_;
    const SessionOptions& options_;
    std::uint32_t slotBytes_ = 0;
    std::uint32_t slots_ = 0;
    std::optional<DemandLoader> loader_;
    std::optional<Renderer> renderer_;
    std::vector<std::uint32_t> textureIds_; // of fields
};

} // namespace openntc::landscape
