// SPDX-License-Identifier: MIT
#include "cli/PngForms.h"

#include <doctest/doctest.h>
#include <png.h>

#include <cstdint>
#include <cstdio>
#include <string>

namespace openntc_tests {

namespace {

constexpr std::uint32_t kKey = 1; ///< the transparent value of every channel

int GetStoredChannels(const PngForm& form) {
    return form.colorType == 2 ? 3 : form.colorType == 4 ? 2 : form.colorType == 6 ? 4 : 1;
}

/// Any values, all of the range.
std::uint32_t GetStored(const PngForm& form, int x, int y, int channel) {
    const auto mixed = static_cast<std::uint32_t>(x * 7919 + y * 104729 + channel * 1299709) * 2654435761u;
    const std::uint32_t value = mixed >> (32 - form.bits);
    // A few texels are exactly the key; whole, since channels of others may have its value.
    return form.hasKey && form.colorType != 3 && (x + y) % 4 == 0 ? kKey : value;
}

std::uint8_t GetPalette(std::uint32_t index, int channel) {
    return static_cast<std::uint8_t>(index * 37u + static_cast<std::uint32_t>(channel) * 91u + 5u);
}

std::uint8_t GetPaletteAlpha(std::uint32_t index) {
    return static_cast<std::uint8_t>(255u - index);
}

} // namespace

void WritePngForm(const std::filesystem::path& path, const PngForm& form, bool interlaced) {
    std::FILE* file = std::fopen(path.string().c_str(), "wb");
    REQUIRE(file != nullptr);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, kPngFormWidth, kPngFormHeight, form.bits, form.colorType,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_gAMA(png, info, 1.0);
    std::string key = "Comment", value = "a form";
    png_text text = {};
    text.compression = PNG_TEXT_COMPRESSION_NONE;
    text.key = key.data();
    text.text = value.data();
    png_set_text(png, info, &text, 1);
    if (form.colorType == 3) {
        std::vector<png_color> palette;
        std::vector<png_byte> alpha;
        for (std::uint32_t i = 0; i < (1u << form.bits); ++i) {
            palette.push_back({GetPalette(i, 0), GetPalette(i, 1), GetPalette(i, 2)});
            alpha.push_back(GetPaletteAlpha(i));
        }
        png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
        if (form.hasKey)
            png_set_tRNS(png, info, alpha.data(), static_cast<int>(alpha.size()), nullptr);
    } else if (form.hasKey) {
        png_color_16 transparent = {0, kKey, kKey, kKey, kKey};
        png_set_tRNS(png, info, nullptr, 0, &transparent);
    }
    png_write_info(png, info);
    const int channels = GetStoredChannels(form);
    std::vector<std::vector<png_byte>> rows;
    for (int y = 0; y < kPngFormHeight; ++y) {
        std::vector<png_byte> row(static_cast<std::size_t>((kPngFormWidth * channels * form.bits + 7) / 8));
        int bit = 0;
        for (int x = 0; x < kPngFormWidth; ++x) {
            for (int c = 0; c < channels; ++c) {
                const std::uint32_t sample = GetStored(form, x, y, c);
                for (int b = form.bits - 1; b >= 0; --b, ++bit)
                    row[static_cast<std::size_t>(bit / 8)] = static_cast<png_byte>(
                        row[static_cast<std::size_t>(bit / 8)] | (sample >> b & 1u) << (7 - bit % 8));
            }
        }
        rows.push_back(std::move(row));
    }
    std::vector<png_bytep> pointers;
    for (std::vector<png_byte>& row : rows)
        pointers.push_back(row.data());
    png_write_image(png, pointers.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    std::fclose(file);
}

std::vector<float> GetPngFormSamples(const PngForm& form) {
    std::vector<float> samples;
    const int channels = GetStoredChannels(form);
    const auto maximum = static_cast<float>((1u << form.bits) - 1u);
    for (int y = 0; y < kPngFormHeight; ++y) {
        for (int x = 0; x < kPngFormWidth; ++x) {
            if (form.colorType == 3) {
                const std::uint32_t index = GetStored(form, x, y, 0);
                for (int c = 0; c < 3; ++c)
                    samples.push_back(static_cast<float>(GetPalette(index, c)) / 255.0f);
                if (form.hasKey)
                    samples.push_back(static_cast<float>(GetPaletteAlpha(index)) / 255.0f);
                continue;
            }
            bool isKey = true;
            for (int c = 0; c < channels; ++c) {
                const std::uint32_t sample = GetStored(form, x, y, c);
                isKey = isKey && sample == kKey;
                // 1, 2 and 4 bits divide 255 exactly: v * 255 / maximum is whole.
                samples.push_back(
                    form.bits < 8 ? static_cast<float>(sample * (255u / ((1u << form.bits) - 1u))) / 255.0f
                                  : static_cast<float>(sample) / maximum);
            }
            if (form.hasKey)
                samples.push_back(isKey ? 0.0f : 1.0f);
        }
    }
    return samples;
}

} // namespace openntc_tests
