// SPDX-License-Identifier: MIT
#include "SuiteCoverage.h"

#include "ModelSet.h"
#include "RawFile.h"

#include "../Output.h"

#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <set>

namespace openntc::conformance {

namespace {

using tool::Format;

// What a set or case has, as texts: an item is covered if one of its cases has the text.
using Facts = std::set<std::string>;

void AddSizes(const ModelSet& set, Facts& facts) {
    facts.insert(Format("generation: %d", set.generation));
    if (set.generation > 1)
        return; // the factors below are those of generation 1
    for (const auto& [name, size] : {std::pair("width", set.width), std::pair("height", set.height)}) {
        facts.insert(Format("%s: %d", name, size));
        facts.insert(Format("%s: %s", name, size % 2 == 1 ? "odd" : "even"));
    }
    facts.insert(set.width > set.height ? "wide" : set.width < set.height ? "high" : "square");
    facts.insert(Format("channels: %d", set.channels));
    facts.insert(Format("mips: %zu", set.mips.size()));
    facts.insert(Format("latent images: %zu", set.images.size()));
    const ModelGrid& high = set.images.front().high;
    const ModelGrid& low = set.images.front().low;
    const int network = set.highSlots / 4;
    const std::pair<const char*, int> factors[] = {{"high features", high.features},
                                                   {"high bits", high.bits},
                                                   {"low features", low.features},
                                                   {"low bits", low.bits},
                                                   {"network", network}};
    for (std::size_t a = 0; a < std::size(factors); ++a) {
        for (std::size_t b = a + 1; b < std::size(factors); ++b)
            facts.insert(Format("%s %d with %s %d", factors[a].first, factors[a].second, factors[b].first,
                                factors[b].second));
    }
    const int scale = (set.width + high.width / 2) / high.width;
    facts.insert(
        Format("grid scale %d%s", scale, set.images.size() > 1 ? " with several latent images" : ""));
    for (const ModelImage& image : set.images) {
        for (const ModelGrid* grid : {&image.high, &image.low}) {
            const std::string name = grid == &image.high ? "high grid" : "low grid";
            facts.insert(Format("%s width: %d", name.c_str(), grid->width));
            facts.insert(Format("%s height: %d", name.c_str(), grid->height));
            if (grid->rowBits % 8 != 0)
                facts.insert(name + ": rows of broken bytes");
            if (grid->rowBits * Index(grid->height) > 8 * 65536)
                facts.insert(name + ": more than 65536 bytes");
            if (grid->width > set.width || grid->height > set.height)
                facts.insert(name + ": finer than the image");
            const std::size_t elements = Index(grid->width) * Index(grid->height) * Index(grid->features);
            for (std::size_t e = 0; e < std::min<std::size_t>(elements, 20000); ++e) {
                const std::size_t bit = e * Index(grid->bits);
                const int byte = std::to_integer<int>(set.file[grid->offset + bit / 8]);
                facts.insert(Format("%s code of %d bits: %d", name.c_str(), grid->bits,
                                    byte >> (bit % 8) & ((1 << grid->bits) - 1)));
            }
        }
    }
}

void AddNetworks(const ModelSet& set, Facts& facts) {
    for (std::size_t layer = 0; layer < 4; ++layer) {
        const auto add = [&](const char* what, const std::string& value) {
            facts.insert(Format("layer %zu %s: %s", layer, what, value.c_str()));
        };
        if (set.int8) {
            for (std::size_t i = 0; i < (*set.int8)[layer].weights.size(); ++i)
                add("weight", std::to_string((*set.int8)[layer].GetWeight(i)));
            for (const std::int32_t bias : (*set.int8)[layer].biases)
                add("bias", std::to_string(bias));
            for (const float scale : (*set.int8)[layer].scales) {
                add("scale", NameFloat(scale));
                add("scale", scale < 0 ? "negative" : "positive");
                if (std::fpclassify(scale) == FP_SUBNORMAL)
                    add("scale", "subnormal");
            }
        }
        if (set.fp8 && layer < 3) {
            for (const std::uint8_t code : (*set.fp8)[layer].weights)
                add("E4M3 weight", Format("%02x", code));
            for (const std::uint16_t bias : (*set.fp8)[layer].halfBiases)
                add("half bias", Format("%04x", bias));
        }
    }
}

// Members of the JSON text, and where chunks and views lie.
void AddForm(std::span<const std::byte> file, Facts& facts) {
    const RawFile raw(file);
    std::uint64_t header[5] = {};
    std::memcpy(header, file.data(),
                sizeof header); // signature and version, JSON offset and size, binary offset and size
    const std::uint64_t jsonEnd = header[1] + header[2];
    facts.insert(header[3] < header[1] ? "form: data before JSON" : "form: JSON before data");
    facts.insert(header[3] > (jsonEnd + 3) / 4 * 4 ? "form: gap between chunks"
                                                   : "form: no gap between chunks");
    facts.insert(file[static_cast<std::size_t>(jsonEnd) - 1] == std::byte{0} ? "form: NUL" : "form: no NUL");
    std::uint64_t end = 0;
    for (const rapidjson::Value& view : raw.json["views"].GetArray()) {
        const std::uint64_t offset = view["offset"].GetUint64();
        facts.insert(offset < end   ? "form: views out of order"
                     : offset > end ? "form: gap between views"
                                    : "");
        end = offset + (view["storedSize"].GetUint64() + 3) / 4 * 4;
    }
    const std::function<void(const std::string&, const rapidjson::Value&)> visit =
        [&](const std::string& path, const rapidjson::Value& value) {
            if (value.IsArray()) {
                for (const rapidjson::Value& element : value.GetArray())
                    visit(path, element);
            } else if (value.IsObject()) {
                for (const auto& member : value.GetObject()) {
                    const std::string inner = path + "/" + member.name.GetString();
                    facts.insert("has " + inner);
                    visit(inner, member.value);
                }
                for (const char* key :
                     {"mlp", "mlpVersions", "channels", "textures", "numColorMips", "scaleView",
                      "positionLod", "positionScale", "weightType", "activation", "width"}) {
                    if (!value.HasMember(key))
                        facts.insert("lacks " + path + "/" + key);
                }
            } else if (value.IsString()) {
                facts.insert(path + ": " + value.GetString());
            }
        };
    visit("", raw.json);
}

Facts MakeSetFacts(const ModelSet& set) {
    Facts facts;
    AddSizes(set, facts);
    AddNetworks(set, facts);
    AddForm(set.file, facts);
    int image = 0;
    for (const ModelMip& mip : set.mips) {
        if (mip.image < image)
            facts.insert("latent image before that of a finer mip");
        image = mip.image;
    }
    return facts;
}

const char* NameKind(const SuiteCase& suiteCase) {
    return suiteCase.outside         ? "outside"
           : suiteCase.wholeMip      ? "mip"
           : suiteCase.sliceMip >= 0 ? "slice_mips"
           : suiteCase.slice         ? "slice"
                                     : "texels";
}

Facts MakeCaseFacts(const Model& model, const SuiteCase& suiteCase, std::span<const tool::Texel> texels) {
    Facts facts;
    const ModelSet& set = model.GetSet();
    const std::string math = tool::GetName(suiteCase.math);
    facts.insert(Format("%s in network %d", math.c_str(), set.highSlots / 4));
    facts.insert(math + (suiteCase.linear ? " linear" : " stored"));
    facts.insert(math + " by " + NameKind(suiteCase));
    if (suiteCase.linear) {
        for (int c = 0; c < 16; ++c)
            facts.insert(c < set.channels
                             ? Format("channel %d in colour space %d, linear", c, set.colorSpaces[Index(c)])
                             : Format("channel %d undeclared, linear", c));
    }
    for (const tool::Texel& texel : texels) {
        const ModelMip& mip = set.mips[Index(texel.mip)];
        facts.insert(Format("mip: %d", texel.mip));
        facts.insert(Format("latent image: %d", mip.image));
        const float lod = mip.lod;
        facts.insert(lod < -1    ? "positionLod: below -1"
                     : lod < 0   ? "positionLod: negative"
                     : lod == 0  ? "positionLod: 0"
                     : lod < 1   ? "positionLod: 0 to 1"
                     : lod == 1  ? "positionLod: 1"
                     : lod < 448 ? "positionLod: above 1"
                                 : "positionLod: above 448");
        const float scale = mip.scale;
        facts.insert(scale < 0         ? "positionScale: negative"
                     : scale == 0      ? "positionScale: 0"
                     : scale < 1       ? "positionScale: below 1"
                     : scale == 1      ? "positionScale: 1"
                     : scale < 0x1p99f ? "positionScale: above 1"
                                       : "positionScale: 2^100");
        const auto place = [](int at, int size) {
            return at < 0           ? "before"
                   : at >= size     ? "beyond"
                   : size == 1      ? "only"
                   : at == 0        ? "first"
                   : at == size - 1 ? "last"
                                    : "inside";
        };
        facts.insert(
            Format("texel: column %s, row %s", place(texel.x, mip.width), place(texel.y, mip.height)));
        if (texel.x > 16000 || texel.y > 16000)
            facts.insert(texel.x > 16000 ? "texel: x above 16000" : "texel: y above 16000");
        ModelRequest request = suiteCase.MakeRequest(texel);
        for (const float value : model.Decode(request)) {
            if (!suiteCase.linear && (std::isinf(value) || value == 0 || std::fabs(value) == 65504 ||
                                      std::fabs(value) == std::numeric_limits<float>::max()))
                facts.insert(math + " output: " + NameFloat(value));
        }
    }
    return facts;
}

} // namespace

std::string NameFloat(float value) {
    return value == 0 ? (std::signbit(value) ? "-0" : "0") : tool::FormatFloat(value);
}

std::vector<CoverageItem> MeasureCoverage(const Suite& suite) {
    std::map<std::string, Facts> sets;
    std::map<std::string, Model> models;
    for (const Suite::Set& set : suite.sets) {
        const Model& model = models.emplace(set.file, Model(set.bytes)).first->second;
        sets.emplace(set.file, MakeSetFacts(model.GetSet()));
    }
    std::vector<CoverageItem> items;
    std::map<std::string, std::size_t> places;
    for (std::string& promise : ListPromises()) {
        places.emplace(promise, items.size());
        items.push_back({std::move(promise), {}});
    }
    for (std::size_t i = 0; i < suite.cases.size(); ++i) {
        const SuiteCase& suiteCase = suite.cases[i];
        Facts facts = MakeCaseFacts(models.at(suiteCase.set), suiteCase, suite.texels[i]);
        facts.insert(sets.at(suiteCase.set).begin(), sets.at(suiteCase.set).end());
        for (const std::string& fact : facts) {
            if (const auto place = places.find(fact); place != places.end())
                items[place->second].cases.push_back(suiteCase.name);
        }
    }
    return items;
}

std::string WriteCoverage(const std::vector<CoverageItem>& items) {
    std::string text;
    for (const CoverageItem& item : items) {
        text += item.what + ":";
        for (std::size_t i = 0; i < std::min<std::size_t>(3, item.cases.size()); ++i)
            text += " " + item.cases[i];
        text += item.cases.size() > 3 ? Format(" and %zu more\n", item.cases.size() - 3) : "\n";
    }
    return text;
}

} // namespace openntc::conformance
