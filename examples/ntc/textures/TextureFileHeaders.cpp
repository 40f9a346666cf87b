// SPDX-License-Identifier: MIT
#include "textures/TextureFileHeaders.h"

#include "Output.h"

#include "openntc/openntc.h"

#include <string>
#include <string_view>
#include <utility>

namespace openntc::tool {

namespace {

/// Little-endian numbers one after the other.
class ByteList {
public:
    void Add32(std::uint32_t value) {
        for (int i = 0; i < 4; ++i)
            bytes_.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xFFU));
    }
    void Add64(std::uint64_t value) {
        Add32(static_cast<std::uint32_t>(value));
        Add32(static_cast<std::uint32_t>(value >> 32));
    }
    void AddText(std::string_view text) {
        for (const char c : text)
            bytes_.push_back(static_cast<std::byte>(c));
    }
    void Pad(std::size_t alignment) {
        while (bytes_.size() % alignment != 0)
            bytes_.push_back(std::byte{0});
    }
    std::size_t GetSize() const { return bytes_.size(); }
    std::vector<std::byte> Take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

constexpr std::uint64_t kDdsHeaderBytes = 4 + 124 + 20;

// Khronos Data Format Specification 1.3, sections 5.6 and 5.12: colour models, qualifiers of samples.
constexpr std::uint32_t kModelRgbsda = 1;
constexpr std::uint32_t kModelBc1 = 128; // BC2 … BC7 follow
constexpr std::uint32_t kQualifierLinear = 0x10, kQualifierSigned = 0x40, kQualifierFloat = 0x80;
constexpr std::uint32_t kChannelAlpha = 15;

struct DescriptorSample {
    std::uint32_t offset, bits, channel, lower, upper;
};

constexpr std::uint32_t kMinusOne = 0xBF800000U, kOne = 0x3F800000U; // binary32

/// DescriptorSample lower and upper of `bits` bits: what stands for 0 or -1, and for 1.
DescriptorSample MakeSample(TexelNumber number, std::uint32_t offset, std::uint32_t bits,
                            std::uint32_t channel) {
    const std::uint32_t most = bits >= 32 ? 0xFFFFFFFFU : (1U << bits) - 1;
    switch (number) {
    case TexelNumber::Half:
    case TexelNumber::Float:
        return {offset, bits, channel | kQualifierFloat | kQualifierSigned, kMinusOne, kOne};
    case TexelNumber::Snorm8:
        return {offset, bits, channel | kQualifierSigned, 0x80000000U, 0x7FFFFFFFU};
    case TexelNumber::Unorm8:
    case TexelNumber::Unorm16:
        break;
    }
    return {offset, bits, channel, 0, most};
}

std::vector<DescriptorSample> MakeBlockSamples(const TextureFormat& format) {
    using bc::BlockFormat;
    const TexelNumber number = format.number;
    switch (*format.block) {
    case BlockFormat::Bc1:
        return {MakeSample(number, 0, 64, format.hasAlpha ? 1 : 0)};
    case BlockFormat::Bc2:
    case BlockFormat::Bc3: // alpha is linear in sRGB formats
        return {MakeSample(number, 0, 64, kChannelAlpha | (format.srgb ? kQualifierLinear : 0)),
                MakeSample(number, 64, 64, 0)};
    case BlockFormat::Bc4Unsigned:
    case BlockFormat::Bc4Signed:
        return {MakeSample(number, 0, 64, 0)};
    case BlockFormat::Bc5Unsigned:
    case BlockFormat::Bc5Signed:
        return {MakeSample(number, 0, 64, 0), MakeSample(number, 64, 64, 1)};
    case BlockFormat::Bc6Unsigned:
        return {{0, 128, kQualifierFloat, 0, kOne}};
    case BlockFormat::Bc6Signed:
        return {{0, 128, kQualifierFloat | kQualifierSigned, kMinusOne, kOne}};
    case BlockFormat::Bc7:
        break;
    }
    return {MakeSample(number, 0, 128, 0)};
}

std::vector<DescriptorSample> MakeTexelSamples(const TextureFormat& format) {
    std::vector<DescriptorSample> samples;
    const auto bits = static_cast<std::uint32_t>(8 * GetNumberBytes(format.number));
    for (std::uint32_t c = 0; c < static_cast<std::uint32_t>(format.channels); ++c) {
        const std::uint32_t channel = c == 3 ? kChannelAlpha | (format.srgb ? kQualifierLinear : 0) : c;
        samples.push_back(MakeSample(format.number, bits * c, bits, channel));
    }
    return samples;
}

std::uint32_t GetColorModel(const TextureFormat& format) {
    using bc::BlockFormat;
    if (!format.block)
        return kModelRgbsda;
    switch (*format.block) {
    case BlockFormat::Bc1:
        return kModelBc1;
    case BlockFormat::Bc2:
        return kModelBc1 + 1;
    case BlockFormat::Bc3:
        return kModelBc1 + 2;
    case BlockFormat::Bc4Unsigned:
    case BlockFormat::Bc4Signed:
        return kModelBc1 + 3;
    case BlockFormat::Bc5Unsigned:
    case BlockFormat::Bc5Signed:
        return kModelBc1 + 4;
    case BlockFormat::Bc6Unsigned:
    case BlockFormat::Bc6Signed:
        return kModelBc1 + 5;
    case BlockFormat::Bc7:
        break;
    }
    return kModelBc1 + 6;
}

std::vector<std::byte> MakeKeyValueData() {
    const std::string writer =
        Format("OpenNTC %d.%d.%d", OPENNTC_VERSION_MAJOR, OPENNTC_VERSION_MINOR, OPENNTC_VERSION_PATCH);
    // In the order of their keys, as KTX 2.0 wants; values end in a zero.
    const std::pair<std::string_view, std::string_view> pairs[] = {{"KTXorientation", "rd"},
                                                                   {"KTXwriter", writer}};
    ByteList list;
    for (const auto& [key, value] : pairs) {
        list.Add32(static_cast<std::uint32_t>(key.size() + 1 + value.size() + 1));
        list.AddText(key);
        list.AddText({"\0", 1});
        list.AddText(value);
        list.AddText({"\0", 1});
        list.Pad(4);
    }
    return list.Take();
}

} // namespace

std::uint64_t GetDdsHeaderBytes() {
    return kDdsHeaderBytes;
}

std::vector<std::byte> MakeDdsHeader(const TextureFileDesc& desc) {
    // DDS_HEADER and DDS_HEADER_DXT10 of Microsoft's "Programming Guide for DDS".
    constexpr std::uint32_t kCaps = 0x1, kHeight = 0x2, kWidth = 0x4, kPitch = 0x8, kPixelFormat = 0x1000,
                            kMipMapCount = 0x20000, kLinearSize = 0x80000;
    constexpr std::uint32_t kCapsComplex = 0x8, kCapsTexture = 0x1000, kCapsMipMap = 0x400000;
    constexpr std::uint32_t kFourCc = 0x4, kDimensionTexture2D = 3, kAlphaStraight = 1, kAlphaOpaque = 3;
    const TextureFileLayout layout = LayOutTextureFile(desc);
    const std::uint64_t size =
        desc.format.block ? layout.levels[0].bytes : std::uint64_t{desc.width} * GetUnitBytes(desc.format);
    ByteList list;
    list.AddText("DDS ");
    list.Add32(124);
    list.Add32(kCaps | kHeight | kWidth | kPixelFormat | kMipMapCount |
               (desc.format.block ? kLinearSize : kPitch));
    list.Add32(desc.height);
    list.Add32(desc.width);
    list.Add32(size <= 0xFFFFFFFFU ? static_cast<std::uint32_t>(size)
                                   : 0); // informational: readers compute it
    list.Add32(0);                       // depth
    list.Add32(desc.levels);
    for (int i = 0; i < 11; ++i)
        list.Add32(0);
    list.Add32(32);
    list.Add32(kFourCc);
    list.AddText("DX10");
    for (int i = 0; i < 5; ++i)
        list.Add32(0); // bits and masks of formats without a FourCC
    list.Add32(kCapsTexture | (desc.levels > 1 ? kCapsComplex | kCapsMipMap : 0));
    for (int i = 0; i < 4; ++i)
        list.Add32(0);
    list.Add32(GetDxgiFormat(desc.format));
    list.Add32(kDimensionTexture2D);
    list.Add32(0); // no cube
    list.Add32(1); // array size
    list.Add32(desc.format.hasAlpha ? kAlphaStraight : kAlphaOpaque);
    return list.Take();
}

std::vector<std::uint32_t> MakeDataFormatDescriptor(const TextureFormat& format) {
    constexpr std::uint32_t kVersion = 2, kPrimariesBt709 = 1, kTransferLinear = 1, kTransferSrgb = 2;
    const std::vector<DescriptorSample> samples =
        format.block ? MakeBlockSamples(format) : MakeTexelSamples(format);
    const auto blockBytes = static_cast<std::uint32_t>(24 + 16 * samples.size());
    const std::uint32_t side = GetUnitTexels(format) - 1;
    std::vector<std::uint32_t> words = {
        4 + blockBytes,
        0, // Khronos, basic descriptor
        kVersion | blockBytes << 16,
        GetColorModel(format) | kPrimariesBt709 << 8 | (format.srgb ? kTransferSrgb : kTransferLinear) << 16,
        side | side << 8,
        GetUnitBytes(format), // Zstandard or not: KTX 2.0 revision of 2025 keeps it
        0,
    };
    for (const DescriptorSample& sample : samples) {
        words.push_back(sample.offset | (sample.bits - 1) << 16 | sample.channel << 24);
        words.push_back(0); // position
        words.push_back(sample.lower);
        words.push_back(sample.upper);
    }
    return words;
}

std::uint64_t GetKtx2HeaderBytes(const TextureFileDesc& desc) {
    return 80 + std::uint64_t{24} * desc.levels + 4 * MakeDataFormatDescriptor(desc.format).size() +
           MakeKeyValueData().size();
}

std::vector<std::byte> MakeKtx2Header(const TextureFileDesc& desc, const TextureFileLayout& layout,
                                      std::span<const std::uint64_t> storedBytes) {
    constexpr std::uint32_t kZstandard = 2;
    const std::vector<std::uint32_t> descriptor = MakeDataFormatDescriptor(desc.format);
    const std::vector<std::byte> pairs = MakeKeyValueData();
    const auto indexEnd = static_cast<std::uint32_t>(80 + 24 * desc.levels);
    const auto descriptorBytes = static_cast<std::uint32_t>(4 * descriptor.size());
    ByteList list;
    list.AddText({"\xABKTX 20\xBB\r\n\x1A\n", 12});
    list.Add32(GetVulkanFormat(desc.format));
    list.Add32(desc.format.block ? 1 : static_cast<std::uint32_t>(GetNumberBytes(desc.format.number)));
    list.Add32(desc.width);
    list.Add32(desc.height);
    list.Add32(0); // no depth
    list.Add32(0); // no array
    list.Add32(1); // face
    list.Add32(desc.levels);
    list.Add32(desc.zstdLevel != 0 ? kZstandard : 0);
    list.Add32(indexEnd);
    list.Add32(descriptorBytes);
    list.Add32(indexEnd + descriptorBytes);
    list.Add32(static_cast<std::uint32_t>(pairs.size()));
    list.Add64(0); // no supercompression global data
    list.Add64(0);
    for (std::size_t i = 0; i < layout.levels.size(); ++i) {
        list.Add64(layout.levels[i].offset);
        list.Add64(storedBytes[i]);
        list.Add64(layout.levels[i].bytes);
    }
    for (const std::uint32_t word : descriptor)
        list.Add32(word);
    std::vector<std::byte> bytes = list.Take();
    bytes.insert(bytes.end(), pairs.begin(), pairs.end());
    return bytes;
}

} // namespace openntc::tool
