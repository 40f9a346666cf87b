// SPDX-License-Identifier: MIT
// DDS and KTX2 files of one two-dimensional texture with its mips.
#pragma once

#include "textures/TextureFormat.h"

#include "openntc/core/FileStream.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

enum class TextureContainer : std::uint8_t { Dds, Ktx2 };

struct TextureFileDesc {
    TextureContainer container = TextureContainer::Dds;
    TextureFormat format;
    std::uint32_t width = 1; ///< texels of the largest level, 1 … 2^20
    std::uint32_t height = 1;
    std::uint32_t levels =
        1;             ///< 1 … 21; a level's sides are half of the one before, rounded down, at least 1
    int zstdLevel = 0; ///< KTX2: 1 … 22 compresses each level with Zstandard; 0: as it is
};

struct TextureFileLevel {
    std::uint32_t width = 0; ///< texels
    std::uint32_t height = 0;
    std::uint64_t offset = 0; ///< bytes from the start of the file; 0 where Zstandard decides
    std::uint64_t bytes = 0;  ///< before Zstandard
};

/// Where everything is.
struct TextureFileLayout {
    std::uint64_t headerBytes = 0;        ///< all that comes before the first level
    std::vector<TextureFileLevel> levels; ///< largest first, wherever they lie
    std::uint64_t fileBytes = 0;          ///< 0 where Zstandard decides
};

/// In 64 bits, whatever the machine.
TextureFileLayout LayOutTextureFile(const TextureFileDesc& desc);

/// False in builds without libzstd.
bool IsZstdAvailable();

/// Writes one file to `path`, under another name until Finish; errors name `subject`. Levels come from the smallest to
/// the largest, which is how KTX2 stores them. Throws CommandError(Failed).
class TextureFileWriter {
public:
    TextureFileWriter(const std::filesystem::path& path, std::string subject, const TextureFileDesc& desc);
    ~TextureFileWriter();
    TextureFileWriter(const TextureFileWriter&) = delete;
    TextureFileWriter& operator=(const TextureFileWriter&) = delete;

    const TextureFileLayout& GetLayout() const { return layout_; }

    void BeginLevel(std::uint32_t level);
    /// The next texels or blocks of the level, row by row.
    void Write(std::span<const std::byte> bytes);
    void EndLevel();

    /// After the largest level. Without it there is no file. Returns the file's bytes.
    std::uint64_t Finish();

private:
    struct Zstd;

    [[noreturn]] void Throw(const std::string& text) const;
    void WriteBytes(std::span<const std::byte> bytes);
    void Compress(std::span<const std::byte> bytes, bool isEnd);

    std::string subject_;
    TextureFileDesc desc_;
    TextureFileLayout layout_;
    FileWriter file_;
    std::unique_ptr<Zstd> zstd_;
    std::vector<std::uint64_t> storedBytes_; // of each level
    std::uint32_t level_;                    // the one being written, or the last one written
    std::uint64_t levelBytes_ = 0;           // of it, before Zstandard
    std::uint64_t position_ = 0;
};

} // namespace openntc::tool
