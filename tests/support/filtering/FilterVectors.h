// SPDX-License-Identifier: MIT
// The vectors of filtering (conformance/filtering/stf-vectors.json) as items, with the words they must give.
#pragma once

#include "FilterCases.h"
#include "support/Files.h"

#include <rapidjson/document.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace openntc_tests {

using FilterItem = openntc::FilterItem;

/// An item and what is known of its result: words by their place.
struct FilterVector {
    std::string name;
    FilterItem item{};
    std::vector<std::pair<std::size_t, std::uint32_t>> words;
    std::vector<std::pair<std::size_t, double>> fractions; ///< weights as parts of their sum
    int sign = 0;                                          ///< of the scale in word 4; 0: unknown
};

inline FilterItem MakeFilterItem(std::uint32_t kind) {
    FilterItem item{};
    item.kind = kind;
    item.width = item.height = item.levels = 1;
    item.maxAnisotropy = item.taps = 1;
    item.radius = 2;
    item.sigma = std::bit_cast<std::uint32_t>(0.6f);
    return item;
}

/// What the C++ build makes of an item.
inline std::vector<std::uint32_t> RunFilter(const FilterItem& item) {
    std::uint32_t words[FILTER_WORDS];
    openntc::shader::RunFilterItem(item, words);
    return {words, words + FILTER_WORDS};
}

namespace detail {

inline std::uint32_t ReadBits(const rapidjson::Value& text) {
    return static_cast<std::uint32_t>(std::stoul(text.GetString(), nullptr, 16));
}

inline std::uint32_t ReadWrap(const rapidjson::Value& text) {
    const std::string mode = text.GetString();
    return mode == "wrap"
               ? NTC_WRAP_REPEAT
               : (mode == "clamp" ? NTC_WRAP_CLAMP : (mode == "mirror" ? NTC_WRAP_MIRROR : NTC_WRAP_BORDER));
}

inline std::uint32_t ReadTexel(const rapidjson::Value& texel) {
    return texel.IsNull() ? 0xFFFFFFFFu : static_cast<std::uint32_t>(texel.GetInt());
}

inline void AddNumbers(const rapidjson::Document& document, std::vector<FilterVector>& vectors) {
    for (const auto& row : document["hash"]["pcg"].GetArray()) {
        FilterVector vector{"pcg", MakeFilterItem(FILTER_PCG), {{0, row[1].GetUint()}}, {}, 0};
        vector.item.r0 = row[0].GetUint();
        vectors.push_back(vector);
    }
    for (const auto& [name, first, count] : {std::tuple{"pcg3d", 1u, 3u}, std::tuple{"pcg4d", 4u, 4u}}) {
        for (const auto& row : document["hash"][name].GetArray()) {
            FilterVector vector{name, MakeFilterItem(FILTER_PCG), {}, {}, 0};
            std::uint32_t* const to[] = {&vector.item.r0, &vector.item.r1, &vector.item.r2, &vector.item.r3};
            for (rapidjson::SizeType i = 0; i < count; ++i) {
                *to[i] = row[0][i].GetUint();
                vector.words.push_back({first + i, row[1][i].GetUint()});
            }
            vectors.push_back(vector);
        }
    }
    for (const auto& row : document["stretch"].GetArray()) {
        FilterVector vector{"stretch", MakeFilterItem(FILTER_STRETCH), {}, {}, 0};
        vector.item.r0 = row[0].GetUint();
        vector.item.r1 = row[1].GetUint();
        vector.words = {{0, row[2].GetUint()}, {1, row[3].GetUint()}};
        vectors.push_back(vector);
    }
    for (const auto& row : document["log2"].GetArray()) {
        FilterVector vector{"log2", MakeFilterItem(FILTER_LOG2), {}, {}, 0};
        vector.item.u = ReadBits(row[0]);
        vector.words = {{0, static_cast<std::uint32_t>(row[1].GetInt())}};
        vectors.push_back(vector);
    }
    for (const auto& row : document["coord"].GetArray()) {
        FilterVector vector{"coord", MakeFilterItem(FILTER_COORD), {}, {}, 0};
        vector.item.u = ReadBits(row[0]);
        vector.item.width = row[1].GetInt();
        vector.item.wrapX = ReadWrap(row[2]);
        for (rapidjson::SizeType i = 0; i < 4; ++i) {
            vector.words.push_back({i, static_cast<std::uint32_t>(row[3 + i].GetInt())});
            vector.words.push_back({4 + i, ReadTexel(row[7][i])});
        }
        vectors.push_back(vector);
    }
}

/// A footprint's level is brought inside the mips; a bias of 100 mips and 300 of them show it as it was.
inline void AddFootprints(const rapidjson::Document& document, std::vector<FilterVector>& vectors) {
    const std::int32_t bias = 100 * 65536;
    for (const auto& row : document["lod"].GetArray()) {
        FilterVector vector{"lod, isotropic", MakeFilterItem(FILTER_FOOTPRINT), {}, {}, 0};
        FilterItem& item = vector.item;
        std::uint32_t* const to[] = {&item.dudx, &item.dvdx, &item.dudy, &item.dvdy};
        for (rapidjson::SizeType i = 0; i < 4; ++i)
            *to[i] = ReadBits(row[0][i]);
        item.width = row[1].GetInt();
        item.height = row[2].GetInt();
        item.levels = 300;
        item.lodBias = bias;
        const bool alongX = row[7].GetInt() == 0;
        vector.words = {{0, static_cast<std::uint32_t>(row[4].GetInt() + bias)},
                        {1, 1},
                        {2, alongX ? item.dudx : item.dudy},
                        {3, alongX ? item.dvdx : item.dvdy}};
        vectors.push_back(vector);
        vector.name = "lod, anisotropic";
        item.maxAnisotropy = row[3].GetUint();
        vector.words[0].second = static_cast<std::uint32_t>(row[5].GetInt() + bias);
        vector.words[1].second = row[6].GetUint();
        vectors.push_back(vector);
    }
}

inline void ReadFilter(const std::string& filter, const rapidjson::Value& row, FilterItem& item) {
    item.kernel = filter == "nearest"       ? NTC_KERNEL_NEAREST
                  : filter == "cubic"       ? NTC_KERNEL_CUBIC
                  : filter == "catmull-rom" ? NTC_KERNEL_CATMULL_ROM
                  : filter == "mitchell"    ? NTC_KERNEL_MITCHELL
                  : filter == "gaussian"    ? NTC_KERNEL_GAUSSIAN
                                            : NTC_KERNEL_BILINEAR;
    item.mips = filter == "nearest" || filter == "bilinear" ? NTC_MIPS_NEAREST : NTC_MIPS_LINEAR;
    item.u = ReadBits(row["uv"][0]);
    item.v = ReadBits(row["uv"][1]);
    item.width = row["size"][0].GetInt();
    item.height = row["size"][1].GetInt();
    item.levels = row["size"][2].GetInt();
    item.wrapX = ReadWrap(row["mode"][0]);
    item.wrapY = ReadWrap(row["mode"][1]);
    item.lod = row["lod"].GetInt();
    item.r0 = row["r"][0].GetUint();
    item.r1 = row["r"][1].GetUint();
    item.r2 = row["r"][2].GetUint();
    item.r3 = row["r"][3].GetUint();
    if (row.HasMember("sigma")) {
        item.sigma = std::bit_cast<std::uint32_t>(static_cast<float>(row["sigma"].GetDouble()));
        item.radius = row["radius"].GetInt();
    }
    if (row.HasMember("axis")) {
        item.axisX = ReadBits(row["axis"][0]);
        item.axisY = ReadBits(row["axis"][1]);
        item.taps = row["taps"].GetUint();
    }
}

/// The texel that is drawn.
inline FilterVector MakePick(const std::string& filter, const rapidjson::Value& row, const FilterItem& item) {
    FilterVector pick{filter + ", pick", item, {}, {}, 0};
    pick.item.kind = FILTER_SAMPLE;
    bool isBorder = false;
    for (rapidjson::SizeType i = 0; i < 2; ++i) {
        isBorder |= row["pick"][i].IsNull();
        pick.words.push_back({i, ReadTexel(row["pick"][i])});
    }
    pick.words.push_back({2, row["pick"][2].GetUint()});
    pick.words.push_back({3, isBorder ? 1u : 0u});
    if (row.HasMember("sign")) {
        pick.sign = row["sign"].GetInt();
        pick.words.push_back({8, row["norm"][0].GetUint()});
        pick.words.push_back({9, row["norm"][1].GetUint()});
    } else {
        pick.words.push_back({4, std::bit_cast<std::uint32_t>(1.0f)});
    }
    if (row.HasMember("index")) {
        pick.words.push_back({5, row["index"].GetUint()});
        pick.words.push_back({6, ReadBits(row["position"][0])});
        pick.words.push_back({7, ReadBits(row["position"][1])});
    }
    return pick;
}

/// Taps and weights of a part of the lookup, as a row of `mips` has them from `first` on.
inline FilterVector MakePart(const std::string& filter, const rapidjson::Value& mip, const FilterItem& item,
                             std::uint32_t index, rapidjson::SizeType first) {
    FilterVector part{filter + ", part " + std::to_string(index), item, {}, {}, 0};
    part.item.kind = FILTER_PART;
    part.item.index = index;
    part.words.push_back({0, mip[first].GetUint()});
    const float share = static_cast<float>(mip[first + 1].GetUint()) / 65536.0f;
    const float weight = share * (1.0f / static_cast<float>(item.taps)); // both exact, or rounded once
    part.words.push_back({1, std::bit_cast<std::uint32_t>(weight)});
    for (rapidjson::SizeType axis = 0; axis < 2; ++axis) {
        const auto& texels = mip[first + 2 + 2 * axis];
        const auto& weights = mip[first + 3 + 2 * axis];
        const std::size_t at = 4 + 16 * axis;
        for (rapidjson::SizeType k = 0; k < 8; ++k) {
            const bool isTap = k < texels.Size();
            part.words.push_back({at + k, isTap ? ReadTexel(texels[k]) : 0});
            if (filter == "gaussian")
                part.fractions.push_back({at + 8 + k, isTap ? weights[k].GetDouble() : 0.0});
            else
                part.words.push_back(
                    {at + 8 + k, isTap ? static_cast<std::uint32_t>(weights[k].GetInt()) : 0});
        }
    }
    return part;
}

} // namespace detail

/// All vectors; none without the file.
inline std::vector<FilterVector> ReadFilterVectors() {
    std::vector<FilterVector> vectors;
    const std::vector<std::byte> bytes = ReadBytes(GetConformanceFolder() / "filtering" / "stf-vectors.json");
    rapidjson::Document document;
    document.Parse(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (bytes.empty() || document.HasParseError())
        return vectors;
    detail::AddNumbers(document, vectors);
    detail::AddFootprints(document, vectors);
    for (const char* const name : {"nearest", "bilinear", "trilinear", "cubic", "catmull-rom", "mitchell",
                                   "gaussian", "anisotropic"}) {
        const std::string filter = name;
        for (const auto& row : document["filters"][name].GetArray()) {
            FilterItem item = MakeFilterItem(FILTER_SAMPLE);
            detail::ReadFilter(filter, row, item);
            vectors.push_back(detail::MakePick(filter, row, item));
            const bool isAnisotropic = filter == "anisotropic";
            std::uint32_t index = 0;
            for (const auto& mip : row["mips"].GetArray())
                vectors.push_back(detail::MakePart(filter, mip, item, index++, isAnisotropic ? 1 : 0));
        }
    }
    return vectors;
}

/// How many words of a result are not what a vector says. Weights of a Gaussian are compared as fractions of
/// their sum, within 4e-6: exp() in binary32 and eight roundings to 2^-24, and the vectors' nine digits.
inline int CountDifferences(const FilterVector& vector, const std::uint32_t* words) {
    int different = 0;
    for (const auto& [place, expected] : vector.words)
        different += words[place] != expected ? 1 : 0;
    if (vector.sign != 0)
        different += (std::bit_cast<float>(words[4]) < 0) != (vector.sign < 0) ? 1 : 0;
    for (const auto& [place, expected] : vector.fractions) {
        const std::size_t group = place < 20 ? 12 : 28;
        double sum = 0;
        for (std::size_t k = 0; k < 8; ++k)
            sum += words[group + k];
        different += std::fabs(words[place] / sum - expected) > 4e-6 ? 1 : 0;
    }
    return different;
}

} // namespace openntc_tests
