// SPDX-License-Identifier: MIT
// Masked surfaces of a frame: what may be there is collected as it is drawn, decided in compute shaders, and drawn.
#include "renderer/gpu/Renderer.h"

#include <array>

namespace openntc::renderer {

using namespace openntc::harness;

double Renderer::CollectCandidates(const std::vector<std::size_t>& instances) {
    for (;;) {
        const double cleared = DispatchScreen(clearCandidates_);
        const double drawn = Draw(instances, &MaterialState::collect, visible_, false);
        std::array<std::uint32_t, 1> count{};
        RequireDevice(context_.Read(candidates_, 0, std::as_writable_bytes(std::span(count))));
        const std::uint64_t bytes = 16 + 16 * std::uint64_t{count[0]};
        if (bytes <= candidates_.GetSize())
            return cleared + drawn;
        // Some are in no list: once more, with room for all of them and for those of a similar frame.
        candidates_ = RequireDevice(context_.CreateBuffer(bytes + bytes / 4 / 16 * 16, BufferKind::Storage,
                                                          BufferMemory::DeviceLocal));
    }
}

double Renderer::DrawMasks(const std::vector<std::size_t>& instances) {
    const double collected = CollectCandidates(instances);
    const double resolved = DispatchTiles(&MaterialState::resolve, false);
    return collected + resolved + Draw(instances, &MaterialState::draw, visible_, false);
}

} // namespace openntc::renderer
