// SPDX-License-Identifier: MIT
#include "textures/Tga.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/core/FileCalls.h"

#include <array>
#include <cerrno>
#include <utility>

namespace openntc::tool {

TgaWriter::TgaWriter(const std::filesystem::path& path, std::string subject, int width, int height,
                     int channels)
    : subject_(std::move(subject)), channels_(static_cast<std::size_t>(channels)),
      file_(Require(FileWriter::Create(path), ExitCode::Failed, subject_)) {
    // Truevision TGA 2.0: 18 bytes; type 2 is RGB and 3 gray, bit 5 of the descriptor says that rows come from the top.
    std::array<std::byte, 18> header{};
    header[2] = std::byte{static_cast<unsigned char>(channels == 1 ? 3 : 2)};
    header[12] = static_cast<std::byte>(width & 0xFF);
    header[13] = static_cast<std::byte>(width >> 8);
    header[14] = static_cast<std::byte>(height & 0xFF);
    header[15] = static_cast<std::byte>(height >> 8);
    header[16] = static_cast<std::byte>(8 * channels);
    header[17] = std::byte{static_cast<unsigned char>(0x20 | (channels == 4 ? 8 : 0))};
    Write(header);
}

void TgaWriter::Write(std::span<const std::byte> bytes) {
    if (!file_.Write(bytes.data(), bytes.size()))
        throw CommandError(ExitCode::Failed, subject_,
                           Format("cannot be written: %s", SystemReason(errno).GetText()));
}

void TgaWriter::WriteRow(std::span<const std::uint16_t> samples) {
    row_.clear();
    for (std::size_t texel = 0; texel < samples.size(); texel += channels_) {
        for (std::size_t c = 0; c < channels_; ++c) {
            const std::size_t from = channels_ >= 3 && c < 3 ? 2 - c : c; // B G R A
            row_.push_back(static_cast<std::byte>(samples[texel + from]));
        }
    }
    Write(row_);
}

void TgaWriter::Finish() {
    Require(file_.Commit(), ExitCode::Failed, subject_);
}

} // namespace openntc::tool
