// SPDX-License-Identifier: MIT
#include "renderer/scene/SceneImages.h"

#include "renderer/scene/GltfScene.h"

#include "Failure.h"
#include "InputFile.h"
#include "Output.h"
#include "encode/InputImage.h"
#include "encode/PngReader.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>

namespace openntc::renderer {

namespace {

constexpr int kMaxImageSide = 16384;

/// `read(texel, channel)` gives 0 ... 255; gray becomes three equal channels, missing alpha is 255.
template <typename Read>
void FillImage(SourceImage& image, int channels, const Read& read) {
    const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    image.texels.resize(count * 4);
    for (std::size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c)
            image.texels[i * 4 + static_cast<std::size_t>(c)] = read(i, channels < 3 ? 0 : c);
        image.texels[i * 4 + 3] = channels % 2 == 0 ? read(i, channels - 1) : std::uint8_t{255};
    }
}

void DecodeImage(const ImageSource& source, SourceImage& image) {
    std::vector<std::byte> file;
    if (source.bytes.buffer == nullptr)
        file = tool::ReadAll(source.path);
    const std::span<const std::byte> bytes =
        source.bytes.buffer == nullptr ? std::span<const std::byte>(file) : source.bytes.Get();
    if (tool::IsPng(bytes)) {
        const tool::PngImage png = tool::ReadPng(bytes, source.path, kMaxImageSide);
        image.width = png.width;
        image.height = png.height;
        const auto channels = static_cast<std::size_t>(png.channels);
        if (png.bits == 8) {
            FillImage(image, png.channels, [&](std::size_t i, int c) {
                return png.samples[i * channels + static_cast<std::size_t>(c)];
            });
        } else {
            FillImage(image, png.channels, [&](std::size_t i, int c) {
                const std::uint8_t* sample =
                    png.samples.data() + 2 * (i * channels + static_cast<std::size_t>(c));
                return static_cast<std::uint8_t>((sample[0] * 256u + sample[1] + 128u) / 257u);
            });
        }
        return;
    }
    const tool::InputImage input = tool::ReadImage(source.path, bytes);
    image.width = input.width;
    image.height = input.height;
    const auto channels = static_cast<std::size_t>(input.channels);
    FillImage(image, input.channels, [&](std::size_t i, int c) {
        const float value = input.texels[i * channels + static_cast<std::size_t>(c)];
        return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f);
    });
}

void ReplaceImage(SourceImage& image, std::string error) {
    image.error = std::move(error);
    image.width = image.height = 1;
    image.texels = {128, 128, 128, 255};
}

} // namespace

void DecodeImages(const ImageSources& sources, Scene& scene) {
    std::atomic<std::size_t> next{0}, texels{0};
    const auto work = [&] {
        for (std::size_t i = next++; i < sources.size(); i = next++) {
            SourceImage& image = scene.images[i];
            try {
                DecodeImage(sources[i], image);
                const std::size_t all = texels += image.texels.size() / 4;
                if (all > kMaxImageTexels)
                    ReplaceImage(image, tool::Format("%d x %d texels: all images may have %zu", image.width,
                                                     image.height, kMaxImageTexels));
            } catch (const std::exception& error) {
                ReplaceImage(image, error.what());
            }
        }
    };
    constexpr std::size_t kMostThreads = 8; // each holds an image and its file
    const std::size_t count = std::min(
        {sources.size(), kMostThreads, std::max<std::size_t>(std::thread::hardware_concurrency(), 1)});
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < count; ++i)
        threads.emplace_back(work);
    work();
    for (std::thread& thread : threads)
        thread.join();
    for (const SourceImage& image : scene.images) {
        if (!image.error.empty())
            scene.warnings.push_back(image.label + ": " + image.error);
    }
}

} // namespace openntc::renderer
