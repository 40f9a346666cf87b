// SPDX-License-Identifier: MIT
// A scene that the renderer drew (Scenes.h), as written to report.json.
#pragma once

#include "report/Spread.h"

#include <cstdint>
#include <string>
#include <vector>

namespace openntc::report {

/// Bytes of a kind on the device: the names of `ntc-renderer --stats`.
struct SceneBytes {
    std::string kind;
    std::uint64_t bytes = 0;
};

struct SceneRecord {
    std::string id, device, scene; ///< "sample", "everything", or a model's file
    std::string mode;              ///< reference, on-load, on-sample, on-feedback
    std::string blocks;            ///< of on-load and on-feedback: "auto" or "none"; of other modes empty
    std::string filter, stf,
        math;            ///< as `ntc-renderer` names them; maths: empty where the shader decodes nothing
    std::string effects; ///< "derived" from what the scene calls for, and with "all" or one on too
    int width = 0, height = 0;
    int frames = 0; ///< whose mean the picture is
    std::string skipped;
    Spread time;                              ///< milliseconds a frame, after the first one
    double visibility = 0, shading = 0;       ///< milliseconds, medians; with masks; sky, opaque and blended
    double texelsRead = 0, texelsDecoded = 0; ///< per pixel and frame
    double psnr = 0,
           flip = 0; ///< of the picture against the reference mode with all texels of the same filter
    std::uint64_t otherPixels =
        0; ///< of forced effects: pixels that differ from the picture of the derived effects
    std::vector<SceneBytes> bytes;
    std::vector<std::string> effectsOn; ///< in any material that is shown
    int permutations = 0;
    std::uint64_t shaderWords = 0; ///< SPIR-V of those
    double compileMilliseconds = 0;

    /// 0 for kinds that are not there.
    std::uint64_t GetBytes(const char* kind) const {
        for (const SceneBytes& b : bytes) {
            if (b.kind == kind)
                return b.bytes;
        }
        return 0;
    }
};

template <typename A>
void Describe(A& a, SceneBytes& r) {
    a("kind", r.kind);
    a("bytes", r.bytes);
}

template <typename A>
void Describe(A& a, SceneRecord& r) {
    a("id", r.id);
    a("device", r.device);
    a("scene", r.scene);
    a("mode", r.mode);
    a("blocks", r.blocks);
    a("filter", r.filter);
    a("stf", r.stf);
    a("math", r.math);
    a("effects", r.effects);
    a("width", r.width);
    a("height", r.height);
    a("frames", r.frames);
    a("skipped", r.skipped);
    a("millisecondsAFrame", r.time);
    a("visibilityMilliseconds", r.visibility);
    a("shadingMilliseconds", r.shading);
    a("texelsRead", r.texelsRead);
    a("texelsDecoded", r.texelsDecoded);
    a("psnr", r.psnr);
    a("flip", r.flip);
    a("otherPixels", r.otherPixels);
    a("bytes", r.bytes);
    a("effectsOn", r.effectsOn);
    a("permutations", r.permutations);
    a("shaderWords", r.shaderWords);
    a("compileMilliseconds", r.compileMilliseconds);
}

} // namespace openntc::report
