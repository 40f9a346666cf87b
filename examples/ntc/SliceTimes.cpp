// SPDX-License-Identifier: MIT
#include "SliceTimes.h"

#include "Failure.h"
#include "Interrupt.h"

#include "openntc/inference/PartialInference.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <utility>

namespace openntc::tool {

namespace {

std::span<std::byte> GetPlace(SliceJob& job, std::size_t i) {
    return std::span(job.buffer).subspan(job.places[i], job.places[i + 1] - job.places[i]);
}

/// The file was checked, but compressed latents may still be corrupt.
[[noreturn]] void FailSlice(const SliceJob& job, const Error& error) {
    throw CommandError(ExitCode::BadInput, job.path, error.GetText());
}

/// What one slice is made with. Results go to `sink`, so that no compiler leaves the work out.
void MakeWhole(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    ReadOnlyMemoryStream stream(job.file);
    const Expected<PartialInferenceData> data = MakePartialInferenceData(
        job.set, stream, job.slices[i], InferenceWeightType::GenericInt8, GetPlace(job, i));
    if (!data)
        FailSlice(job, data.error());
    sink += data->constants.highResNeuralMips[0].sliceLeftTop;
}

void AddRow(const SliceJob& job, const NtcSliceConstants& made, std::uint32_t& sink) {
    const auto row = MoveSliceConstants(made, 64);
    if (!row)
        FailSlice(job, row.error());
    sink += row->lowRes.dataOffset;
}

void MakeLayeredRow(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    const Expected<LatentMipSliceLayout> layout = GetLatentMipSlices(job.set, job.slices[i]);
    if (!layout)
        FailSlice(job, layout.error());
    ReadOnlyMemoryStream stream(job.file);
    const Expected<void> read = ReadLatentMipSlices(job.set, *layout, stream, GetPlace(job, i));
    if (!read)
        FailSlice(job, read.error());
    AddRow(job, MakeSliceConstants(job.set, *layout, layout->parts[0].latentMip), sink);
}

void MakeRow(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    if (job.set.GetGeneration() > 1)
        return MakeLayeredRow(job, i, sink);
    const Expected<SliceLayout> layout = GetSliceLayout(job.set, job.slices[i]);
    if (!layout)
        FailSlice(job, layout.error());
    const Expected<void> read = ReadSlice(*layout, job.file, 0, GetPlace(job, i));
    if (!read)
        FailSlice(job, read.error());
    AddRow(job, MakeSliceConstants(*layout, layout->grids[0].neuralMip), sink);
}

void Copy(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    const std::span<std::byte> place = GetPlace(job, i);
    // One piece, unless latents are compressed and a slice is longer than the file.
    const std::size_t piece = std::min(place.size(), job.file.size());
    const std::size_t from = job.places[i] % (job.file.size() - piece + 1);
    for (std::size_t at = 0; at < place.size(); at += piece)
        std::memcpy(place.data() + at, job.file.data() + from, std::min(piece, place.size() - at));
    sink += static_cast<std::uint32_t>(place[i % place.size()]);
}

struct Method {
    const char* name;
    const char* text;
    void (*run)(SliceJob&, std::size_t, std::uint32_t&);
};

constexpr std::array kMethods = {
    Method{"makePartialInferenceData", "MakePartialInferenceData: latents and 624 bytes of constants",
           MakeWhole},
    Method{"readSlice", "layout, reading (GetSliceLayout, ReadSlice), a row of constants", MakeRow},
    Method{"memcpy", "memcpy of as many bytes in one piece a slice", Copy},
};

} // namespace

SliceJob MakeSliceJob(std::vector<std::byte> file, TextureSetMetadata&& set, const SliceDesc& first,
                      const std::string& path) {
    SliceJob job{path, std::move(file), std::move(set), {}, {0}, {}};
    const ColorMip& mip = job.set.GetColorMips()[static_cast<std::size_t>(first.firstMip)];
    std::size_t bytes = 0;
    for (int top = 0; top + first.rect.height <= mip.height; top += first.rect.height) {
        for (int left = 0; left + first.rect.width <= mip.width; left += first.rect.width) {
            SliceDesc slice = first;
            slice.rect.left = left;
            slice.rect.top = top;
            bytes += static_cast<std::size_t>(
                Require(GetPartialLatentBufferSize(job.set, slice), ExitCode::BadInput, path));
            job.slices.push_back(slice);
            job.places.push_back(bytes);
        }
    }
    job.buffer.resize(bytes);
    return job;
}

std::vector<SliceTimes> TimeSlices(SliceJob& job, int slices, int repeat) {
    std::vector<SliceTimes> times;
    for (const Method& method : kMethods)
        times.push_back({method.name, method.text, {}});
    volatile std::uint32_t kept = 0;
    for (int run = -1; run < repeat; ++run) { // in turns, so that all meet the same disturbances
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
            ThrowIfInterrupted();
            std::uint32_t sink = 0;
            const auto begin = std::chrono::steady_clock::now();
            for (int i = 0; i < slices; ++i)
                kMethods[m].run(job, static_cast<std::size_t>(i) % job.slices.size(), sink);
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
            kept = sink;
            if (run >= 0)
                times[m].seconds.push_back(time.count());
        }
    }
    for (std::size_t i = 0; i < job.slices.size(); ++i) { // what is left is slices, not copies
        std::uint32_t sink = 0;
        MakeRow(job, i, sink);
        kept = sink;
    }
    (void)kept;
    for (SliceTimes& entry : times)
        std::sort(entry.seconds.begin(), entry.seconds.end());
    return times;
}

} // namespace openntc::tool
