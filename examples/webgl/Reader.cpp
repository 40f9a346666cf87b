// SPDX-License-Identifier: MIT
// The reader of the C++ library as WebAssembly, without JavaScript of a toolchain: what src/reader.js calls. One texture set at a
// time; pointers are valid until the next OpenSet or ReserveFile.
#include <openntc/core/Stream.h>
#include <openntc/inference/InferenceData.h>
#include <openntc/inference/ReadLatents.h>
#include <openntc/texture_set/TextureSetMetadata.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

namespace {

using namespace openntc;

/// 32-bit words throughout: JavaScript reads them as an Int32Array, in this order.
struct SetWords {
    std::int32_t width, height, channels, mips, generation, network, textures;
    std::uint32_t constants, constantsBytes, weights, weightsBytes, latents, latentsBytes;
};
struct TextureWords {
    std::uint32_t name, nameBytes;
    std::int32_t firstChannel, channels, channelFormat, rgbColorSpace, alphaColorSpace, blockFormat;
};

struct LoadedSet {
    TextureSetMetadata metadata;
    NtcTextureSetConstants constants;
    Array<std::byte> latents;
    Array<TextureWords> textures;
    SetWords words{};
};

Array<std::byte> file;
std::optional<LoadedSet> loaded;
char message[Error::kMaxMessageBytes];

std::uint32_t Address(const void* pointer) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(pointer));
}

Expected<Array<TextureWords>> DescribeTextures(const TextureSetMetadata& metadata) {
    Array<TextureWords> all;
    for (const Texture& texture : metadata.GetTextures()) {
        const TextureWords words{Address(texture.name.data()),
                                 static_cast<std::uint32_t>(texture.name.size()),
                                 texture.firstChannel,
                                 texture.numChannels,
                                 static_cast<std::int32_t>(texture.channelFormat),
                                 static_cast<std::int32_t>(texture.rgbColorSpace),
                                 static_cast<std::int32_t>(texture.alphaColorSpace),
                                 static_cast<std::int32_t>(texture.bcFormat)};
        OPENNTC_CHECK(all.Append(std::span(&words, 1)));
    }
    return all;
}

Expected<void> Load() {
    ReadOnlyMemoryStream stream(file.AsSpan());
    OPENNTC_ASSIGN(TextureSetMetadata metadata, TextureSetMetadata::Load(stream));
    const TextureSetDesc desc = metadata.GetDesc();
    const auto type = InferenceWeightType::GenericInt8;
    OPENNTC_ASSIGN(const NtcTextureSetConstants constants, MakeInferenceData(metadata, 0, desc.mips, type));
    OPENNTC_ASSIGN(const std::size_t bytes, GetLatentBufferBytes(metadata, 0, desc.mips));
    Array<std::byte> latents;
    OPENNTC_CHECK(latents.Resize(bytes));
    OPENNTC_CHECK(ReadLatents(metadata, stream, 0, desc.mips, latents.AsSpan()));
    loaded.emplace(LoadedSet{std::move(metadata), constants, std::move(latents), {}});
    OPENNTC_ASSIGN(loaded->textures, DescribeTextures(loaded->metadata)); // views into where it is now
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, loaded->metadata.GetInferenceWeights(type));
    SetWords& words = loaded->words;
    words.width = desc.width;
    words.height = desc.height;
    words.channels = desc.channels;
    words.mips = desc.mips;
    words.generation = loaded->metadata.GetGeneration();
    words.network = loaded->metadata.GetNetworkVersion();
    words.textures = static_cast<std::int32_t>(loaded->textures.size());
    words.constants = Address(&loaded->constants);
    words.constantsBytes = sizeof(loaded->constants);
    words.weights = Address(weights.data());
    words.weightsBytes = static_cast<std::uint32_t>(weights.size());
    words.latents = Address(loaded->latents.data());
    words.latentsBytes = static_cast<std::uint32_t>(loaded->latents.size());
    return {};
}

} // namespace

#if defined(__wasm__)
#define EXPORT(name) extern "C" __attribute__((export_name(#name), used))
#else // for tools that read sources
#define EXPORT(name) extern "C"
#endif

/// Room for a file of `bytes` bytes; 0 where there is none.
EXPORT(ReserveFile) std::byte* ReserveFile(std::uint32_t bytes) {
    loaded.reset();
    file = Array<std::byte>();
    return file.Resize(bytes) ? file.data() : nullptr;
}

/// Checks and reads the file; null, or what is wrong with it, in the words of every other program that reads it.
EXPORT(OpenSet) const char* OpenSet() {
    const Expected<void> done = Load();
    if (done)
        return nullptr;
    loaded.reset();
    std::strcpy(message, done.error().GetText());
    return message;
}

EXPORT(GetSet) const SetWords* GetSet() {
    return loaded ? &loaded->words : nullptr;
}

EXPORT(GetTextures) const TextureWords* GetTextures() {
    return loaded ? loaded->textures.data() : nullptr;
}
