// SPDX-License-Identifier: MIT
// filter_pictures FOLDER: writes filtering-magnified.png and filtering-plane.png, and says of each of their
// panels what it cost and how far it is from the exact filter.
#include "Pictures.h"

#include "materials/Images.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

namespace {

using namespace openntc_filtering;

/// What a pixel sees of the texture.
struct View {
    stf::float2 uv, ddx, ddy;
};

using Camera = std::function<View(int x, int y)>;

enum class Way { Exact, Hashed, Even, Shared, Together };

struct Panel {
    const char* title;
    stf::NtcStfSampler settings;
    Way way;
    std::uint32_t frames;
};

/// A picture of panels, which are drawn one by one.
class Sheet {
public:
    Sheet(const Texture& texture, Camera camera, int panelSize, int columns)
        : texture_(texture), camera_(std::move(camera)), panel_(panelSize), columns_(columns),
          image_(panelSize * columns, 3) {}

    void Add(const Panel& panel) {
        const std::vector<stf::float4> pixels = Draw(panel);
        Panel reference = panel;
        reference.way = Way::Exact;
        const std::uint64_t decodes = decodes_;
        const std::vector<stf::float4> exact = Draw(reference);
        double squares = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const int x = static_cast<int>(i) % panel_ + count_ % columns_ * panel_;
            const int y = static_cast<int>(i) / panel_ + count_ / columns_ * panel_;
            for (int c = 0; c < 3; ++c) {
                image_.At(x, y, c) = std::clamp(pixels[i][c], 0.0f, 1.0f);
                squares += std::pow(double{pixels[i][c]} - double{exact[i][c]}, 2);
            }
        }
        const double count = static_cast<double>(pixels.size());
        std::printf("| %s | %.2f | %.4f |\n", panel.title,
                    static_cast<double>(decodes) / count / panel.frames, std::sqrt(squares / count / 3));
        ++count_;
    }

    const materials::Image& GetImage() const { return image_; }

private:
    std::vector<stf::float4> Draw(const Panel& panel) {
        std::vector<stf::float4> pixels(static_cast<std::size_t>(panel_ * panel_));
        decodes_ = 0;
        const bool isWave = panel.way == Way::Shared || panel.way == Way::Together;
        for (int y = 0; y < panel_; y += isWave ? 2 : 1) {
            for (int x = 0; x < panel_; x += isWave ? 4 : 1) {
                if (isWave)
                    DrawWave(panel, x, y, pixels);
                else
                    At(pixels, x, y) = Shade(panel, x, y);
            }
        }
        return pixels;
    }

    stf::float4& At(std::vector<stf::float4>& pixels, int x, int y) const {
        return pixels[static_cast<std::size_t>(y * panel_ + x)];
    }

    stf::float4 Shade(const Panel& panel, int x, int y) {
        const View view = camera_(x, y);
        const TextureReader reader{&texture_, &decodes_};
        const stf::NtcStfFootprint footprint =
            stf::NtcStfGetFootprint(panel.settings, texture_.extent, view.ddx, view.ddy);
        if (panel.way == Way::Exact)
            return stf::FilterAll(reader, panel.settings, texture_.extent, view.uv, footprint);
        stf::float4 sum(0, 0, 0, 0);
        const stf::uint4 base =
            stf::NtcStfPcg4d(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, 0);
        for (std::uint32_t frame = 0; frame < panel.frames; ++frame) {
            const stf::uint4 random = panel.way == Way::Even ? stf::NtcStfRandomR2(base, frame)
                                                             : stf::NtcStfRandomHashed({x, y}, frame, 0, 0);
            sum += stf::FilterOne(reader, panel.settings, view.uv, footprint, random);
        }
        return sum / static_cast<float>(panel.frames);
    }

    /// 4 x 2 pixels, a wave of 8 lanes. A lane that is run again counts anew.
    void DrawWave(const Panel& panel, int left, int top, std::vector<stf::float4>& pixels) {
        std::uint64_t decodes[8] = {};
        wave_.Execute(
            8, [](std::uint32_t) { return true; },
            [&](std::uint32_t lane) {
                decodes[lane] = 0;
                const int x = left + static_cast<int>((lane & 1u) | ((lane >> 1) & 2u));
                const int y = top + static_cast<int>((lane >> 1) & 1u);
                const View view = camera_(x, y);
                const TextureReader reader{&texture_, &decodes[lane]};
                const stf::NtcStfFootprint footprint =
                    stf::NtcStfGetFootprint(panel.settings, texture_.extent, view.ddx, view.ddy);
                const stf::uint4 random = stf::NtcStfRandomHashed({x, y}, 0, 0, 0);
                const stf::NtcStfWaveLane self = stf::NtcStfMakeWaveLane(0, true);
                At(pixels, x, y) = panel.way == Way::Together
                                       ? stf::FilterTogether(reader, self, panel.settings, texture_.extent,
                                                             view.uv, footprint, random)
                                       : stf::FilterShared(reader, self, 4, panel.settings, texture_.extent,
                                                           view.uv, footprint, random);
            });
        for (const std::uint64_t count : decodes)
            decodes_ += count;
    }

    const Texture& texture_;
    Camera camera_;
    int panel_, columns_, count_ = 0;
    materials::Image image_;
    std::uint64_t decodes_ = 0;
    WaveEmulator wave_;
};

/// Rings and a cross of colour on 16 x 16 texels.
Texture MakeSmallTexture() {
    std::vector<stf::float4> texels;
    for (int i = 0; i < 256; ++i) {
        const int column = i % 16, row = i / 16;
        const float x = static_cast<float>(column) - 7.5f, y = static_cast<float>(row) - 7.5f;
        const float radius = std::sqrt(x * x + y * y);
        const bool isRing = static_cast<int>(radius) % 3 == 0;
        const bool isCross = std::fabs(x) < 1 || std::fabs(y) < 1;
        texels.push_back(isCross  ? stf::float4(0.9f, 0.75f, 0.1f, 1)
                         : isRing ? stf::float4(0.75f, 0.08f, 0.05f, 1)
                                  : stf::float4(0.03f, 0.12f, 0.35f, 1));
    }
    return MakeTexture(16, std::move(texels));
}

/// A floor of 8 x 8 tiles with lines between them.
Texture MakeFloor() {
    constexpr int kSize = 256;
    std::vector<stf::float4> texels;
    for (int i = 0; i < kSize * kSize; ++i) {
        const int x = i % kSize, y = i / kSize;
        const bool isLine = x % 32 < 3 || y % 32 < 3;
        const bool isDark = (x / 32 + y / 32) % 2 == 0;
        texels.push_back(isLine   ? stf::float4(0.02f, 0.02f, 0.02f, 1)
                         : isDark ? stf::float4(0.08f, 0.22f, 0.30f, 1)
                                  : stf::float4(0.85f, 0.80f, 0.65f, 1));
    }
    return MakeTexture(kSize, std::move(texels));
}

/// A turned square, a texel of which is 7 pixels wide.
View SeeMagnified(int x, int y) {
    const float step = 1.0f / (7 * 16), cosine = 0.9563f * step, sine = 0.2924f * step;
    const float px = static_cast<float>(x) - 48, py = static_cast<float>(y) - 48;
    return {
        {0.5f + px * cosine - py * sine, 0.5f + px * sine + py * cosine}, {cosine, sine}, {-sine, cosine}};
}

/// A floor that runs to the horizon, which is above the picture.
View SeeFloor(int x, int y) {
    const auto at = [](float px, float py) {
        const float depth = 60.0f / (py + 9);
        return stf::float2((px - 64) / 96 * depth + 0.37f, depth);
    };
    const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
    const stf::float2 uv = at(px, py);
    return {uv, at(px + 1, py) - uv, at(px, py + 1) - uv};
}

bool Write(const std::string& folder, const char* name, const Sheet& sheet) {
    if (materials::WritePng(folder + "/" + name, sheet.GetImage(), true))
        return true;
    std::fprintf(stderr, "filter_pictures: cannot write %s/%s\n", folder.c_str(), name);
    return false;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: filter_pictures FOLDER\n");
        return 2;
    }
    const auto kernel = [](std::uint32_t number) { return stf::NtcStfMakeSampler(number, NTC_WRAP_REPEAT); };
    const stf::NtcStfSampler bilinear = kernel(NTC_KERNEL_BILINEAR);

    std::printf("| magnified | texels decoded per pixel and frame | RMSE against its exact filter "
                "|\n|---|---|---|\n");
    const Texture small = MakeSmallTexture();
    Sheet magnified(small, SeeMagnified, 96, 3);
    magnified.Add({"nearest", kernel(NTC_KERNEL_NEAREST), Way::Exact, 1});
    magnified.Add({"bilinear", bilinear, Way::Exact, 1});
    magnified.Add({"B-spline", kernel(NTC_KERNEL_CUBIC), Way::Exact, 1});
    magnified.Add({"bilinear, one texel, 1 frame", bilinear, Way::Hashed, 1});
    magnified.Add({"the same, 16 frames, hashed numbers", bilinear, Way::Hashed, 16});
    magnified.Add({"the same, 16 frames, R2", bilinear, Way::Even, 16});
    magnified.Add({"bilinear, 2 x 2 pixels share, 1 frame", bilinear, Way::Shared, 1});
    magnified.Add({"bilinear, waves of 8 collaborate, 1 frame", bilinear, Way::Together, 1});
    magnified.Add({"Catmull-Rom, two texels, 64 frames, R2", kernel(NTC_KERNEL_CATMULL_ROM), Way::Even, 64});

    std::printf("\n| a floor | texels decoded per pixel and frame | RMSE against its exact filter "
                "|\n|---|---|---|\n");
    const Texture floor = MakeFloor();
    stf::NtcStfSampler anisotropic = bilinear;
    anisotropic.maxAnisotropy = 16;
    Sheet plane(floor, SeeFloor, 128, 2);
    plane.Add({"trilinear", bilinear, Way::Exact, 1});
    plane.Add({"anisotropic, 16 taps", anisotropic, Way::Exact, 1});
    plane.Add({"anisotropic, one texel, 1 frame", anisotropic, Way::Hashed, 1});
    plane.Add({"the same, 64 frames, R2", anisotropic, Way::Even, 64});

    const std::string folder = argv[1];
    const bool isWritten =
        Write(folder, "filtering-magnified.png", magnified) && Write(folder, "filtering-plane.png", plane);
    return isWritten ? 0 : 1;
}
