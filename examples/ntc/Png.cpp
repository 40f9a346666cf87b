// SPDX-License-Identifier: MIT
#include "Png.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/core/FileCalls.h"

#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <vector>

#include <png.h>

namespace openntc::tool {

struct PngWriter::Impl {
    std::string subject;
    PngFormat format;
    std::FILE* file = nullptr;
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::vector<png_byte> row;

    ~Impl() {
        png_destroy_write_struct(&png, &info);
        if (file != nullptr)
            std::fclose(file);
    }

    [[noreturn]] void Throw(const std::string& text) const {
        throw CommandError(ExitCode::Failed, subject, text);
    }
    /// With the reason of the last call to the system.
    [[noreturn]] void ThrowSystem(const char* text) const {
        Throw(Format("PNG: %s: %s", text, SystemReason(errno).GetText()));
    }
};

namespace {

constexpr const char* kCannotWrite = "cannot be written";

// libpng leaves through longjmp; the functions that call it hold no objects with destructors at that point.
void HandleError(png_structp png, png_const_charp) {
    png_longjmp(png, 1);
}

void HandleWarning(png_structp, png_const_charp) {}

bool WriteHeader(png_structp png, png_infop info, std::FILE* file, const PngFormat& format) {
    if (setjmp(png_jmpbuf(png)) != 0)
        return false;
    png_init_io(png, file);
    const int colorType = format.channels == 1   ? PNG_COLOR_TYPE_GRAY
                          : format.channels == 3 ? PNG_COLOR_TYPE_RGB
                                                 : PNG_COLOR_TYPE_RGB_ALPHA;
    png_set_IHDR(png, info, static_cast<png_uint_32>(format.width), static_cast<png_uint_32>(format.height),
                 format.bits, colorType, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    return true;
}

bool WriteBytes(png_structp png, const png_byte* row) {
    if (setjmp(png_jmpbuf(png)) != 0)
        return false;
    png_write_row(png, row);
    return true;
}

bool WriteEnd(png_structp png, png_infop info) {
    if (setjmp(png_jmpbuf(png)) != 0)
        return false;
    png_write_end(png, info);
    return true;
}

} // namespace

PngWriter::PngWriter(const std::filesystem::path& path, const std::string& subject, const PngFormat& format)
    : impl_(std::make_unique<Impl>()) {
    impl_->subject = subject;
    impl_->format = format;
    const std::size_t sampleBytes = format.bits == 16 ? 2 : 1;
    impl_->row.resize(static_cast<std::size_t>(format.width) * static_cast<std::size_t>(format.channels) *
                      sampleBytes);
    impl_->file = std::fopen(path.string().c_str(), "wb");
    if (impl_->file == nullptr)
        impl_->ThrowSystem("cannot be created");
    impl_->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, HandleError, HandleWarning);
    if (impl_->png != nullptr)
        impl_->info = png_create_info_struct(impl_->png);
    if (impl_->info == nullptr)
        impl_->Throw("PNG: out of memory");
    if (!WriteHeader(impl_->png, impl_->info, impl_->file, format))
        impl_->ThrowSystem(kCannotWrite);
}

PngWriter::~PngWriter() = default;
PngWriter::PngWriter(PngWriter&&) noexcept = default;
PngWriter& PngWriter::operator=(PngWriter&&) noexcept = default;

void PngWriter::WriteRow(std::span<const std::uint16_t> samples) {
    png_byte* out = impl_->row.data();
    for (const std::uint16_t sample : samples) {
        if (impl_->format.bits == 16)
            *out++ = static_cast<png_byte>(sample >> 8);
        *out++ = static_cast<png_byte>(sample & 0xFFu);
    }
    if (!WriteBytes(impl_->png, impl_->row.data()))
        impl_->ThrowSystem(kCannotWrite);
}

void PngWriter::Finish() {
    bool good = WriteEnd(impl_->png, impl_->info);
    good = std::fclose(impl_->file) == 0 && good;
    impl_->file = nullptr;
    if (!good)
        impl_->ThrowSystem(kCannotWrite);
}

} // namespace openntc::tool
