// SPDX-License-Identifier: MIT
#include "Model.h"

#include "ModelSet.h"

#include <algorithm>
#include <cmath>

namespace openntc::conformance {

Rect GetSlicePart(const Rect& slice, int level, int width, int height) {
    const auto halve = [level](int end) { return (end + (1 << level) - 1) >> level; };
    const int left = std::min(slice.left >> level, width);
    const int top = std::min(slice.top >> level, height);
    return {left, top, std::min(halve(slice.left + slice.width), width) - left,
            std::min(halve(slice.top + slice.height), height) - top};
}

Model::Model(std::span<const std::byte> file)
    : file_(file), set_(std::make_unique<ModelSet>(ReadModelSet(file))) {}
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;
Model& Model::operator=(Model&&) noexcept = default;

const ModelSet& Model::GetSet(Mistake mistake) const {
    const bool isEdited = mistake >= Mistake::TwoLatentImages && mistake <= Mistake::Channel15Stored;
    if (!isEdited || set_->generation > 1) // what is edited are latent images
        return *set_;
    if (editedSet_ == nullptr || edited_ != mistake) {
        // Readers' mistakes show in another reading, the others in another set.
        const bool isReader = mistake >= Mistake::SequentialViews && mistake <= Mistake::FirstNetworkIsInt8;
        editedSet_ = std::make_unique<ModelSet>(isReader ? ReadModelSet(file_, mistake) : *set_);
        EditSet(mistake, *editedSet_);
        edited_ = mistake;
    }
    return *editedSet_;
}

std::array<float, 16> Model::Decode(const ModelRequest& request, Mistake mistake) const {
    const ModelSet& set = GetSet(mistake);
    std::array<double, 16> values{};
    if (const std::optional<ModelRequest> edited = EditRequest(mistake, set, request))
        values = EvaluateModel(set, *edited, mistake);
    if (mistake == Mistake::LegacyChannelScale) {
        for (std::size_t c = 0; c < 16; ++c)
            values[c] = RoundToBinary32(values[c] * static_cast<double>(set.legacyScales[c]) +
                                        static_cast<double>(set.legacyBiases[c]));
    }
    for (std::size_t c = 0; request.linear && c < 16; ++c)
        values[c] = ConvertWithMistake(mistake, set, c, values[c]);
    std::array<float, 16> outputs{};
    for (std::size_t c = 0; c < 16; ++c)
        values[c] = RoundToBinary32(values[c]);
    EditOutputs(mistake, set, request.math, values);
    for (std::size_t c = 0; c < 16; ++c)
        outputs[c] = static_cast<float>(values[c]);
    return outputs;
}

void Model::KeepFrom(const Model& before, Mistake mistake) {
    const ModelSet& old = *before.set_;
    ModelSet& set = *set_;
    if (old.highSlots != set.highSlots || old.images.size() != set.images.size() ||
        old.mips.size() != set.mips.size() || old.width != set.width || old.height != set.height)
        return;
    for (std::size_t layer = 0; layer < 4 && old.int8 && set.int8; ++layer) {
        ModelLayer& now = (*set.int8)[layer];
        const ModelLayer& then = (*old.int8)[layer];
        if (mistake == Mistake::KeptWeights)
            now.weights = then.weights;
        if (mistake == Mistake::KeptScales)
            now.scales = then.scales;
        if (mistake == Mistake::KeptBiases)
            now.biases = then.biases;
    }
    if (mistake == Mistake::KeptLatents) {
        set.images = old.images;
        set.file = old.file;
    }
    for (std::size_t n = 0; n < set.images.size(); ++n) {
        for (ModelGrid ModelImage::*grid : {&ModelImage::high, &ModelImage::low}) {
            ModelGrid& now = set.images[n].*grid;
            const ModelGrid& then = old.images[n].*grid;
            if (mistake == Mistake::KeptBitWidths)
                now.bits = then.bits;
            if (mistake == Mistake::KeptFeatures)
                now.features = now.stride = then.features;
            if (mistake == Mistake::KeptSizes) {
                now.width = then.width;
                now.height = then.height;
            }
            now.rowBits = Index(now.width) * Index(now.stride) * Index(now.bits);
        }
    }
    for (std::size_t m = 0; m < set.mips.size(); ++m) {
        if (mistake == Mistake::KeptLods) {
            set.mips[m].lod = old.mips[m].lod;
            set.mips[m].scale = old.mips[m].scale;
        }
        if (mistake == Mistake::KeptImages)
            set.mips[m].image = old.mips[m].image;
    }
    if (mistake == Mistake::KeptColorSpaces)
        set.colorSpaces = old.colorSpaces;
}

double ConvertToLinear(double stored, ColorSpace colorSpace) {
    if (colorSpace == ColorSpace::sRGB)
        return stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4);
    if (colorSpace == ColorSpace::HLG) {
        const double h = std::fabs(stored);
        const double e = h < 0.5 ? 4 * h * h : std::exp((h - 0.55991073) / 0.17883277) + 0.28466892;
        return stored < 0 ? -e : e;
    }
    return stored;
}

} // namespace openntc::conformance
