// SPDX-License-Identifier: MIT
#include "textures/ImageSink.h"

#include "Exr.h"
#include "Png.h"
#include "textures/Tga.h"

#include "openntc/core/Crc32.h"

#include <cstring>
#include <optional>
#include <vector>

namespace openntc::tool {

namespace {

/// `Writer` is PngWriter, ExrWriter or TgaWriter, made when the size is known.
template <typename Writer>
class OneLevelSink : public ImageSink {
public:
    OneLevelSink(const SinkFile& file, const TextureImage& image) : file_(file), image_(image) {}

    void BeginLevel(std::uint32_t, int width, int height) override {
        rowFloats_ = static_cast<std::size_t>(width) * 16;
        Make(width, height);
    }
    void WriteRows(std::span<const float> outputs) override {
        for (std::size_t at = 0; at < outputs.size(); at += rowFloats_)
            WriteRow(outputs.subspan(at, rowFloats_));
    }
    void EndLevel() override {}
    std::uint64_t Finish() override {
        writer_->Finish();
        return 0;
    }

protected:
    virtual void Make(int width, int height) = 0;
    virtual void WriteRow(std::span<const float> outputs) = 0;

    SinkFile file_;
    const TextureImage& image_;
    std::optional<Writer> writer_;
    std::size_t rowFloats_ = 0;
};

class PngSink final : public OneLevelSink<PngWriter> {
public:
    using OneLevelSink::OneLevelSink;

private:
    void Make(int width, int height) override {
        writer_.emplace(file_.path, file_.subject, image_.GetPngFormat(width, height));
    }
    void WriteRow(std::span<const float> outputs) override {
        image_.ConvertRow(outputs, row_);
        writer_->WriteRow(row_);
    }

    std::vector<std::uint16_t> row_;
};

class TgaSink final : public OneLevelSink<TgaWriter> {
public:
    using OneLevelSink::OneLevelSink;

private:
    void Make(int width, int height) override {
        writer_.emplace(file_.path, file_.subject, width, height,
                        image_.GetPngFormat(width, height).channels);
    }
    void WriteRow(std::span<const float> outputs) override {
        image_.ConvertRow(outputs, row_);
        writer_->WriteRow(row_);
    }

    std::vector<std::uint16_t> row_;
};

class ExrSink final : public OneLevelSink<ExrWriter> {
public:
    using OneLevelSink::OneLevelSink;

private:
    void Make(int width, int height) override {
        writer_.emplace(file_.path, file_.subject,
                        ExrFormat{width, height, image_.GetLinearSampleCount(), image_.IsHalf()});
    }
    void WriteRow(std::span<const float> outputs) override {
        image_.ConvertRowToLinear(outputs, row_);
        writer_->WriteRow(row_);
    }

    std::vector<float> row_;
};

class TextureSink final : public ImageSink {
public:
    TextureSink(const SinkFile& file, const TexelConverter& converter, const TextureFileDesc& desc,
                const BlockSearch& search)
        : file_(file), converter_(converter), desc_(desc), search_(search) {}

    void BeginLevel(std::uint32_t level, int width, int height) override {
        if (!writer_)
            writer_ = std::make_unique<TextureFileWriter>(file_.path, file_.subject, desc_);
        writer_->BeginLevel(level);
        size_ = writer_->GetLayout().levels[level];
        width_ = static_cast<std::size_t>(width);
        rowsLeft_ = static_cast<std::size_t>(height);
        rowsAdded_ = size_.height - static_cast<std::uint32_t>(height);
        level_ = level;
        blockRow_ = 0;
        texelCrc_ = 0;
    }
    void WriteRows(std::span<const float> outputs) override {
        texels_.clear();
        const std::size_t rows = outputs.size() / (width_ * 16);
        for (std::size_t y = 0; y < rows; ++y) {
            converter_.Append(outputs.subspan(y * width_ * 16, width_ * 16), texels_);
            if (search_.hints != nullptr)
                texelCrc_ =
                    Crc32(std::span<const std::byte>(texels_).last(width_ * GetTexelBytes()), texelCrc_);
            RepeatLastTexel();
        }
        rowsLeft_ -= rows;
        std::uint32_t height = static_cast<std::uint32_t>(rows);
        if (rowsLeft_ == 0) {
            RepeatLastRow();
            height += rowsAdded_;
        }
        if (!desc_.format.block) {
            writer_->Write(texels_);
            return;
        }
        if (search_.hints != nullptr)
            search_.hints->Get(level_, {0, blockRow_, bc::CountBlocks(size_.width), bc::CountBlocks(height)},
                               hints_);
        blockRow_ += bc::CountBlocks(height);
        EncodeTexelBlocks(desc_.format, search_.effort, {texels_, size_.width, height}, 0, file_.subject,
                          blocks_, hints_);
        writer_->Write(blocks_);
    }
    void EndLevel() override {
        writer_->EndLevel();
        if (search_.hints != nullptr)
            search_.hints->Check(level_, texelCrc_, file_.subject);
    }
    std::uint64_t Finish() override { return writer_->Finish(); }

private:
    std::size_t GetTexelBytes() const {
        return static_cast<std::size_t>(GetNumberBytes(desc_.format.number) * desc_.format.channels);
    }
    void Repeat(std::size_t bytes, std::size_t times) {
        for (std::size_t i = 0; i < times; ++i) {
            const std::size_t end = texels_.size();
            texels_.resize(end + bytes);
            std::memcpy(texels_.data() + end, texels_.data() + end - bytes, bytes);
        }
    }
    void RepeatLastTexel() { Repeat(GetTexelBytes(), size_.width - width_); }
    void RepeatLastRow() { Repeat(GetTexelBytes() * size_.width, rowsAdded_); }

    SinkFile file_;
    const TexelConverter& converter_;
    TextureFileDesc desc_;
    BlockSearch search_;
    std::unique_ptr<TextureFileWriter> writer_;
    TextureFileLevel size_;       // of the file's level
    std::size_t width_ = 0;       // of the rows given
    std::size_t rowsLeft_ = 0;    // to be given
    std::uint32_t rowsAdded_ = 0; // after them
    std::uint32_t level_ = 0;
    std::uint32_t blockRow_ = 0; // of the next rows
    std::uint32_t texelCrc_ = 0; // of the level's rows so far
    std::vector<std::byte> texels_, blocks_;
    std::vector<std::int32_t> hints_;
};

} // namespace

std::unique_ptr<ImageSink> MakePngSink(const SinkFile& file, const TextureImage& image) {
    return std::make_unique<PngSink>(file, image);
}

std::unique_ptr<ImageSink> MakeExrSink(const SinkFile& file, const TextureImage& image) {
    return std::make_unique<ExrSink>(file, image);
}

std::unique_ptr<ImageSink> MakeTgaSink(const SinkFile& file, const TextureImage& image) {
    return std::make_unique<TgaSink>(file, image);
}

std::unique_ptr<ImageSink> MakeTextureSink(const SinkFile& file, const TexelConverter& converter,
                                           const TextureFileDesc& desc, const BlockSearch& search) {
    return std::make_unique<TextureSink>(file, converter, desc, search);
}

} // namespace openntc::tool
