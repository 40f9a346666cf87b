// SPDX-License-Identifier: MIT
// The pictures behind the numbers: crops and amplified differences.
#pragma once

#include "report/Accuracy.h"
#include "report/Report.h"

#include <filesystem>

namespace openntc::report {

/// Makes PNGs; `scratch` is a file that it may write and removes.
class PictureMaker {
public:
    explicit PictureMaker(std::filesystem::path scratch) : scratch_(std::move(scratch)) {}

    /// Crops of every bits per pixel of the base material, and of every maths mode of the base encoding.
    std::vector<PictureRecord> MakeAll(const std::vector<Case>& cases, EncodingCache& cache,
                                       ReferenceDecodes& references);
    /// What a device decoded otherwise than the C++ decoder.
    PictureRecord MakeDevicePicture(const Case& c, const Encoding& encoding, const std::string& device,
                                    std::span<const float> outputs, ReferenceDecodes& references);

private:
    struct Image;
    std::string Encode(const Image& image);
    PictureRecord MakeRecord(const Image& image, std::string group, std::string title, std::string caption);

    std::filesystem::path scratch_;
};

} // namespace openntc::report
