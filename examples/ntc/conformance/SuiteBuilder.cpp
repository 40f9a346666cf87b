// SPDX-License-Identifier: MIT
#include "SuiteBuilder.h"

#include "openntc/core/Stream.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace openntc::conformance {

SynthesisDesc Describe(std::uint32_t seed, int width, int height, int mips, const LatentShape& shape,
                       int networkVersion) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {width, height, 16, mips};
    synthesis.shape = shape;
    synthesis.networkVersion = networkVersion;
    return synthesis;
}

void SuiteBuilder::AddSet(const std::string& name, std::vector<std::byte> bytes) {
    suite_.sets.push_back({name + ".ntc", std::move(bytes)});
    Load(suite_.sets.size() - 1);
}

void SuiteBuilder::SelectSet(const std::string& name) {
    const auto found = std::find_if(suite_.sets.begin(), suite_.sets.end(),
                                    [&](const Suite::Set& set) { return set.file == name + ".ntc"; });
    if (found == suite_.sets.end())
        throw std::runtime_error(name + ": no such set");
    Load(static_cast<std::size_t>(found - suite_.sets.begin()));
}

void SuiteBuilder::Load(std::size_t set) {
    set_ = set;
    ReadOnlyMemoryStream stream(suite_.sets[set].bytes);
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    if (!metadata)
        throw std::runtime_error(suite_.sets[set].file + ": " + metadata.error().GetText());
    metadata_ = std::move(*metadata);
}

std::vector<tool::Texel> SuiteBuilder::ListTexels(int firstMip, int lastMip, int stride) const {
    std::vector<tool::Texel> texels;
    int index = 0;
    for (int mip = firstMip; mip <= lastMip; ++mip) {
        const ColorMip& size = metadata_->GetColorMips()[static_cast<std::size_t>(mip)];
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                if (index++ % stride == 0 || (x + 1 == size.width && y + 1 == size.height))
                    texels.push_back({mip, x, y});
            }
        }
    }
    return texels;
}

std::vector<tool::Texel> SuiteBuilder::ListFewTexels(int count) const {
    std::vector<tool::Texel> texels;
    for (int mip = 0; mip < metadata_->GetDesc().mips; ++mip) {
        const ColorMip& size = metadata_->GetColorMips()[static_cast<std::size_t>(mip)];
        const int right = size.width - 1;
        const int bottom = size.height - 1;
        std::vector<tool::Texel> some = {
            {mip, 0, 0}, {mip, right, bottom}, {mip, right, 0}, {mip, 0, bottom}};
        for (int i = 0; static_cast<int>(some.size()) < count; ++i) // spread, borders in turn
            some.push_back({mip, i % 5 == 1 ? right : (i * 97 + 31) % size.width,
                            i % 5 == 3 ? bottom : (i * 61 + 17) % size.height});
        for (const tool::Texel& texel : some) {
            const bool isKnown = std::any_of(texels.begin(), texels.end(), [&](const tool::Texel& other) {
                return other.mip == mip && other.x == texel.x && other.y == texel.y;
            });
            if (!isKnown)
                texels.push_back(texel);
        }
    }
    return texels;
}

void SuiteBuilder::MakeOptional(std::size_t first) {
    for (std::size_t i = first; i < suite_.cases.size(); ++i)
        suite_.cases[i].mustPass = false;
}

SuiteCase& SuiteBuilder::AddCase(const std::string& name, DecodeMath math, std::vector<tool::Texel> texels,
                                 const std::string& about) {
    SuiteCase suiteCase;
    suiteCase.name = name;
    suiteCase.set = suite_.sets[set_].file;
    suiteCase.values = name + ".values";
    suiteCase.math = math;
    suiteCase.mustPass = math == DecodeMath::Int8 || math == DecodeMath::Int8Half;
    suiteCase.about = about;
    suite_.cases.push_back(suiteCase);
    suite_.texels.push_back(std::move(texels));
    return suite_.cases.back();
}

// True if a decoder with the mistake fails at the texel. Bounds of conversion to linear are below a thousandth; `isFine`
// looks at them themselves.
bool SuiteBuilder::IsChanged(const Model& model, const ModelRequest& request, Mistake mistake,
                             bool isFine) const {
    const Outputs right = model.Decode(request);
    const Outputs wrong = model.Decode(request, mistake);
    Outputs stored{};
    if (isFine) {
        ModelRequest storedRequest = request;
        storedRequest.linear = false;
        stored = model.Decode(storedRequest);
    }
    for (std::size_t c = 0; c < 16; ++c) {
        if (IsSame(right[c], wrong[c], 0))
            continue;
        const double change = GetDistance(right[c], wrong[c]);
        double bound =
            request.linear ? 1e-3 * std::max(1.0, std::fabs(static_cast<double>(right[c]))) : 1e-30;
        if (isFine && static_cast<int>(c) < metadata_->GetDesc().channels)
            bound = 4 * GetLinearBound(metadata_->GetChannelStorageColorSpace(static_cast<int>(c)), stored[c],
                                       Arithmetic::Vulkan);
        if (change > bound)
            return true;
    }
    return false;
}

SuiteCase& SuiteBuilder::AddMistakeCase(std::initializer_list<Mistake> mistakes, DecodeMath math,
                                        const std::string& about, bool linear, std::size_t count) {
    return AddChanged(mistakes, math, about, linear, false, count);
}

SuiteCase& SuiteBuilder::AddCurveCase(std::initializer_list<Mistake> mistakes, DecodeMath math,
                                      const std::string& about) {
    return AddChanged(mistakes, math, about, true, true, 16);
}

SuiteCase& SuiteBuilder::AddChanged(std::initializer_list<Mistake> mistakes, DecodeMath math,
                                    const std::string& about, bool linear, bool isFine, std::size_t count) {
    const Model model(suite_.sets[set_].bytes);
    const std::vector<tool::Texel> all = ListAllTexels();
    std::size_t step = 7; // spreads the choice over the image
    while (std::gcd(step, all.size()) != 1)
        ++step;
    std::vector<tool::Texel> chosen;
    const auto find = [&](Mistake mistake) {
        const auto list = ListMistakes();
        return std::find_if(list.begin(), list.end(),
                            [&](const MistakeInfo& info) { return info.mistake == mistake; });
    };
    for (const Mistake mistake : mistakes) {
        std::size_t found = 0;
        for (std::size_t i = 0; i < all.size() && found < count; ++i) {
            const tool::Texel& texel = all[i * step % all.size()];
            if (!IsChanged(model, {math, linear, texel.mip, texel.x, texel.y}, mistake, isFine))
                continue;
            ++found;
            const bool isKnown = std::any_of(chosen.begin(), chosen.end(), [&](const tool::Texel& other) {
                return other.mip == texel.mip && other.x == texel.x && other.y == texel.y;
            });
            if (!isKnown)
                chosen.push_back(texel);
        }
        if (found == 0)
            throw std::runtime_error(std::string(find(mistake)->name) + ": changes no texel of the set " +
                                     suite_.sets[set_].file);
    }
    SuiteCase& added = AddCase(find(*mistakes.begin())->caseName, math, std::move(chosen), about);
    added.linear = linear;
    return added;
}

void SuiteBuilder::AddHardwareCase(const std::string& name, std::vector<tool::Texel> texels,
                                   const std::string& about) {
    SuiteCase& suiteCase = AddCase(name, DecodeMath::FP8, std::move(texels), about);
    suiteCase.interval = true;
    suiteCase.mustPass = true;
}

SuiteCase& SuiteBuilder::AddWholeMip(const std::string& name, DecodeMath math, int mip,
                                     std::vector<tool::Texel> texels, const std::string& about) {
    std::erase_if(texels, [&](const tool::Texel& texel) { return texel.mip != mip; });
    SuiteCase& suiteCase = AddCase(name, math, std::move(texels), about);
    suiteCase.wholeMip = true;
    return suiteCase;
}

SuiteCase& SuiteBuilder::AddSlice(const std::string& name, DecodeMath math, int mip, const Rect& slice,
                                  const std::string& about) {
    SuiteCase& suiteCase = AddSliceMips(name, math, mip, 1, slice, about);
    suiteCase.sliceMip = -1;
    return suiteCase;
}

SuiteCase& SuiteBuilder::AddSliceMips(const std::string& name, DecodeMath math, int firstMip, int mips,
                                      const Rect& slice, const std::string& about) {
    std::vector<tool::Texel> texels;
    for (int level = 0; level < mips; ++level) {
        const ColorMip& size = metadata_->GetColorMips()[static_cast<std::size_t>(firstMip + level)];
        const Rect part = GetSlicePart(slice, level, size.width, size.height);
        for (int y = part.top; y < part.top + part.height; ++y) {
            for (int x = part.left; x < part.left + part.width; ++x)
                texels.push_back({firstMip + level, x, y});
        }
    }
    SuiteCase& suiteCase = AddCase(name, math, std::move(texels), about);
    suiteCase.slice = slice;
    suiteCase.sliceMip = firstMip;
    suiteCase.sliceMips = mips;
    return suiteCase;
}

} // namespace openntc::conformance
