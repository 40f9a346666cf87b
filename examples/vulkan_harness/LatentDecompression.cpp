// SPDX-License-Identifier: MIT
#include "LatentDecompression.h"

namespace openntc::harness {

void AddLatentCommands(const LatentDecompression& plan, const Buffer& work, const Buffer& latents,
                       LatentCommands& commands) {
    for (const LatentTile& tile : plan.tiles)
        commands.tiles.push_back({&work, tile.source, tile.sourceBytes, tile.isInWork ? &work : &latents,
                                  tile.destination, tile.bytes});
    for (const LatentCopy& copy : plan.copies)
        commands.copies.push_back({&work, copy.source, &latents, copy.destination, copy.bytes});
}

} // namespace openntc::harness
