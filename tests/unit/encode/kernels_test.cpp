// SPDX-License-Identifier: MIT
// Kernels whose bytes do not depend on the processor. In an emulator, where it is all that trains: few steps.
#include "DecodedSet.h"
#include "Train.h"
#include "support/HardPatterns.h"

#include "openntc/core/Crc32.h"
#include "openntc/encode/Kernels.h"

#include <cmath>
#include <string>

using namespace openntc;
using namespace openntc::encode;

namespace {

/// Coordinates of texels are exact, so that compilers that fuse multiplications and additions place latents alike.
Material MakeSmallRamp() {
    Material material = *Material::Create(16, 16);
    std::vector<float> texels;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            for (int c = 0; c < 3; ++c)
                texels.push_back(patterns::Ramp(x, y, c));
        }
    }
    REQUIRE(material.AddTexture({.name = "Texture", .firstChannel = 0, .channels = 3}, texels));
    material.GenerateMips();
    return material;
}

} // namespace

TEST_CASE("kernels that multiply in binary32 give the same bytes on every processor; those of bfloat16 "
          "report their PSNR") {
    const Material material = MakeSmallRamp();
    EncodeOptions options;
    options.steps = 3;
    options.threads = 1;
    for (const KernelChoice kernel : kKernels) {
        if (!IsKernelAvailable(kernel) || kernel == KernelChoice::Portable) // which is pinned by itself
            continue;
        CAPTURE(std::string(KernelToString(kernel)));
        options.kernel = kernel;
        const auto result = test::Train(material, options);
        REQUIRE(result.has_value());
        const double psnr = test::MeasurePsnr(material, test::DecodeFile(result->file));
        CHECK(std::fabs(psnr - result->psnr) < 0.05); // the project's promise
        // Pinned: AVX2, AVX-512 and NEON agreed on it. Changes with every change of training.
        if (kernel == KernelChoice::Avx2 || kernel == KernelChoice::Avx512 || kernel == KernelChoice::Neon)
            CHECK(Crc32(result->file) == 0x02301e86u);
    }
}
