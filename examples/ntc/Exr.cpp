// SPDX-License-Identifier: MIT
#include "Exr.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/core/FileCalls.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#if defined(OPENNTC_TOOL_HAS_EXR)
#include <tinyexr.h>
#endif

namespace openntc::tool {

namespace {

std::vector<std::string> MakeNames(int channels) {
    if (channels == 1)
        return {"Y"};
    static constexpr const char* kColors[] = {"R", "G", "B", "A"};
    std::vector<std::string> names;
    for (int c = 0; c < channels; ++c)
        names.push_back(channels <= 4 ? std::string(kColors[c]) : Format("c%02d", c));
    return names;
}

#if defined(OPENNTC_TOOL_HAS_EXR)
using Bytes = std::unique_ptr<unsigned char, void (*)(void*)>;

/// Planes in the order of `names`, as the bytes of a file; null with `error`.
Bytes Compress(const ExrFormat& format, std::vector<std::vector<float>>& planes, std::size_t& size,
               std::string& error) {
    const std::vector<std::string> names = MakeNames(format.channels);
    const auto count = static_cast<std::size_t>(format.channels);
    std::vector<std::size_t> order(count); // the format wants channels by name
    for (std::size_t i = 0; i < count; ++i)
        order[i] = format.channels > 4 ? i : count - 1 - i; // A B G R
    std::vector<EXRChannelInfo> channels(count);
    std::vector<int> given(count, TINYEXR_PIXELTYPE_FLOAT);
    std::vector<int> stored(count, format.isHalf ? TINYEXR_PIXELTYPE_HALF : TINYEXR_PIXELTYPE_FLOAT);
    std::vector<unsigned char*> images(count);
    for (std::size_t i = 0; i < count; ++i) {
        std::memset(&channels[i], 0, sizeof channels[i]);
        std::snprintf(channels[i].name, sizeof channels[i].name, "%s", names[order[i]].c_str());
        images[i] = reinterpret_cast<unsigned char*>(planes[order[i]].data());
    }
    EXRHeader header;
    InitEXRHeader(&header);
    header.num_channels = format.channels;
    header.channels = channels.data();
    header.pixel_types = given.data();
    header.requested_pixel_types = stored.data();
    header.compression_type = TINYEXR_COMPRESSIONTYPE_ZIP;
    EXRImage image;
    InitEXRImage(&image);
    image.num_channels = format.channels;
    image.width = format.width;
    image.height = format.height;
    image.images = images.data();
    unsigned char* memory = nullptr;
    const char* reason = nullptr;
    size = SaveEXRImageToMemory(&image, &header, &memory, &reason);
    if (size == 0)
        error = reason != nullptr ? reason : "no reason given";
    if (reason != nullptr)
        FreeEXRErrorMessage(reason);
    return Bytes(memory, std::free);
}
#endif

} // namespace

bool IsExrAvailable() {
#if defined(OPENNTC_TOOL_HAS_EXR)
    return true;
#else
    return false;
#endif
}

ExrWriter::ExrWriter(std::filesystem::path path, std::string subject, const ExrFormat& format)
    : path_(std::move(path)), subject_(std::move(subject)), format_(format),
      planes_(static_cast<std::size_t>(format.channels)) {
    for (std::vector<float>& plane : planes_)
        plane.reserve(static_cast<std::size_t>(format.width) * static_cast<std::size_t>(format.height));
}

void ExrWriter::WriteRow(std::span<const float> samples) {
    for (std::size_t i = 0; i < samples.size(); ++i)
        planes_[i % planes_.size()].push_back(samples[i]);
}

void ExrWriter::Finish() {
#if defined(OPENNTC_TOOL_HAS_EXR)
    std::size_t size = 0;
    std::string error;
    const Bytes bytes = Compress(format_, planes_, size, error);
    if (size == 0)
        throw CommandError(ExitCode::Failed, subject_, "OpenEXR: cannot be made: " + error);
    std::FILE* file = std::fopen(path_.string().c_str(), "wb");
    if (file == nullptr)
        throw CommandError(ExitCode::Failed, subject_,
                           Format("cannot be created: %s", SystemReason(errno).GetText()));
    bool good = std::fwrite(bytes.get(), 1, size, file) == size;
    int reason = errno;
    if (std::fclose(file) != 0 && good) {
        reason = errno;
        good = false;
    }
    if (!good)
        throw CommandError(ExitCode::Failed, subject_,
                           Format("cannot be written: %s", SystemReason(reason).GetText()));
    planes_.clear();
#else
    throw CommandError(ExitCode::NoDevice, subject_, "OpenEXR: this build has no tinyexr");
#endif
}

} // namespace openntc::tool
