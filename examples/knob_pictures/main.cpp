// SPDX-License-Identifier: MIT
// knob_pictures FOLDER [STEPS]: writes a picture for each knob of `ntc encode` that artists turn, knob-*.png,
// and says what the trainings among them came to. Sources, manifests and texture sets go to FOLDER/work.
#include "Failure.h"
#include "Png.h"
#include "encode/ComparedSet.h"
#include "encode/EncodeJob.h"
#include "encode/StateFile.h"

#include "materials/Materials.h"

#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace openntc;
using tool::ComparedSet;
using Color = std::array<float, 3>; ///< sRGB

/// Square panels in columns and rows, with white between them.
class Sheet {
public:
    Sheet(int columns, int rows)
        : width_(columns * (kPanel + kGap) - kGap), height_(rows * (kPanel + kGap) - kGap),
          pixels_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3, 255) {}

    /// color(u, v), 0 … 1 across the panel.
    void Draw(int column, int row, const std::function<Color(float, float)>& color) {
        for (int y = 0; y < kPanel; ++y) {
            for (int x = 0; x < kPanel; ++x) {
                const auto at = static_cast<std::size_t>((row * (kPanel + kGap) + y) * width_ +
                                                         column * (kPanel + kGap) + x) *
                                3;
                const Color c =
                    color((static_cast<float>(x) + 0.5f) / kPanel, (static_cast<float>(y) + 0.5f) / kPanel);
                for (std::size_t i = 0; i < 3; ++i)
                    pixels_[at + i] =
                        static_cast<std::uint16_t>(std::lround(255.0f * std::clamp(c[i], 0.0f, 1.0f)));
            }
        }
    }

    void Write(const fs::path& path) const {
        tool::PngWriter writer(path, path.string(), {width_, height_, 3, 8});
        const auto row = static_cast<std::size_t>(width_) * 3;
        for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y)
            writer.WriteRow(std::span(pixels_).subspan(y * row, row));
        writer.Finish();
    }

private:
    static constexpr int kPanel = 192, kGap = 6;

    int width_, height_;
    std::vector<std::uint16_t> pixels_;
};

/// The texel of a mip under (u, v), repeated beyond the edges.
std::size_t FindTexel(const ComparedSet::Mip& mip, float u, float v) {
    const auto wrap = [](float t, int size) {
        return static_cast<int>(std::floor((t - std::floor(t)) * static_cast<float>(size))) % size;
    };
    return static_cast<std::size_t>(wrap(v, mip.height) * mip.width + wrap(u, mip.width));
}

Color GetColor(const ComparedSet::Mip& mip, int firstChannel, float u, float v) {
    const std::size_t at = FindTexel(mip, u, v);
    Color color;
    for (std::size_t c = 0; c < 3; ++c)
        color[c] = mip.planes[static_cast<std::size_t>(firstChannel) + c][at];
    return color;
}

class Pictures {
public:
    Pictures(fs::path folder, std::uint64_t steps)
        : folder_(std::move(folder)), work_(folder_ / "work"), steps_(steps) {}

    void Draw() {
        for (const int size : {kSize, kTrained}) {
            const fs::path sources = work_ / std::to_string(size);
            fs::create_directories(sources);
            if (!materials::WriteBricks(sources, size) || !materials::WriteGrille(sources, size))
                throw tool::CommandError(ExitCode::Failed, sources.string(), "cannot be written");
        }
        DrawFilters();
        DrawEdges();
        DrawNormals();
        DrawCoverage();
        DrawWeights();
        DrawTargets();
    }

private:
    static constexpr int kSize = 256, kTrained = 64; ///< texels a side
    using ExitCode = tool::ExitCode;

    /// A manifest of textures of one material, `root` before them.
    std::string WriteManifest(int size, const std::string& root, const std::string& textures) const {
        std::string path = (work_ / std::to_string(size) / "knob.json").string();
        const std::string text = "{" + root + "\"textures\":[" + textures + "]}";
        tool::WriteWholeFile(path, {std::as_bytes(std::span(text))});
        return path;
    }
    ComparedSet Load(const std::string& root, const std::string& textures) const {
        return tool::LoadComparedSet(WriteManifest(kSize, root, textures));
    }
    void Write(const Sheet& sheet, const char* name) const { sheet.Write(folder_ / name); }

    /// Above the box, below Kaiser: mips 2, 3 and 4 of the bricks' colour.
    void DrawFilters() const {
        Sheet sheet(3, 2);
        int row = 0;
        for (const char* root : {R"("mipFilter":"box",)", R"("mipFilter":"kaiser",)"}) {
            const ComparedSet set = Load(root, kBricksColor);
            for (int column = 0; column < 3; ++column) {
                const auto& mip = set.mips[static_cast<std::size_t>(column) + 2];
                sheet.Draw(column, row, [&](float u, float v) { return GetColor(mip, 0, u, v); });
            }
            ++row;
        }
        Write(sheet, "knob-mip-filter.png");
    }

    /// Four tiles of mip 4 by Kaiser around the corner in which they meet: wrapped, clamped, and eight times
    /// their difference.
    void DrawEdges() const {
        const ComparedSet wrapped = Load(R"("mipFilter":"kaiser","mipWrap":"wrap",)", kBricksColor),
                          clamped = Load(R"("mipFilter":"kaiser","mipWrap":"clamp",)", kBricksColor);
        Sheet sheet(3, 1);
        const auto get = [](const ComparedSet& set, float u, float v) {
            return GetColor(set.mips[4], 0, u + 0.5f, v + 0.5f);
        };
        sheet.Draw(0, 0, [&](float u, float v) { return get(wrapped, u, v); });
        sheet.Draw(1, 0, [&](float u, float v) { return get(clamped, u, v); });
        sheet.Draw(2, 0, [&](float u, float v) {
            Color color = get(wrapped, u, v);
            const Color other = get(clamped, u, v);
            for (std::size_t c = 0; c < 3; ++c)
                color[c] = 0.5f + 8.0f * (color[c] - other[c]);
            return color;
        });
        Write(sheet, "knob-mip-wrap.png");
    }

    /// Mip 4 of normals, averaged and unit vectors: as colours, and what a shader that does not normalise
    /// them makes of light.
    void DrawNormals() const {
        const std::string normal = R"({"fileName":"bricks_normal.png")";
        Sheet sheet(2, 2);
        int column = 0;
        for (const char* field : {"}", R"(,"normalMap":true})"}) {
            const ComparedSet set = Load("", normal + field);
            const ComparedSet::Mip& mip = set.mips[4];
            sheet.Draw(column, 0, [&](float u, float v) { return GetColor(mip, 0, u, v); });
            sheet.Draw(column++, 1, [&](float u, float v) {
                constexpr Color kLight{-0.36f, 0.48f, 0.8f}; // of length 1
                const Color n = GetColor(mip, 0, u, v);
                float light = 0.0f;
                for (std::size_t c = 0; c < 3; ++c)
                    light += kLight[c] * (2.0f * n[c] - 1.0f);
                const float value = image::EncodeColor(ColorSpace::sRGB, std::max(light, 0.0f));
                return Color{value, value, value};
            });
        }
        Write(sheet, "knob-normal-map.png");
    }

    /// The grille's alpha test in mips 0, 3, 4 and 5: averaged, with its coverage kept.
    void DrawCoverage() const {
        constexpr float kThreshold = 0.5f;
        Sheet sheet(4, 2);
        int row = 0;
        for (const char* root : {"", R"("keepCoverage":0.5,)"}) {
            const ComparedSet set = Load(root, R"({"fileName":"grille_basecolor.png","isSRGB":true,)"
                                               R"("semantics":{"AlphaMask":"A"}})");
            int column = 0;
            for (const std::size_t m : {0u, 3u, 4u, 5u}) {
                const ComparedSet::Mip& mip = set.mips[m];
                sheet.Draw(column++, row, [&](float u, float v) {
                    constexpr Color kSky{0.75f, 0.85f, 0.95f};
                    return mip.planes[3][FindTexel(mip, u, v)] >= kThreshold ? GetColor(mip, 0, u, v) : kSky;
                });
            }
            ++row;
        }
        Write(sheet, "knob-coverage.png");
    }

    tool::EncodedFile Encode(const std::string& manifest, const std::string& name,
                             const tool::TrainingChoices& training) const {
        tool::EncodeJob job;
        job.inputs.paths = {manifest};
        job.output = (work_ / name).string();
        job.training = training;
        job.training.encode.steps = steps_;
        job.keepsState = false;
        job.quiet = true;
        return tool::RunEncodeJob(job);
    }
    static double GetPsnr(const tool::EncodedFile& file, int texture) {
        const tool::UnderstoodTexture& t = file.textures[static_cast<std::size_t>(texture)];
        return tool::GetTexturePsnr(file.result, t.firstChannel, t.channels);
    }

    /// A quarter of the bricks, colour above, normals below: the source, equal weights, colour with eight
    /// times the weight.
    void DrawWeights() const {
        Sheet sheet(3, 2);
        int column = 0;
        const auto add = [&](const ComparedSet& set) {
            for (int row = 0; row < 2; ++row)
                sheet.Draw(column, row, [&](float u, float v) {
                    return GetColor(set.mips[0], 3 * row, 0.5f * u, 0.5f * v);
                });
            ++column;
        };
        for (const char* weight : {"1", "8"}) {
            const std::string manifest =
                WriteManifest(kTrained, "",
                              R"({"fileName":"bricks_basecolor.png","isSRGB":true,"lossFunctionScale":)" +
                                  std::string(weight) + R"(},{"fileName":"bricks_normal.png"})");
            if (column == 0)
                add(tool::LoadComparedSet(manifest));
            tool::TrainingChoices training;
            training.encode.bitsPerPixel = 1.0f;
            training.hasShape = true;
            const tool::EncodedFile file = Encode(manifest, "weight.ntc", training);
            std::printf("weight %s: colour %.2f dB, normals %.2f dB\n", weight, GetPsnr(file, 0),
                        GetPsnr(file, 1));
            add(tool::LoadComparedSet((work_ / "weight.ntc").string()));
        }
        Write(sheet, "knob-weight.png");
    }

    /// A quarter of the bricks' colour at three targets of its own, and of its source.
    void DrawTargets() const {
        const std::string manifest =
            WriteManifest(kTrained, "",
                          R"({"fileName":"bricks_basecolor.png","name":"Color","isSRGB":true},)"
                          R"({"fileName":"bricks_normal.png"})");
        Sheet sheet(4, 1);
        int column = 0;
        for (const double target : {38.0, 42.0, 46.0}) {
            tool::TrainingChoices training;
            training.textureTargets = {{"Color", target}};
            const tool::EncodedFile file = Encode(manifest, "target.ntc", training);
            std::printf("target %g dB: colour %.2f dB at %g bits per pixel\n", target, GetPsnr(file, 0),
                        static_cast<double>(GetLatentShapeBitsPerPixel(file.result.latentShape)));
            const ComparedSet set = tool::LoadComparedSet((work_ / "target.ntc").string());
            sheet.Draw(column++, 0,
                       [&](float u, float v) { return GetColor(set.mips[0], 0, 0.5f * u, 0.5f * v); });
        }
        const ComparedSet source = tool::LoadComparedSet(manifest);
        sheet.Draw(column, 0,
                   [&](float u, float v) { return GetColor(source.mips[0], 0, 0.5f * u, 0.5f * v); });
        Write(sheet, "knob-target-psnr.png");
    }

    static constexpr const char* kBricksColor = R"({"fileName":"bricks_basecolor.png","isSRGB":true})";

    fs::path folder_, work_;
    std::uint64_t steps_;
};

} // namespace

int main(int argc, char** argv) {
    const long steps = argc > 2 ? std::strtol(argv[2], nullptr, 10) : 2000;
    if (argc < 2 || argc > 3 || steps < 1) {
        std::fprintf(stderr, "usage: knob_pictures FOLDER [STEPS]\n");
        return 2;
    }
    try {
        Pictures(argv[1], static_cast<std::uint64_t>(steps)).Draw();
    } catch (const tool::CommandError& error) {
        std::fprintf(stderr, "%s\n", error.GetLine().c_str());
        return static_cast<int>(error.GetCode());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "knob_pictures: %s\n", error.what());
        return 1;
    }
    return 0;
}
