// SPDX-License-Identifier: MIT
// What accuracy costs in time in a whole picture: the renderer's scenes in every mode, with every filter, drawn texels and
// maths mode. `ntc-renderer` is run as a program.
#pragma once

#include "report/Report.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace openntc::report {

inline constexpr const char* kSceneFilter = "trilinear"; ///< of rows that do not vary it
inline constexpr const char* kEverything = "everything"; ///< the test scene that calls for every effect

/// A point of the axes filter, delivery and scene, in names of `ntc-renderer`'s options.
struct SceneCase {
    std::string scene = "sample"; ///< or a test scene's name
    std::string mode = "reference";
    std::string stf = "off";
    std::string filter = kSceneFilter;
    std::string math;      ///< of modes that decode in the shader
    bool hasBlocks = true; ///< of modes that keep textures
    std::string forced;    ///< effects that are on without being called for: "all", or one; empty: none

    std::string GetId() const;
};

/// `quick`: a few.
std::vector<SceneCase> ListSceneCases(bool quick);

struct SceneSettings {
    std::string renderer; ///< the program; empty: it was not found
    std::string model;    ///< in the place of the sample scene; empty: that
    std::string materialDir;
    std::string sources;       ///< folder of OpenNTC's source
    std::string glslang;       ///< a program for cooperative vectors; empty: one that the renderer finds
    int width = 0, height = 0; ///< 0: by the device
    bool quick = false;
    std::filesystem::path scratch; ///< folder for pictures and numbers, which are removed
};

/// `ntc-renderer` in the folder of this program, or empty.
std::string FindRenderer();

/// A line about a record: its figures, or why it was skipped.
std::string DescribeScene(const SceneRecord& record);

class SceneMeasurement {
public:
    /// `isSlow`: small pictures, few frames.
    SceneMeasurement(const SceneSettings& settings, const DeviceRecord& device, bool isSlow);
    ~SceneMeasurement();
    SceneMeasurement(const SceneMeasurement&) = delete;
    SceneMeasurement& operator=(const SceneMeasurement&) = delete;

    /// Runs the renderer, and first what the picture is compared with, if that has not been drawn. What the program does
    /// not offer, or fails at, is skipped with its reason.
    SceneRecord Measure(const SceneCase& c);

private:
    struct Drawn {
        SceneRecord record;
        std::vector<float> colors; ///< three a pixel, sRGB
    };
    Drawn& Draw(const SceneCase& c);
    std::string RunRenderer(const SceneCase& c, std::string& warning) const;

    const SceneSettings& settings_;
    const DeviceRecord& device_;
    int width_, height_, frames_;
    int warmUp_; ///< milliseconds
    std::filesystem::path picture_, stats_;
    std::map<std::string, Drawn> drawn_; // by case
};

} // namespace openntc::report
