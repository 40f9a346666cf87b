// SPDX-License-Identifier: MIT
#include "textures/HintGatherer.h"

#include "Failure.h"
#include "Interrupt.h"

#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockHints.h"
#include "openntc/core/Crc32.h"

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace openntc::tool {

namespace {

constexpr std::size_t kBlockBytes = 16;

/// Of the texels that the rows have; blocks reach beyond them.
double SumSquares(const TexelRows& rows, int channels, std::span<const std::byte> blocks) {
    double sum = 0.0;
    const std::size_t columns = bc::CountBlocks(rows.width);
    for (std::size_t i = 0; i < blocks.size() / kBlockBytes; ++i) {
        std::uint8_t texels[64];
        bc::DecodeBlockBytes(bc::BlockFormat::Bc7, blocks.data() + i * kBlockBytes, texels);
        std::uint32_t ofBlock = 0; // at most 64 x 255^2
        for (std::size_t t = 0; t < 16; ++t) {
            const std::size_t x = i % columns * 4 + t % 4, y = i / columns * 4 + t / 4;
            if (x >= rows.width || y >= rows.height)
                continue;
            const std::byte* const wanted = rows.texels.data() + (y * rows.width + x) * 4;
            for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
                const int difference = static_cast<int>(wanted[c]) - texels[t * 4 + c];
                ofBlock += static_cast<std::uint32_t>(difference * difference);
            }
        }
        sum += ofBlock;
    }
    return sum;
}

} // namespace

HintTrial& HintTrial::operator+=(const HintTrial& other) {
    seconds += other.seconds;
    squares += other.squares;
    numbers += other.numbers;
    return *this;
}

double HintTrial::GetPsnr() const {
    if (squares == 0.0)
        return std::numeric_limits<double>::infinity();
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(numbers) / squares);
}

HintStatistics& HintStatistics::operator+=(const HintStatistics& other) {
    texels += other.texels;
    blocks += other.blocks;
    for (std::size_t mode = 0; mode < modes.size(); ++mode)
        modes[mode] += other.modes[mode];
    different += other.different;
    search += other.search;
    hinted += other.hinted;
    fast += other.fast;
    return *this;
}

HintGatherer::HintGatherer(const TextureFormat& format, int channels, BlockEffort effort, int threads,
                           std::string subject)
    : format_(format), channels_(channels), effort_(effort), threads_(threads), subject_(std::move(subject)) {
}

void HintGatherer::Encode(const TexelRows& rows, BlockEffort effort, std::span<const std::int32_t> hints,
                          std::vector<std::byte>& blocks, HintTrial& trial) const {
    ThrowIfInterrupted();
    const auto start = std::chrono::steady_clock::now();
    EncodeTexelBlocks(format_, effort, rows, threads_, subject_, blocks, hints);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    trial.seconds += taken.count();
    trial.squares += SumSquares(rows, channels_, blocks);
    trial.numbers += std::uint64_t{rows.width} * rows.height * static_cast<std::uint64_t>(channels_);
}

void HintGatherer::AddRows(const TexelRows& rows) {
    texelCrc_ = Crc32(rows.texels, texelCrc_);
    Encode(rows, effort_, {}, found_, statistics_.search);
    const std::size_t first = hints_.size();
    for (std::size_t at = 0; at < found_.size(); at += kBlockBytes) {
        hints_.push_back(bc::GetBlockHint(found_.data() + at));
        ++statistics_.modes[static_cast<std::size_t>(hints_.back() & 7)];
    }
    Encode(rows, effort_, std::span(hints_).subspan(first), again_, statistics_.hinted);
    for (std::size_t at = 0; at < found_.size(); at += kBlockBytes)
        statistics_.different +=
            std::memcmp(found_.data() + at, again_.data() + at, kBlockBytes) != 0 ? 1U : 0U;
    if (effort_ == BlockEffort::Fast)
        statistics_.fast = statistics_.search;
    else
        Encode(rows, BlockEffort::Fast, {}, again_, statistics_.fast);
    statistics_.texels += std::uint64_t{rows.width} * rows.height;
    statistics_.blocks += found_.size() / kBlockBytes;
}

std::vector<std::byte> HintGatherer::TakeMap() {
    std::vector<std::byte> packed(static_cast<std::size_t>(bc::GetBlockHintBytes(hints_.size())));
    Require(bc::PackBlockHints(hints_, packed), ExitCode::Failed, subject_);
    hints_.clear();
    texelCrc_ = 0;
    return packed;
}

} // namespace openntc::tool
