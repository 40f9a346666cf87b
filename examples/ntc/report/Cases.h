// SPDX-License-Identifier: MIT
// The one list of cases that `ntc report` runs. A new axis is a line of kAxes in Cases.cpp, and a member here.
#pragma once

#include <string>
#include <vector>

namespace openntc::report {

inline constexpr const char* kBricks = "bricks";

/// How weights are fetched; the device's default is Default.
enum class WeightsForm { Default, Direct, Wide, WideTwoTexels, SubgroupFloat };

/// A point; its initial values are the base point.
struct Case {
    std::string material = kBricks;
    int math = 1;            ///< NTC_MATH_*
    int network = 2;         ///< NTC_NETWORK_*, of generations 2 and 3 too
    double bitsPerPixel = 4; ///< picks a known latent shape
    int outputs = 9;         ///< the first declared ones; 16: all
    bool linear = false;     ///< converted to linear light, or as stored
    int sets = 0;            ///< different sets in one workgroup; 0: one, at a fixed place
    WeightsForm weights = WeightsForm::Default;
    /// Instruction set of the C++ decoder, on one thread: 1 + its place in ListSimdTargets. 0: the fastest, all threads.
    int instructions = 0;
    bool latentTexture = false;    ///< latents of generations 2 and 3 in a texture, filtered by the device
    std::vector<std::string> axes; ///< names of the lines through the base point that it lies on

    std::string GetId() const;
};

/// Every case once; `quick`: fewer values, no grid. `modelMaterial`: a material of a model to vary bits per pixel on, or
/// empty.
std::vector<Case> ListCases(bool quick, const std::string& modelMaterial);

inline constexpr int kMathCount = 9;

/// Maths modes that decode blocks of texels on cooperative matrices.
bool UsesMatrices(int math);

/// Lower case names, those of `ntc compile-shaders`.
const char* GetMathName(int math);
const char* GetWeightsName(WeightsForm weights);
/// Empty for 0.
const char* GetInstructionsName(int instructions);

/// bricks-medium-4bpp.
std::string GetEncodingName(const Case& c);

} // namespace openntc::report
