// SPDX-License-Identifier: MIT
#include "FilterSuite.h"

#include "../Json.h"
#include "../Output.h"
#include "Protocol.h"
#include "SuiteEntry.h"

#include "openntc/StochasticFiltering.h" // and GLM

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <random>
#include <tuple>

namespace openntc::conformance {

namespace {

constexpr const char* kWays[] = {"one", "pair", "all"};
constexpr const char* kKernels[] = {"nearest", "bilinear", "cubic", "catmull_rom", "mitchell", "gaussian"};
constexpr const char* kMipFilters[] = {"nearest", "linear"};
constexpr const char* kWraps[] = {"repeat", "clamp", "mirror", "border"};
static_assert(NTC_KERNEL_CATMULL_ROM == 3 && NTC_KERNEL_GAUSSIAN == 5 && NTC_MIPS_LINEAR == 1);
static_assert(NTC_WRAP_REPEAT == 0 && NTC_WRAP_CLAMP == 1 && NTC_WRAP_MIRROR == 2 && NTC_WRAP_BORDER == 3);

template <std::size_t count>
int FindWord(const char* const (&words)[count], std::string_view word) {
    const auto found = std::find(std::begin(words), std::end(words), word);
    return found == std::end(words) ? -1 : static_cast<int>(found - std::begin(words));
}

FilterSuiteCase ReadFilterCase(SuiteEntry& entry) {
    FilterSuiteCase filterCase;
    FilterRequest& request = filterCase.request;
    filterCase.name = entry.TakeText("name");
    filterCase.lookups = entry.TakeFileName("lookups");
    filterCase.about = entry.TakeText("about");
    filterCase.mustPass = entry.TakeFlag("mustPass");
    const auto take = [&](const char* key, int (*find)(std::string_view)) {
        const int number = find(entry.TakeText(key));
        if (number < 0)
            entry.Refuse(key);
        return std::max(number, 0);
    };
    request.way = static_cast<FilterWay>(take("way", FindFilterWay));
    request.kernel = take("kernel", FindKernel);
    request.mips = take("mips", FindMips);
    request.wrapX = take("wrapX", FindWrap);
    request.wrapY = take("wrapY", FindWrap);
    request.sigma = static_cast<float>(entry.TakeNumber("sigma", 512, 1382)) / 1024.0f;
    request.radius = entry.TakeNumber("radius", 2, 4);
    request.maxAnisotropy = entry.TakeNumber("maxAnisotropy", 1, 16);
    request.lodBias = entry.TakeNumber("lodBias", -(1 << 20), 1 << 20);
    request.width = entry.TakeNumber("width", 1, 16384);
    request.height = entry.TakeNumber("height", 1, 16384);
    request.levels = entry.TakeNumber("levels", 1, 15);
    return filterCase;
}

class FilterLister {
public:
    FilterSuiteCase& Add(const char* name, FilterWay way, int kernel, int mips, const char* about) {
        FilterSuiteCase filterCase;
        filterCase.name = std::string("filtering-") + name;
        filterCase.lookups = filterCase.name + ".lookups";
        filterCase.request.way = way;
        filterCase.request.kernel = kernel;
        filterCase.request.mips = mips;
        filterCase.request.width = 52;
        filterCase.request.height = 39;
        filterCase.request.levels = 6;
        filterCase.mustPass = true;
        filterCase.about = about;
        cases_.push_back(filterCase);
        return cases_.back();
    }
    FilterSuiteCase& AddWrapped(const char* name, FilterWay way, int kernel, int wrapX, int wrapY,
                                const char* about) {
        FilterSuiteCase& filterCase = Add(name, way, kernel, NTC_MIPS_LINEAR, about);
        filterCase.request.wrapX = wrapX;
        filterCase.request.wrapY = wrapY;
        return filterCase;
    }
    std::vector<FilterSuiteCase> Take() { return std::move(cases_); }

private:
    std::vector<FilterSuiteCase> cases_;
};

/// Whether the numbers next to it, two steps of 2^-16 either way, draw the same texel: a Gaussian's weights
/// are off by exp's 3 ULP and more, some 30 of 2^-24 in all, where such a step is 256 of them.
bool HasMargin(const FilterRequest& request, const FilterLookup& lookup) {
    std::vector<FilterLookup> all(5, lookup);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const std::uint32_t number = lookup.random[axis];
        if (number < 2 || number > 65533)
            return false;
        all[1 + 2 * axis].random[axis] = number - 2;
        all[2 + 2 * axis].random[axis] = number + 2;
    }
    const FilterTaps taps = RunFilter(request, all);
    return std::all_of(taps.begin(), taps.end(), [&](const std::vector<FilterTap>& one) {
        return CompareFilterTaps(request, {one}, {taps[0]}).different == 0;
    });
}

bool IsChanged(const FilterRequest& request, const FilterLookup& lookup, FilterMistake mistake) {
    const std::vector<FilterLookup> one = {lookup};
    return CompareFilterTaps(request, RunFilter(request, one, mistake), RunFilter(request, one)).different !=
           0;
}

FilterLookup MakeLookup(std::mt19937& random, const FilterRequest& request, std::size_t index) {
    const auto unit = [&] { return static_cast<float>(random() >> 8) / 16777216.0f; };
    FilterLookup lookup;
    for (float& coordinate : lookup.uv)
        coordinate = index % 4 == 3 ? 5.0f * unit() - 2.0f : unit();
    // A footprint of 1/2 to 16 texels, some of them long.
    const float size = std::exp2(5.0f * unit() - 1.0f) / static_cast<float>(request.width);
    const float angle = 6.2831853f * unit(), length = request.maxAnisotropy > 1 ? 6.0f * unit() + 1.0f : 1.0f;
    lookup.ddx = {size * std::cos(angle), size * std::sin(angle)};
    lookup.ddy = {-size * length * std::sin(angle), size * length * std::cos(angle)};
    for (std::uint32_t& number : lookup.random)
        number = static_cast<std::uint32_t>(random()) >> 16;
    // Sines of one C library are not those of another: numbers that all have.
    for (std::array<float, 2>* pair : {&lookup.ddx, &lookup.ddy}) {
        for (float& derivative : *pair)
            derivative = std::round(derivative * 16384.0f) / 16384.0f;
    }
    return lookup;
}

/// Coordinates and derivatives at which floats change.
std::vector<FilterLookup> MakeEdges() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kNumbers[] = {0.0f, -0.0f, 1.0f,   -1.0f,       0.5f,   -kInfinity,  kInfinity,
                                  kNan, 64.0f, -64.5f, 16777216.0f, 1e-38f, 0.99999994f, 2.0f};
    std::vector<FilterLookup> lookups;
    for (std::size_t i = 0; i < std::size(kNumbers); ++i) {
        const auto number = [&](std::size_t n) { return kNumbers[n % std::size(kNumbers)]; };
        FilterLookup lookup;
        lookup.uv = {number(i), number(5 * i + 3)};
        lookup.ddx = {i % 2 == 0 ? number(3 * i + 1) : 0.03f, 0.0f};
        lookup.ddy = {0.0f, i % 3 == 0 ? number(i + 7) : 0.01f};
        for (std::size_t k = 0; k < 4; ++k)
            lookup.random[k] = static_cast<std::uint32_t>(i * 21845 + k * 32768) & 0xFFFFu;
        lookups.push_back(lookup);
    }
    return lookups;
}

} // namespace

const char* GetFilterWayWord(FilterWay way) {
    return kWays[static_cast<std::size_t>(way)];
}
const char* GetKernelWord(int kernel) {
    return kKernels[kernel];
}
const char* GetMipsWord(int mips) {
    return kMipFilters[mips];
}
const char* GetWrapWord(int wrap) {
    return kWraps[wrap];
}
int FindFilterWay(std::string_view word) {
    return FindWord(kWays, word);
}
int FindKernel(std::string_view word) {
    return FindWord(kKernels, word);
}
int FindMips(std::string_view word) {
    return FindWord(kMipFilters, word);
}
int FindWrap(std::string_view word) {
    return FindWord(kWraps, word);
}

bool FilterRequest::IsGaussian() const {
    return kernel == NTC_KERNEL_GAUSSIAN;
}

bool FilterRequest::IsValid() const {
    const auto isIn = [](int number, int least, int most) { return number >= least && number <= most; };
    return isIn(kernel, 0, NTC_KERNEL_GAUSSIAN) && isIn(mips, 0, 1) && isIn(wrapX, 0, 3) &&
           isIn(wrapY, 0, 3) && sigma >= 0.5f && sigma <= 1.35f && isIn(radius, 2, 4) &&
           isIn(maxAnisotropy, 1, 16) && isIn(lodBias, -(1 << 20), 1 << 20) && isIn(width, 1, 16384) &&
           isIn(height, 1, 16384) && isIn(levels, 1, 15);
}

Expected<std::vector<FilterSuiteCase>> ReadFilterCases(std::span<const std::byte> json) {
    return ReadCaseList<FilterSuiteCase>(json, "filtering", ReadFilterCase);
}

void WriteFilterCases(tool::JsonWriter& json, std::span<const FilterSuiteCase> cases) {
    json.Key("filtering");
    json.BeginArray();
    for (const FilterSuiteCase& filterCase : cases) {
        const FilterRequest& request = filterCase.request;
        json.BeginObject();
        json.Member("name", std::string_view(filterCase.name));
        json.Member("lookups", std::string_view(filterCase.lookups));
        json.Member("way", GetFilterWayWord(request.way));
        json.Member("kernel", GetKernelWord(request.kernel));
        json.Member("mips", GetMipsWord(request.mips));
        json.Member("wrapX", GetWrapWord(request.wrapX));
        json.Member("wrapY", GetWrapWord(request.wrapY));
        json.Member("sigma", static_cast<int>(std::lround(1024.0f * request.sigma)));
        json.Member("radius", request.radius);
        json.Member("maxAnisotropy", request.maxAnisotropy);
        json.Member("lodBias", request.lodBias);
        json.Member("width", request.width);
        json.Member("height", request.height);
        json.Member("levels", request.levels);
        json.Member("mustPass", filterCase.mustPass);
        json.Member("about", std::string_view(filterCase.about));
        json.EndObject();
    }
    json.EndArray();
}

std::vector<FilterSuiteCase> ListFilterSuite() {
    FilterLister list;
    using enum FilterWay;
    list.Add("nearest", One, NTC_KERNEL_NEAREST, NTC_MIPS_NEAREST, "texel and mip that are nearest");
    list.Add("bilinear", One, NTC_KERNEL_BILINEAR, NTC_MIPS_NEAREST, "one of four texels of the nearest mip");
    list.AddWrapped("trilinear", One, NTC_KERNEL_BILINEAR, NTC_WRAP_CLAMP, NTC_WRAP_REPEAT,
                    "one of eight texels; coordinates that are clamped and that repeat");
    list.AddWrapped("mirror-border", One, NTC_KERNEL_BILINEAR, NTC_WRAP_MIRROR, NTC_WRAP_BORDER,
                    "coordinates that are mirrored, and outside");
    list.AddWrapped("cubic", One, NTC_KERNEL_CUBIC, NTC_WRAP_MIRROR, NTC_WRAP_CLAMP, "one of 32 texels");
    list.AddWrapped("catmull-rom", One, NTC_KERNEL_CATMULL_ROM, NTC_WRAP_REPEAT, NTC_WRAP_CLAMP,
                    "one texel, with the sign of its weight");
    list.AddWrapped("catmull-rom-pair", Pair, NTC_KERNEL_CATMULL_ROM, NTC_WRAP_CLAMP, NTC_WRAP_CLAMP,
                    "a texel of the positive weights and one of the negative");
    list.AddWrapped("mitchell-pair", Pair, NTC_KERNEL_MITCHELL, NTC_WRAP_REPEAT, NTC_WRAP_MIRROR,
                    "a texel of the positive weights and one of the negative");
    list.AddWrapped("precise", One, NTC_KERNEL_BILINEAR, NTC_WRAP_CLAMP, NTC_WRAP_CLAMP,
                    "random numbers whose low bits decide");
    list.AddWrapped("gaussian", One, NTC_KERNEL_GAUSSIAN, NTC_WRAP_REPEAT, NTC_WRAP_REPEAT,
                    "one of the texels, away from where a device's exp decides")
        .request.sigma = 0.75f;
    list.AddWrapped("anisotropic", One, NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT, NTC_WRAP_REPEAT,
                    "one tap of up to eight along the longer axis")
        .request.maxAnisotropy = 8;
    FilterRequest& level = list.AddWrapped("level", One, NTC_KERNEL_NEAREST, NTC_WRAP_CLAMP, NTC_WRAP_CLAMP,
                                           "derivatives of a texture that is not square, and a bias")
                               .request;
    level.height = 9;
    level.levels = 4;
    level.lodBias = 45000;
    FilterRequest& thin = list.AddWrapped("thin", One, NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT, NTC_WRAP_MIRROR,
                                          "mips of one texel a side")
                              .request;
    thin.width = 1;
    thin.height = 5;
    thin.levels = 3;
    list.AddWrapped("edges", One, NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT, NTC_WRAP_CLAMP,
                    "coordinates and derivatives that are 0, huge, infinite, NaN");
    list.AddWrapped("all-trilinear", All, NTC_KERNEL_BILINEAR, NTC_WRAP_BORDER, NTC_WRAP_REPEAT,
                    "eight texels and their weights");
    list.AddWrapped("all-cubic", All, NTC_KERNEL_CUBIC, NTC_WRAP_CLAMP, NTC_WRAP_MIRROR,
                    "32 texels and their weights")
        .request.mips = NTC_MIPS_NEAREST;
    list.AddWrapped("all-catmull-rom", All, NTC_KERNEL_CATMULL_ROM, NTC_WRAP_MIRROR, NTC_WRAP_REPEAT,
                    "weights of which some are negative")
        .request.mips = NTC_MIPS_NEAREST;
    list.AddWrapped("all-mitchell", All, NTC_KERNEL_MITCHELL, NTC_WRAP_REPEAT, NTC_WRAP_BORDER,
                    "weights of which some are negative")
        .request.mips = NTC_MIPS_NEAREST;
    list.AddWrapped("all-gaussian", All, NTC_KERNEL_GAUSSIAN, NTC_WRAP_CLAMP, NTC_WRAP_REPEAT,
                    "weights within 1e-5")
        .request.sigma = 0.625f;
    list.AddWrapped("all-anisotropic", All, NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT, NTC_WRAP_CLAMP,
                    "the texels of up to four taps and their weights")
        .request.maxAnisotropy = 4;
    return list.Take();
}

std::vector<FilterLookup> MakeFilterLookups(const FilterSuiteCase& filterCase) {
    const FilterRequest& request = filterCase.request;
    if (filterCase.name == "filtering-edges")
        return MakeEdges();
    std::vector<FilterMistake> mistakes; // that are to be found by this case
    for (const FilterMistakeInfo& info : ListFilterMistakes()) {
        if (filterCase.name == info.caseName)
            mistakes.push_back(info.mistake);
    }
    std::mt19937 random(static_cast<std::uint32_t>(filterCase.name.size() * 131) +
                        static_cast<std::uint32_t>(filterCase.name.back()));
    const std::size_t count = request.way != FilterWay::All ? 20 : request.maxAnisotropy > 1 ? 2 : 4;
    constexpr std::size_t kTries = 4096;
    std::vector<FilterLookup> lookups;
    for (std::size_t tried = 0; lookups.size() < count; ++tried) {
        const FilterLookup lookup = MakeLookup(random, request, tried);
        if (request.IsGaussian() && request.way != FilterWay::All && !HasMargin(request, lookup))
            continue;
        // Every lookup but some at the end is one that a mistake changes, each in its turn.
        const std::size_t turn = lookups.size();
        if (!mistakes.empty() && turn < count - count / 4 && tried < kTries &&
            !IsChanged(request, lookup, mistakes[turn % mistakes.size()]))
            continue;
        lookups.push_back(lookup);
    }
    return lookups;
}

} // namespace openntc::conformance
