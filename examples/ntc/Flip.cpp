// SPDX-License-Identifier: MIT
#include "Flip.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <thread>

namespace openntc::tool {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kPixelsPerDegree = 3840.0 * kPi / 180.0; // 0.7 m away, 3840 pixels on 0.7 m
using Color = std::array<double, 3>;
using Plane = std::vector<float>;
using Kernel = std::vector<double>; ///< 2 r + 1 taps

// Linear Rec. 709 to XYZ; white is what (1, 1, 1) becomes.
constexpr double kToXyz[3][3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                                 {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                                 {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};

/// XYZ relative to white, and the way back.
struct ColorMatrices {
    double to[3][3], from[3][3];

    ColorMatrices() {
        for (int i = 0; i < 3; ++i) {
            const double white = kToXyz[i][0] + kToXyz[i][1] + kToXyz[i][2];
            for (int k = 0; k < 3; ++k)
                to[i][k] = kToXyz[i][k] / white;
        }
        const auto minor = [this](int i, int k) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            return to[i1][k1] * to[i2][k2] - to[i1][k2] * to[i2][k1];
        };
        const double determinant = to[0][0] * minor(0, 0) + to[0][1] * minor(0, 1) + to[0][2] * minor(0, 2);
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k)
                from[k][i] = minor(i, k) / determinant;
        }
    }
};

Color Multiply(const double (&m)[3][3], const Color& c) {
    Color result;
    for (std::size_t i = 0; i < 3; ++i)
        result[i] = m[i][0] * c[0] + m[i][1] * c[1] + m[i][2] * c[2];
    return result;
}

double DecodeSrgb(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// CIELab with a and b scaled by lightness: Hunt's effect.
Color MakeHuntLab(const Color& xyz) {
    constexpr double kDelta = 6.0 / 29.0;
    const auto f = [](double t) {
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29.0;
    };
    const double x = f(xyz[0]), y = f(xyz[1]), z = f(xyz[2]), lightness = 116 * y - 16;
    return {lightness, 500 * (x - y) * 0.01 * lightness, 200 * (y - z) * 0.01 * lightness};
}

double GetColorDistance(const Color& a, const Color& b) {
    return std::pow(std::fabs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]), 0.7);
}

/// exp(-x² scale) over -radius ... radius, normalised to sum 1.
Kernel MakeGaussian(double scale, int radius) {
    Kernel kernel;
    double sum = 0.0;
    for (int x = -radius; x <= radius; ++x) {
        kernel.push_back(std::exp(-scale * x * x));
        sum += kernel.back();
    }
    for (double& tap : kernel)
        tap /= sum;
    return kernel;
}

/// Positive taps scaled to sum 1, negative ones to sum -1.
void BalanceSigns(Kernel& kernel) {
    double positive = 0.0, negative = 0.0;
    for (const double tap : kernel)
        (tap > 0.0 ? positive : negative) += tap;
    for (double& tap : kernel)
        tap /= tap > 0.0 ? positive : -negative;
}

/// Work on rows, by several threads.
class Rows {
public:
    Rows(int width, int height, int threads) : width_(width), height_(height) {
        const int all = static_cast<int>(std::thread::hardware_concurrency());
        threads_ = std::clamp(threads > 0 ? threads : all, 1, std::min(height, 64));
    }
    int GetWidth() const { return width_; }
    int GetHeight() const { return height_; }
    std::size_t GetCount() const {
        return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    }

    void ForEach(const std::function<void(int row)>& work) const {
        std::atomic<int> next{0};
        const auto run = [&] {
            for (int row = next++; row < height_; row = next++)
                work(row);
        };
        std::vector<std::thread> team;
        for (int i = 1; i < threads_; ++i)
            team.emplace_back(run);
        run();
        for (std::thread& thread : team)
            thread.join();
    }

private:
    int width_, height_, threads_;
};

/// One pass of a separable filter; beyond the edges their pixels go on.
Plane FilterAcross(const Rows& rows, const Plane& source, const Kernel& kernel) {
    Plane result(rows.GetCount());
    const int width = rows.GetWidth(), radius = static_cast<int>(kernel.size() / 2);
    rows.ForEach([&](int y) {
        const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        std::vector<double> line(static_cast<std::size_t>(width + 2 * radius));
        for (int x = -radius; x < width + radius; ++x)
            line[static_cast<std::size_t>(x + radius)] =
                static_cast<double>(source[begin + static_cast<std::size_t>(std::clamp(x, 0, width - 1))]);
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
            double sum = 0.0;
            for (std::size_t k = 0; k < kernel.size(); ++k)
                sum += kernel[k] * line[x + k];
            result[begin + x] = static_cast<float>(sum);
        }
    });
    return result;
}

Plane FilterDown(const Rows& rows, const Plane& source, const Kernel& kernel) {
    Plane result(rows.GetCount());
    const auto width = static_cast<std::size_t>(rows.GetWidth());
    const int radius = static_cast<int>(kernel.size() / 2);
    rows.ForEach([&](int y) {
        std::vector<double> sums(width, 0.0);
        for (int k = -radius; k <= radius; ++k) {
            const double tap = kernel[static_cast<std::size_t>(k + radius)];
            const float* line =
                source.data() + static_cast<std::size_t>(std::clamp(y + k, 0, rows.GetHeight() - 1)) * width;
            for (std::size_t x = 0; x < width; ++x)
                sums[x] += tap * static_cast<double>(line[x]);
        }
        for (std::size_t x = 0; x < width; ++x)
            result[static_cast<std::size_t>(y) * width + x] = static_cast<float>(sums[x]);
    });
    return result;
}

Plane FilterBoth(const Rows& rows, const Plane& source, const Kernel& kernel) {
    return FilterDown(rows, FilterAcross(rows, source, kernel), kernel);
}

/// What one picture contributes.
struct Picture {
    std::vector<Color> lab; ///< filtered as eyes do, with Hunt's effect
    Plane edges, points;    ///< strength of features
};

class FlipMaker {
public:
    explicit FlipMaker(const Rows& rows) : rows_(rows) {}

    Picture MakePicture(std::span<const float> srgb) const {
        std::array<Plane, 3> opponent; // YCxCz
        for (Plane& plane : opponent)
            plane.resize(rows_.GetCount());
        const auto width = static_cast<std::size_t>(rows_.GetWidth());
        rows_.ForEach([&](int y) {
            for (std::size_t i = static_cast<std::size_t>(y) * width;
                 i < (static_cast<std::size_t>(y) + 1) * width; ++i) {
                Color color;
                for (std::size_t c = 0; c < 3; ++c)
                    color[c] = DecodeSrgb(static_cast<double>(std::clamp(srgb[3 * i + c], 0.0f, 1.0f)));
                const Color xyz = Multiply(matrices_.to, color);
                opponent[0][i] = static_cast<float>(116 * xyz[1] - 16);
                opponent[1][i] = static_cast<float>(500 * (xyz[0] - xyz[1]));
                opponent[2][i] = static_cast<float>(200 * (xyz[1] - xyz[2]));
            }
        });
        Picture picture;
        FindFeatures(opponent[0], picture);
        FilterContrast(opponent);
        picture.lab.resize(rows_.GetCount());
        rows_.ForEach([&](int y) {
            for (std::size_t i = static_cast<std::size_t>(y) * width;
                 i < (static_cast<std::size_t>(y) + 1) * width; ++i)
                picture.lab[i] =
                    MakeLab({static_cast<double>(opponent[0][i]), static_cast<double>(opponent[1][i]),
                             static_cast<double>(opponent[2][i])});
        });
        return picture;
    }

    /// Distance of the Hunt-adjusted green and blue primaries.
    double GetLargestDistance() const {
        return GetColorDistance(MakeHuntLab(Multiply(matrices_.to, {0, 1, 0})),
                                MakeHuntLab(Multiply(matrices_.to, {0, 0, 1})));
    }

private:
    /// The contrast sensitivity of eyes. Gaussians, so rows and columns one after the other; of Cz two.
    void FilterContrast(std::array<Plane, 3>& planes) const {
        constexpr int kRadius = 10; // ceil(3 sqrt(0.04 / (2 π²)) pixels per degree)
        const auto kernel = [](double b) {
            return MakeGaussian(kPi * kPi / (b * kPixelsPerDegree * kPixelsPerDegree), kRadius);
        };
        planes[0] = FilterBoth(rows_, planes[0], kernel(0.0047));
        planes[1] = FilterBoth(rows_, planes[1], kernel(0.0053));
        // Shares of the sum that both have together before they are normalised.
        constexpr double kA[] = {34.1, 13.5}, kB[] = {0.04, 0.025};
        double shares[2];
        for (int i = 0; i < 2; ++i) {
            double sum = 0.0;
            for (int x = -kRadius; x <= kRadius; ++x)
                sum += std::exp(-kPi * kPi * x * x / (kB[i] * kPixelsPerDegree * kPixelsPerDegree));
            shares[i] = kA[i] * std::sqrt(kPi / kB[i]) * sum * sum;
        }
        const Plane wide = FilterBoth(rows_, planes[2], kernel(kB[0]));
        const Plane narrow = FilterBoth(rows_, planes[2], kernel(kB[1]));
        for (std::size_t i = 0; i < wide.size(); ++i)
            planes[2][i] = static_cast<float>(
                (shares[0] * static_cast<double>(wide[i]) + shares[1] * static_cast<double>(narrow[i])) /
                (shares[0] + shares[1]));
    }

    Color MakeLab(const Color& opponent) const {
        const double y = (opponent[0] + 16) / 116;
        Color rgb = Multiply(matrices_.from, {opponent[1] / 500 + y, y, y - opponent[2] / 200});
        for (double& channel : rgb)
            channel = std::clamp(channel, 0.0, 1.0);
        return MakeHuntLab(Multiply(matrices_.to, rgb));
    }

    /// Edges and points by the first and second derivative of a Gaussian, of the unfiltered lightness.
    void FindFeatures(const Plane& lightness, Picture& picture) const {
        const double sigma = 0.5 * 0.082 * kPixelsPerDegree;
        const int radius = static_cast<int>(std::ceil(3 * sigma));
        const Kernel smooth = MakeGaussian(1 / (2 * sigma * sigma), radius);
        Kernel edge = smooth, point = smooth;
        for (int x = -radius; x <= radius; ++x) {
            edge[static_cast<std::size_t>(x + radius)] *= -x;
            point[static_cast<std::size_t>(x + radius)] *= x * x / (sigma * sigma) - 1;
        }
        BalanceSigns(edge);
        BalanceSigns(point);
        Plane y(lightness.size());
        for (std::size_t i = 0; i < y.size(); ++i)
            y[i] = (lightness[i] + 16.0f) / 116.0f;
        const Plane down = FilterDown(rows_, y, smooth), across = FilterAcross(rows_, y, smooth);
        const auto strength = [&](const Kernel& kernel) {
            Plane result = FilterAcross(rows_, down, kernel);
            const Plane other = FilterDown(rows_, across, kernel);
            for (std::size_t i = 0; i < result.size(); ++i)
                result[i] = std::hypot(result[i], other[i]);
            return result;
        };
        picture.edges = strength(edge);
        picture.points = strength(point);
    }

    const Rows& rows_;
    ColorMatrices matrices_;
};

} // namespace

FlipResult ComputeFlip(std::span<const float> reference, std::span<const float> test, int width, int height,
                       int threads) {
    const Rows rows(width, height, threads);
    const FlipMaker maker(rows);
    const Picture a = maker.MakePicture(reference), b = maker.MakePicture(test);
    const double largest = maker.GetLargestDistance(), knee = 0.4 * largest;
    FlipResult result;
    result.map.resize(rows.GetCount());
    rows.ForEach([&](int y) {
        const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        for (std::size_t i = begin; i < begin + static_cast<std::size_t>(width); ++i) {
            const double distance = GetColorDistance(a.lab[i], b.lab[i]);
            // What is most visible is squeezed into the last twentieth.
            const double color =
                distance < knee ? 0.95 * distance / knee : 0.95 + 0.05 * (distance - knee) / (largest - knee);
            const double feature = static_cast<double>(
                std::max(std::fabs(a.edges[i] - b.edges[i]), std::fabs(a.points[i] - b.points[i])));
            result.map[i] = static_cast<float>(std::pow(color, 1 - std::sqrt(feature / std::sqrt(2.0))));
        }
    });
    for (const float value : result.map) {
        result.mean += static_cast<double>(value);
        result.maximum = std::max(result.maximum, static_cast<double>(value));
    }
    result.mean /= static_cast<double>(std::max<std::size_t>(result.map.size(), 1));
    return result;
}

} // namespace openntc::tool
