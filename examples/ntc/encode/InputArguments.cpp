// SPDX-License-Identifier: MIT
#include "encode/InputArguments.h"

#include "encode/TrainingArguments.h"
#include "encode/TrainingLimits.h"

namespace openntc::tool {

void AddWeightOption(CLI::App& command, std::vector<NamedNumber>& weights) {
    command
        .add_option_function<std::vector<std::string>>(
            "--weight",
            [&weights](const std::vector<std::string>& texts) {
                for (const std::string& text : texts)
                    weights.push_back(ParseNamedNumber("--weight", text, kWeightLimits));
            },
            "Weight of a texture's error in training (1 without it); may be repeated")
        ->type_name("NAME=W")
        ->allow_extra_args(false);
}

void AddInputOptions(CLI::App& command, InputOptions& inputs) {
    AddNumberOption(command, "--mips", inputs.mips, kMipLimits, "Number of mips (default: the full chain)");
    command
        .add_option_function<std::string>(
            "--mip-filter",
            [&inputs](const std::string& name) {
                inputs.mipFilter = SelectName("--mip-filter", name, kMipFilterNames,
                                              {image::MipFilter::Box, image::MipFilter::Kaiser});
            },
            "box (default) or kaiser, which keeps mips sharper")
        ->type_name("NAME");
    command
        .add_option_function<std::string>(
            "--mip-wrap",
            [&inputs](const std::string& name) {
                inputs.mipWrap = SelectName("--mip-wrap", name, kMipWrapNames,
                                            {image::MipWrap::Wrap, image::MipWrap::Clamp});
            },
            "What that filter sees beyond the edges: wrap (default) or clamp")
        ->type_name("NAME");
    command
        .add_option("--normal-map", inputs.normalMaps,
                    "Texture or file that holds normals: its mips become unit vectors; may be repeated")
        ->type_name("NAME")
        ->allow_extra_args(false);
    AddWeightOption(command, inputs.weights);
    AddNumberOption(command, "--keep-coverage", inputs.keepCoverage, {1.0 / 65536.0, 1.0},
                    "Scale alpha in mips so that as many texels pass this alpha test as in mip 0");
}

} // namespace openntc::tool
