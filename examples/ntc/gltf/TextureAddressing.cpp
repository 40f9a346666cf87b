// SPDX-License-Identifier: MIT
#include "gltf/TextureAddressing.h"

#include "Output.h"

namespace openntc::tool {

namespace {

constexpr int kRepeat = 10497, kLinear = 9729, kLinearMipmapLinear = 9987;

TextureSampler Complete(TextureSampler sampler) {
    sampler.wrapS = sampler.wrapS == 0 ? kRepeat : sampler.wrapS;
    sampler.wrapT = sampler.wrapT == 0 ? kRepeat : sampler.wrapT;
    sampler.magFilter = sampler.magFilter == 0 ? kLinear : sampler.magFilter;
    sampler.minFilter = sampler.minFilter == 0 ? kLinearMipmapLinear : sampler.minFilter;
    return sampler;
}

std::string Describe(const TextureTransform& t) {
    return Format("offset %g %g, rotation %g, scale %g %g", t.offset[0], t.offset[1], t.rotation, t.scale[0],
                  t.scale[1]);
}

void WriteFilter(JsonWriter& json, const char* key, int filter) {
    json.Key(key);
    filter == 0 ? json.Null() : json.Value(FindSamplerName(filter));
}

} // namespace

const char* FindSamplerName(int number) {
    switch (number) {
    case kRepeat:
        return "REPEAT";
    case 33071:
        return "CLAMP_TO_EDGE";
    case 33648:
        return "MIRRORED_REPEAT";
    case 9728:
        return "NEAREST";
    case kLinear:
        return "LINEAR";
    case 9984:
        return "NEAREST_MIPMAP_NEAREST";
    case 9985:
        return "LINEAR_MIPMAP_NEAREST";
    case 9986:
        return "NEAREST_MIPMAP_LINEAR";
    case kLinearMipmapLinear:
        return "LINEAR_MIPMAP_LINEAR";
    default:
        return nullptr;
    }
}

std::string DescribeDifference(const TextureAddressing& texture, const TextureAddressing& first) {
    std::string text;
    const auto add = [&](const std::string& difference) { text += (text.empty() ? "" : ", ") + difference; };
    if (texture.texCoord != first.texCoord)
        add(Format("texCoord %d instead of %d", texture.texCoord, first.texCoord));
    const TextureSampler own = Complete(texture.sampler), other = Complete(first.sampler);
    const auto compare = [&](const char* name, int value, int otherValue) {
        if (value != otherValue)
            add(Format("%s %s instead of %s", name, FindSamplerName(value), FindSamplerName(otherValue)));
    };
    compare("wrapS", own.wrapS, other.wrapS);
    compare("wrapT", own.wrapT, other.wrapT);
    compare("magFilter", own.magFilter, other.magFilter);
    compare("minFilter", own.minFilter, other.minFilter);
    if (texture.transform != first.transform)
        add("transform " + Describe(texture.transform) + " instead of " + Describe(first.transform));
    if (texture.animation != first.animation)
        add(texture.animation.empty() ? "no animation of the transform" : "an animation of the transform");
    return text;
}

void WriteAddressing(JsonWriter& json, const TextureAddressing& addressing) {
    const TextureSampler sampler = Complete(addressing.sampler);
    json.Member("texCoord", addressing.texCoord);
    json.Key("sampler");
    json.BeginObject();
    json.Member("wrapS", FindSamplerName(sampler.wrapS));
    json.Member("wrapT", FindSamplerName(sampler.wrapT));
    WriteFilter(json, "magFilter", addressing.sampler.magFilter);
    WriteFilter(json, "minFilter", addressing.sampler.minFilter);
    json.EndObject();
    const TextureTransform& transform = addressing.transform;
    if (transform == TextureTransform{} && addressing.animation.empty())
        return;
    json.Key("transform");
    json.BeginObject();
    json.Key("offset");
    json.BeginArray();
    json.Value(transform.offset[0]);
    json.Value(transform.offset[1]);
    json.EndArray();
    json.Member("rotation", transform.rotation);
    json.Key("scale");
    json.BeginArray();
    json.Value(transform.scale[0]);
    json.Value(transform.scale[1]);
    json.EndArray();
    json.Member("animated", !addressing.animation.empty());
    json.EndObject();
}

} // namespace openntc::tool
