// SPDX-License-Identifier: MIT
#include "textures/TextureFile.h"

#include "Failure.h"
#include "Output.h"
#include "textures/TextureFileHeaders.h"

#include "openntc/core/FileCalls.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <numeric>
#include <utility>

#if defined(OPENNTC_TOOL_HAS_ZSTD)
#include <zstd.h>
#endif

namespace openntc::tool {

namespace {

std::uint64_t GetLevelBytes(const TextureFormat& format, std::uint32_t width, std::uint32_t height) {
    const std::uint64_t unit = GetUnitTexels(format);
    return (width + unit - 1) / unit * ((height + unit - 1) / unit) * GetUnitBytes(format);
}

std::uint64_t AlignUp(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

} // namespace

TextureFileLayout LayOutTextureFile(const TextureFileDesc& desc) {
    TextureFileLayout layout;
    for (std::uint32_t i = 0; i < desc.levels; ++i) {
        const std::uint32_t width = std::max(desc.width >> i, 1U), height = std::max(desc.height >> i, 1U);
        layout.levels.push_back({width, height, 0, GetLevelBytes(desc.format, width, height)});
    }
    if (desc.container == TextureContainer::Dds) {
        layout.headerBytes = GetDdsHeaderBytes();
        std::uint64_t end = layout.headerBytes;
        for (TextureFileLevel& level : layout.levels) {
            level.offset = end;
            end += level.bytes;
        }
        layout.fileBytes = end;
        return layout;
    }
    layout.headerBytes = GetKtx2HeaderBytes(desc);
    if (desc.zstdLevel != 0)
        return layout;
    // KTX 2.0, section 3.4: smallest first, each at a multiple of lcm(bytes of a texel or block, 4).
    const std::uint64_t alignment = std::lcm(std::uint64_t{GetUnitBytes(desc.format)}, std::uint64_t{4});
    std::uint64_t end = layout.headerBytes;
    for (auto level = layout.levels.rbegin(); level != layout.levels.rend(); ++level) {
        level->offset = AlignUp(end, alignment);
        end = level->offset + level->bytes;
    }
    layout.fileBytes = end;
    return layout;
}

#if defined(OPENNTC_TOOL_HAS_ZSTD)

struct TextureFileWriter::Zstd {
    ZSTD_CCtx* context = ZSTD_createCCtx();
    std::array<std::byte, 1 << 16> output;

    ~Zstd() { ZSTD_freeCCtx(context); }
};

bool IsZstdAvailable() {
    return true;
}

void TextureFileWriter::Compress(std::span<const std::byte> bytes, bool isEnd) {
    ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
    std::size_t left = 1;
    while (input.pos < input.size || (isEnd && left != 0)) {
        ZSTD_outBuffer output{zstd_->output.data(), zstd_->output.size(), 0};
        left = ZSTD_compressStream2(zstd_->context, &output, &input, isEnd ? ZSTD_e_end : ZSTD_e_continue);
        if (ZSTD_isError(left) != 0)
            Throw(std::string("Zstandard: ") + ZSTD_getErrorName(left));
        WriteBytes(std::span(zstd_->output).first(output.pos));
    }
}

#else

struct TextureFileWriter::Zstd {};

bool IsZstdAvailable() {
    return false;
}

void TextureFileWriter::Compress(std::span<const std::byte>, bool) {}

#endif

TextureFileWriter::TextureFileWriter(const std::filesystem::path& path, std::string subject,
                                     const TextureFileDesc& desc)
    : subject_(std::move(subject)), desc_(desc), layout_(LayOutTextureFile(desc)),
      file_(Require(FileWriter::Create(path), ExitCode::Failed, subject_)), storedBytes_(desc.levels),
      level_(desc.levels) {
    if (desc.zstdLevel != 0) {
        if (!IsZstdAvailable())
            throw CommandError(ExitCode::NoDevice, subject_, "Zstandard: this build has no libzstd");
        zstd_ = std::make_unique<Zstd>();
    }
    // The level index is written again when the sizes are known.
    const std::vector<std::byte> header = desc.container == TextureContainer::Dds
                                              ? MakeDdsHeader(desc)
                                              : MakeKtx2Header(desc, layout_, storedBytes_);
    WriteBytes(header);
}

TextureFileWriter::~TextureFileWriter() = default;

void TextureFileWriter::Throw(const std::string& text) const {
    throw CommandError(ExitCode::Failed, subject_, text);
}

void TextureFileWriter::WriteBytes(std::span<const std::byte> bytes) {
    if (!file_.Write(bytes.data(), bytes.size()))
        Throw(Format("cannot be written: %s", SystemReason(errno).GetText()));
    position_ += bytes.size();
}

void TextureFileWriter::BeginLevel(std::uint32_t level) {
    if (level + 1 != level_)
        Throw(Format("level: %u: %u comes next", level, level_ - 1));
    level_ = level;
    levelBytes_ = 0;
    if (desc_.zstdLevel != 0) {
        layout_.levels[level].offset = position_;
#if defined(OPENNTC_TOOL_HAS_ZSTD)
        ZSTD_CCtx_reset(zstd_->context, ZSTD_reset_session_only);
        ZSTD_CCtx_setParameter(zstd_->context, ZSTD_c_compressionLevel, desc_.zstdLevel);
        ZSTD_CCtx_setPledgedSrcSize(zstd_->context, layout_.levels[level].bytes);
#endif
        return;
    }
    const std::uint64_t offset = layout_.levels[level].offset;
    if (desc_.container == TextureContainer::Ktx2) {
        const std::vector<std::byte> padding(static_cast<std::size_t>(offset - position_));
        WriteBytes(padding);
    } else if (!file_.Seek(offset)) {
        Throw(Format("cannot be written: %s", SystemReason(errno).GetText()));
    }
    position_ = offset;
}

void TextureFileWriter::Write(std::span<const std::byte> bytes) {
    levelBytes_ += bytes.size();
    if (levelBytes_ > layout_.levels[level_].bytes)
        Throw(Format("level %u: more than its %llu bytes", level_,
                     static_cast<unsigned long long>(layout_.levels[level_].bytes)));
    if (desc_.zstdLevel != 0)
        Compress(bytes, false);
    else
        WriteBytes(bytes);
}

void TextureFileWriter::EndLevel() {
    if (levelBytes_ != layout_.levels[level_].bytes)
        Throw(Format("level %u: %llu bytes of %llu", level_, static_cast<unsigned long long>(levelBytes_),
                     static_cast<unsigned long long>(layout_.levels[level_].bytes)));
    if (desc_.zstdLevel != 0)
        Compress({}, true);
    storedBytes_[level_] = position_ - layout_.levels[level_].offset;
}

std::uint64_t TextureFileWriter::Finish() {
    if (level_ != 0)
        Throw(Format("levels: %u are missing", level_));
    layout_.fileBytes = std::max(layout_.fileBytes, position_);
    if (desc_.container == TextureContainer::Ktx2) {
        if (!file_.Seek(0))
            Throw(Format("cannot be written: %s", SystemReason(errno).GetText()));
        WriteBytes(MakeKtx2Header(desc_, layout_, storedBytes_));
    }
    Require(file_.Commit(), ExitCode::Failed, subject_);
    return layout_.fileBytes;
}

} // namespace openntc::tool
