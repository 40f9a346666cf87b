// SPDX-License-Identifier: MIT
// Stability: stable
// The JSON document of a texture set as plain structs: what the file says, before any of it is believed.
// Optional members are absent keys; defaults of absent keys are already applied to plain members. One set of
// structs serves all generations of files (schemaVersion); members that a generation does not have keep their
// defaults, and Schema.h says which those are.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/format/Enums.h"
#include "openntc/format/Limits.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

inline constexpr std::uint32_t kSignature = 0x5845544Eu; ///< "NTEX"
inline constexpr std::uint32_t kContainerVersion = 0x100u;
inline constexpr std::uint32_t kMinSchemaVersion = 1; ///< LibNTC 0.5 – 0.7.x; 2 is 0.8
inline constexpr std::uint32_t kMaxSchemaVersion = 3; ///< LibNTC 0.9
inline constexpr std::uint64_t kHeaderBytes = 40;
inline constexpr std::uint64_t kMaxJsonBytes = 16u << 20; ///< larger JSON chunks are refused
inline constexpr std::size_t kMaxJsonDepth = 64;          ///< deeper nesting is refused

// Longer arrays are refused, by the reader and by the writer: these two beside kMaxChannels, kMaxMips,
// kMaxNeuralMips, kMaxTextures and kNetworkLayers. They are far above what any writer makes and bound the
// memory that a hostile file can ask for.
inline constexpr std::size_t kMaxMlpVersions = 16;
inline constexpr std::size_t kMaxViews = 65536;

/// Element type of a weight, scale or bias vector.
enum class MlpDataType : std::uint8_t { Int8, Int32, FloatE4M3, FloatE5M2, Float16, Float32 };
enum class MlpActivation : std::uint8_t { HGELUClamp };
enum class MatrixLayout : std::uint8_t { RowMajor, ColumnMajor };
enum class Compression : std::uint8_t {
    None,
    GDeflate,           ///< generation 3, see GDeflate.h
    Uncompressed = None ///< for where X11 defines None
};

struct LatentShapeRecord {
    std::uint32_t highResFeatures = 0; ///< generation 1, as the next three
    std::uint32_t highResQuantBits = 0;
    std::uint32_t lowResFeatures = 0;
    std::uint32_t lowResQuantBits = 0;
    std::uint32_t numFeatures = 0; ///< generations 2 and 3
};

struct MlpLayer {
    std::uint32_t inputChannels = 0;
    std::uint32_t outputChannels = 0;
    std::uint32_t weightView = 0;
    std::optional<std::uint32_t> scaleView;
    std::uint32_t biasView = 0;
    std::optional<MlpDataType> weightType;
    std::optional<MlpDataType> scaleBiasType; ///< legacy (0.5.x)
    std::optional<MlpDataType> scaleType;
    std::optional<MlpDataType> biasType;
};

struct Mlp {
    Array<MlpLayer> layers;
    std::optional<MlpActivation> activation;
    std::optional<MatrixLayout> weightLayout;
    std::optional<MlpDataType> weightType;    ///< legacy default for layers
    std::optional<MlpDataType> scaleBiasType; ///< legacy default for layers
};

/// Where the modes and partitions of a mip's BC7 blocks are stored (generation 3).
struct BcModeBufferRecord {
    std::uint32_t mipLevel = 0;
    std::uint32_t view = 0;
};

struct TextureRecord {
    Text name;
    std::uint32_t firstChannel = 0;
    std::uint32_t numChannels = 0;
    std::optional<ChannelFormat> channelFormat; ///< absent: UNORM8; LibNTC always writes it
    ColorSpace rgbColorSpace = ColorSpace::Linear;
    ColorSpace alphaColorSpace = ColorSpace::Linear;
    BlockCompressedFormat bcFormat = BlockCompressedFormat::None;
    std::uint32_t bcQuality = 255;                       ///< generations 1 and 2
    std::optional<std::uint32_t> bcAccelerationDataView; ///< generations 1 and 2
    Array<BcModeBufferRecord> bcModeBuffers;             ///< generation 3
};

struct ChannelRecord {
    std::optional<float> scale; ///< legacy (0.5.0): already folded into the network, kept only for display
    std::optional<float> bias;
    ColorSpace colorSpace = ColorSpace::Linear;
};

/// One view for each layer of a latent mip. A list of bounded length that needs no memory.
struct LayerViews {
    std::array<std::uint32_t, kMaxLatentLayers> views{};
    std::uint32_t count = 0;
};

/// Two grids (generation 1), or layers of one size (generations 2 and 3).
struct LatentImageRecord {
    std::uint32_t highResWidth = 0; ///< generation 1, as the next seven
    std::uint32_t highResHeight = 0;
    std::uint32_t lowResWidth = 0;
    std::uint32_t lowResHeight = 0;
    std::uint32_t highResBitsPerPixel = 0;
    std::uint32_t lowResBitsPerPixel = 0;
    std::uint32_t highResView = 0;
    std::uint32_t lowResView = 0;
    std::uint32_t width = 0; ///< generations 2 and 3
    std::uint32_t height = 0;
    std::uint32_t arraySize = 0; ///< generation 2: layers in `view`
    std::uint32_t view = 0;
    LayerViews layerViews{}; ///< generation 3
};

/// `combinedColorData` and `perTextureColorData` of a colour mip are syntax-checked and dropped: no reader
/// uses them.
struct ColorMipRecord {
    std::optional<std::uint32_t> width;
    std::optional<std::uint32_t> height;
    std::optional<std::uint32_t> latentMip;
    std::optional<float> positionLod;
    std::optional<float> positionScale;
};

struct BufferView {
    std::uint64_t offset = 0; ///< from the start of the binary chunk, multiple of 4
    std::uint64_t storedSize = 0;
    std::optional<Compression> compression;
    std::optional<std::uint64_t> uncompressedSize;
    std::optional<std::uint32_t> crc32; ///< of compressed views, uncompressed; absent or 0: not checked
};

struct Document {
    std::uint32_t schemaVersion = kMinSchemaVersion; ///< the generation
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t numChannels = 0;
    std::uint32_t numColorMips = 1;
    std::optional<LatentShapeRecord> latentShape;
    std::optional<Mlp> mlp; ///< generation 1
    Array<Mlp> mlpVersions;
    Array<TextureRecord> textures;
    Array<ChannelRecord> channels;
    Array<LatentImageRecord> latents;
    Array<ColorMipRecord> colorMips;
    Array<BufferView> views;
};

/// A parsed file: the document, and where the binary chunk lies in the stream. Made by ReadContainer.
struct Container {
    Document document;
    std::uint64_t binaryOffset = 0; ///< absolute, in the stream
    std::uint64_t binarySize = 0;   ///< [binaryOffset, binaryOffset + binarySize) lies inside the stream
    std::uint64_t streamSize = 0;
};

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
