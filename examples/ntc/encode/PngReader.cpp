// SPDX-License-Identifier: MIT
#include "encode/PngReader.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/core/Crc32.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <png.h>

namespace openntc::tool {

namespace {

constexpr std::size_t kSignatureBytes = 8;
constexpr std::uint8_t kSignature[kSignatureBytes] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

std::uint32_t ReadBigEndian(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = value << 8 | static_cast<std::uint32_t>(bytes[at + i]);
    return value;
}

/// The chunks of a file before libpng sees them: complete, checksums right, a size that may be allocated.
class ChunkChecker {
public:
    ChunkChecker(std::span<const std::byte> bytes, const std::string& subject, int maximumSide)
        : bytes_(bytes), subject_(subject), maximumSide_(maximumSide) {}

    void Check() const {
        std::size_t at = kSignatureBytes;
        for (std::string name; name != "IEND";) {
            if (bytes_.size() - at < kFrameBytes)
                Fail(at == kSignatureBytes ? "IHDR" : "IEND",
                     Format("missing: the file ends after %zu bytes", bytes_.size()));
            const std::size_t length = ReadBigEndian(bytes_, at);
            name.assign(reinterpret_cast<const char*>(bytes_.data() + at + 4), 4);
            if (at == kSignatureBytes && (name != "IHDR" || length != 13))
                Fail("IHDR", "missing: the first chunk must be of 13 bytes and this name");
            if (length > bytes_.size() - at - kFrameBytes)
                Fail(name, Format("%zu bytes at %zu: the file ends after %zu", length, at, bytes_.size()));
            const std::uint32_t stored = ReadBigEndian(bytes_, at + 8 + length);
            const std::uint32_t computed = Crc32(bytes_.subspan(at + 4, 4 + length));
            if (stored != computed)
                Fail(name, Format("checksum at byte %zu: CRC-32 %08X: the bytes have %08X", at + 8 + length,
                                  stored, computed));
            if (at == kSignatureBytes)
                CheckSize();
            at += kFrameBytes + length;
        }
    }

private:
    static constexpr std::size_t kFrameBytes = 12; // length, name, checksum

    [[noreturn]] void Fail(const std::string& chunk, const std::string& text) const {
        throw CommandError(ExitCode::BadInput, subject_, "image: " + chunk + ": " + text);
    }
    void CheckSize() const {
        const std::uint32_t width = ReadBigEndian(bytes_, 16), height = ReadBigEndian(bytes_, 20);
        const auto limit = static_cast<std::uint32_t>(maximumSide_);
        if (width < 1 || height < 1 || width > limit || height > limit)
            Fail("IHDR", Format("%u x %u: 1 to %u per side", width, height, limit));
    }

    std::span<const std::byte> bytes_;
    const std::string& subject_;
    int maximumSide_;
};

// libpng leaves through longjmp; the functions that call it hold no objects with destructors at that point.
class LibpngReader {
public:
    explicit LibpngReader(std::span<const std::byte> bytes) : bytes_(bytes) {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, HandleError, HandleWarning);
        if (png_ != nullptr)
            info_ = png_create_info_struct(png_);
    }
    ~LibpngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    LibpngReader(const LibpngReader&) = delete;
    LibpngReader& operator=(const LibpngReader&) = delete;

    /// Header and transformations; false with GetMessage().
    bool Begin(PngImage& image) {
        if (info_ == nullptr) {
            std::snprintf(message_, sizeof message_, "out of memory");
            return false;
        }
        if (setjmp(png_jmpbuf(png_)) != 0)
            return false;
        png_set_read_fn(png_, this, ReadBytes);
        png_read_info(png_, info_);
        png_set_expand(png_); // palettes, fewer than 8 bits, keyed transparency
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        image.width = static_cast<int>(png_get_image_width(png_, info_));
        image.height = static_cast<int>(png_get_image_height(png_, info_));
        image.channels = png_get_channels(png_, info_);
        image.bits = png_get_bit_depth(png_, info_);
        return true;
    }
    /// All rows, and what follows them.
    bool Read(png_bytepp rows) {
        if (setjmp(png_jmpbuf(png_)) != 0)
            return false;
        png_read_image(png_, rows);
        png_read_end(png_, nullptr);
        return !damaged_;
    }
    const char* GetMessage() const { return message_; }

private:
    static LibpngReader& Get(png_structp png) { return *static_cast<LibpngReader*>(png_get_error_ptr(png)); }

    /// zlib's words for a check value that differs.
    static bool IsChecksum(png_const_charp text) {
        return std::strncmp(text, "IDAT", 4) == 0 && std::strstr(text, "incorrect data check") != nullptr;
    }
    void Remember(png_const_charp text) {
        std::snprintf(message_, sizeof message_, "%s",
                      IsChecksum(text)
                          ? "IDAT: checksum of the texels: their Adler-32 differs from the stored one"
                          : text);
    }
    static void HandleError(png_structp png, png_const_charp text) {
        Get(png).Remember(text);
        png_longjmp(png, 1);
    }
    // Behind the last row a check value that differs is worth only a warning to libpng.
    static void HandleWarning(png_structp png, png_const_charp text) {
        if (!IsChecksum(text))
            return;
        Get(png).damaged_ = true;
        Get(png).Remember(text);
    }
    static void ReadBytes(png_structp png, png_bytep destination, png_size_t count) {
        auto& reader = *static_cast<LibpngReader*>(png_get_io_ptr(png));
        if (count > reader.bytes_.size() - reader.at_)
            png_error(png, "the file ends too early");
        std::memcpy(destination, reader.bytes_.data() + reader.at_, count);
        reader.at_ += count;
    }

    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
    bool damaged_ = false;
    char message_[160] = {};
};

} // namespace

bool IsPng(std::span<const std::byte> bytes) {
    return bytes.size() >= kSignatureBytes && std::memcmp(bytes.data(), kSignature, kSignatureBytes) == 0;
}

PngImage ReadPng(std::span<const std::byte> bytes, const std::string& subject, int maximumSide) {
    ChunkChecker(bytes, subject, maximumSide).Check();
    PngImage image;
    LibpngReader reader(bytes);
    const auto fail = [&] {
        const std::string size =
            image.width > 0 ? Format("%d x %d: ", image.width, image.height) : std::string();
        throw CommandError(ExitCode::BadInput, subject, "image: " + size + Printable(reader.GetMessage()));
    };
    if (!reader.Begin(image))
        fail();
    const std::size_t rowBytes = static_cast<std::size_t>(image.width) *
                                 static_cast<std::size_t>(image.channels) *
                                 static_cast<std::size_t>(image.bits / 8);
    image.samples.resize(rowBytes * static_cast<std::size_t>(image.height));
    std::vector<png_bytep> rows;
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
        rows.push_back(image.samples.data() + y * rowBytes);
    if (!reader.Read(rows.data()))
        fail();
    return image;
}

} // namespace openntc::tool
