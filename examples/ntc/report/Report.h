// SPDX-License-Identifier: MIT
// What `ntc report` measures, as written to report.json. The Describe functions are the one list of members:
// Json.cpp reads and writes by them.
#pragma once

#include "report/SceneRecord.h"
#include "report/Spread.h"

#include <cstdint>
#include <string>
#include <vector>

namespace openntc::report {

/// Mip 0, over the outputs that the case reads and a texture covers. LSB: steps of 8-bit UNORM, 1/255.
struct Accuracy {
    double psnrSource = 0, ssimSource = 0, worstLsbSource = 0;
    double psnrFp32 = 0, ssimFp32 = 0, worstLsbFp32 = 0, percentile99LsbFp32 = 0;
    std::uint64_t values = 0; ///< 0: not measured
    /// The device's own values, compared bit by bit with the C++ decoder of the same maths mode. A slow
    /// device decodes some rows; only if they differ, all.
    std::uint64_t comparedWithReference = 0, differentFromReference = 0;
};

struct DeviceRecord {
    std::string name, driver;
    std::string kind;  ///< "gpu", "vulkan on a CPU", "C++ decoder"
    std::string clock; ///< what times were taken with
    std::string features;
    bool hasCoopVec = false; ///< cooperative vectors; only where it is measured
};

struct EncodingRecord {
    std::string name, material, network;
    double bitsPerPixel = 0; ///< asked for
    double trueBitsPerPixel = 0;
    std::vector<int> latentShape;
    int width = 0, height = 0, channels = 0, mips = 0;
    std::uint64_t steps = 0;
    std::uint32_t seed = 0;
    std::uint64_t fileBytes = 0;
    std::uint64_t memoryBytes = 0; ///< latents of all mips, Int8 weights and constants, as uploaded
    double psnr = 0;               ///< Int8 network, all mips by texels, against the source
};

struct CaseRecord {
    std::string id;
    std::vector<std::string> axes; ///< lines through the base point that it belongs to
    std::string device, encoding, material, math, network, weights;
    double bitsPerPixel = 0;
    int outputs = 0;
    bool linear = false;
    int sets = 0;             ///< per workgroup; 0: one, known without looking
    std::string latents;      ///< "texture", or empty: a buffer
    std::string instructions; ///< that the C++ decoder was held to, or empty
    std::string skipped;
    Spread time;
    std::vector<double> repeats; ///< that time summarises, in order; not written
    Spread againstGeneration1;   ///< of cases on the axis "generation": time by that of generation 1
    std::uint64_t texelsPerDispatch = 0;
    double extrapolated1080pMs = 0, extrapolated4KMs = 0; ///< median time per texel x pixels
    Accuracy accuracy;
    std::uint64_t fileBytes = 0, memoryBytes = 0;
};

/// A camera path over streamed texture sets (Streaming.h).
struct StreamingRecord {
    std::string id, encoding;
    int sets = 0, frames = 0;
    int tilesAFrameLimit = 0; ///< read at most; 0: all that are asked for
    std::uint64_t allTiles = 0, budgetTiles = 0, allBytes = 0,
                  budgetBytes = 0;           ///< tails included; bytes of slots
    double wantedShare = 0;                  ///< of the pixels: shown at the mip that was wanted
    double mipDeficit = 0;                   ///< mean, how many mips coarser
    double psnr = 0;                         ///< of what was shown against what was wanted, both decoded
    double tilesLoaded = 0, bytesLoaded = 0; ///< a frame
    Spread millisecondsAFrame;               ///< of the loader, reading included; over the frames
};

/// A texture of the sample material compressed to blocks, on load (Blocks.h).
struct BlockRecord {
    std::string id, device, texture, format, level;
    int threads = 0; ///< of a processor; 0: a GPU, or a driver that decides itself
    int width = 0, height = 0;
    std::uint64_t rawBytes = 0, blockBytes = 0; ///< of that mip
    double psnrDecoded = 0;      ///< of what blocks show against the texels that they were made of
    double psnrSource = 0;       ///< against the source
    double psnrSourceBefore = 0; ///< of the decoded texels against the source, without blocks
    std::uint64_t comparedWithReference = 0, differentFromReference = 0; ///< blocks; those of the C++ encoder
    std::string skipped;
    Spread time; ///< nanoseconds per texel
};

/// All mips of a set of textures.
struct BlockSizeRecord {
    std::string encoding;
    std::vector<std::string> formats; ///< `BaseColor BC7`
    std::uint64_t rawBytes = 0, blockBytes = 0, memoryBytes = 0, fileBytes = 0;
};

/// A texture set that is filtered (Filtering.h).
struct FilteringRecord {
    std::string id, device, encoding;
    std::string filter, scene;  ///< "B-spline"; "magnified", "floor"
    std::string texels;         ///< "one texel", "2 x 2 share", "waves collaborate", "all texels"
    double texelsPerSample = 0; ///< decoded per pixel and frame
    std::vector<int> frames;    ///< accumulated, and the error then against the filter with all texels:
    std::vector<double> rmse;   ///< root of the mean square over pixels and declared channels
    Spread time;                ///< nanoseconds per pixel and frame, decoding alone
};

/// Encodings of one material with more and more steps, by one kernel (TrainingCurves.h).
struct TrainingRecord {
    std::string id;
    std::string device; ///< that trained: of the processor, or a Vulkan device
    std::string kernel, material, skipped;
    int width = 0, height = 0, channels = 0, threads = 0, batchTexels = 0;
    double bitsPerPixel = 0;
    /// For each encoding: steps; seconds of the clock and of the processor, of all of it; dB.
    std::vector<int> steps;
    std::vector<double> seconds, processorSeconds, psnr;
};

/// A PNG, in base64, so that the JSON is all that a page needs.
struct PictureRecord {
    std::string group, title, caption;
    int width = 0, height = 0;
    std::string png;
};

struct HardCaseRecord {
    std::string name;
    double worst = 0, bound = 0;
    std::string note;
};

/// One case in an older report and in this one.
struct ChangeRecord {
    std::string id, device;
    double oldMedian = 0, newMedian = 0, ratio = 0; ///< new / old
    bool changed = false;                           ///< not noise, by the rule in Changes.h
    double psnrChange = 0, worstLsbChange = 0;      ///< new - old
    bool accuracyChanged = false;
    std::string missing; ///< "new" or "gone"
};

struct ReportRecord {
    int version = 1;
    std::string tool, date, cpu;
    int cores = 0;
    double load =
        0; ///< processes that wanted to run in the minute before; 0 also where the system does not say
    bool loadExceedsThreads = false; ///< others had the processor too: times say little
    bool quick = false;
    bool cancelled = false;  ///< cases that were not measured when it was cancelled are not listed
    double seconds = 0;      ///< of the whole command, without filling the cache
    double cacheSeconds = 0; ///< spent on encodings that were not there
    int cacheFilled = 0;     ///< how many those were
    std::string trainingKernel;
    std::vector<DeviceRecord> devices;
    std::vector<EncodingRecord> encodings;
    std::vector<CaseRecord> cases;
    std::vector<StreamingRecord> streaming;
    std::vector<BlockRecord> blocks;
    std::vector<BlockSizeRecord> blockSizes;
    std::vector<FilteringRecord> filtering;
    std::vector<SceneRecord> scenes;
    std::vector<TrainingRecord> training;
    std::vector<PictureRecord> pictures;
    std::vector<HardCaseRecord> hardCases;
    std::string comparedWith; ///< date of the older report, or empty
    std::vector<ChangeRecord> changes;
};

template <typename A>
void Describe(A& a, Accuracy& r) {
    a("psnrSource", r.psnrSource);
    a("ssimSource", r.ssimSource);
    a("worstLsbSource", r.worstLsbSource);
    a("psnrFp32", r.psnrFp32);
    a("ssimFp32", r.ssimFp32);
    a("worstLsbFp32", r.worstLsbFp32);
    a("percentile99LsbFp32", r.percentile99LsbFp32);
    a("values", r.values);
    a("comparedWithReference", r.comparedWithReference);
    a("differentFromReference", r.differentFromReference);
}

template <typename A>
void Describe(A& a, DeviceRecord& r) {
    a("name", r.name);
    a("driver", r.driver);
    a("kind", r.kind);
    a("clock", r.clock);
    a("features", r.features);
}

template <typename A>
void Describe(A& a, EncodingRecord& r) {
    a("name", r.name);
    a("material", r.material);
    a("network", r.network);
    a("bitsPerPixel", r.bitsPerPixel);
    a("trueBitsPerPixel", r.trueBitsPerPixel);
    a("latentShape", r.latentShape);
    a("width", r.width);
    a("height", r.height);
    a("channels", r.channels);
    a("mips", r.mips);
    a("steps", r.steps);
    a("seed", r.seed);
    a("fileBytes", r.fileBytes);
    a("memoryBytes", r.memoryBytes);
    a("psnr", r.psnr);
}

template <typename A>
void Describe(A& a, CaseRecord& r) {
    a("id", r.id);
    a("axes", r.axes);
    a("device", r.device);
    a("encoding", r.encoding);
    a("material", r.material);
    a("math", r.math);
    a("network", r.network);
    a("weights", r.weights);
    a("bitsPerPixel", r.bitsPerPixel);
    a("outputs", r.outputs);
    a("linear", r.linear);
    a("sets", r.sets);
    a.Optional("instructions", r.instructions); // not in older files
    a.Optional("latents", r.latents);           // likewise
    a("skipped", r.skipped);
    a("nanosecondsPerTexel", r.time);
    a.Optional("againstGeneration1", r.againstGeneration1); // likewise
    a("texelsPerDispatch", r.texelsPerDispatch);
    a("extrapolated1080pMilliseconds", r.extrapolated1080pMs);
    a("extrapolated4KMilliseconds", r.extrapolated4KMs);
    a("accuracy", r.accuracy);
    a("fileBytes", r.fileBytes);
    a("memoryBytes", r.memoryBytes);
}

template <typename A>
void Describe(A& a, StreamingRecord& r) {
    a("id", r.id);
    a("encoding", r.encoding);
    a("sets", r.sets);
    a("frames", r.frames);
    a("tilesAFrameLimit", r.tilesAFrameLimit);
    a("allTiles", r.allTiles);
    a("budgetTiles", r.budgetTiles);
    a("allBytes", r.allBytes);
    a("budgetBytes", r.budgetBytes);
    a("wantedShare", r.wantedShare);
    a("mipDeficit", r.mipDeficit);
    a("psnr", r.psnr);
    a("tilesLoaded", r.tilesLoaded);
    a("bytesLoaded", r.bytesLoaded);
    a("millisecondsAFrame", r.millisecondsAFrame);
}

template <typename A>
void Describe(A& a, BlockRecord& r) {
    a("id", r.id);
    a("device", r.device);
    a("texture", r.texture);
    a("format", r.format);
    a("level", r.level);
    a("threads", r.threads);
    a("width", r.width);
    a("height", r.height);
    a("rawBytes", r.rawBytes);
    a("blockBytes", r.blockBytes);
    a("psnrDecoded", r.psnrDecoded);
    a("psnrSource", r.psnrSource);
    a("psnrSourceBefore", r.psnrSourceBefore);
    a("comparedWithReference", r.comparedWithReference);
    a("differentFromReference", r.differentFromReference);
    a("skipped", r.skipped);
    a("nanosecondsPerTexel", r.time);
}

template <typename A>
void Describe(A& a, BlockSizeRecord& r) {
    a("encoding", r.encoding);
    a("formats", r.formats);
    a("rawBytes", r.rawBytes);
    a("blockBytes", r.blockBytes);
    a("memoryBytes", r.memoryBytes);
    a("fileBytes", r.fileBytes);
}

template <typename A>
void Describe(A& a, FilteringRecord& r) {
    a("id", r.id);
    a("device", r.device);
    a("encoding", r.encoding);
    a("filter", r.filter);
    a("scene", r.scene);
    a("texels", r.texels);
    a("texelsPerSample", r.texelsPerSample);
    a("frames", r.frames);
    a("rmse", r.rmse);
    a("nanosecondsPerSample", r.time);
}

template <typename A>
void Describe(A& a, TrainingRecord& r) {
    a("id", r.id);
    a("device", r.device);
    a("kernel", r.kernel);
    a("material", r.material);
    a("skipped", r.skipped);
    a("width", r.width);
    a("height", r.height);
    a("channels", r.channels);
    a("threads", r.threads);
    a("batchTexels", r.batchTexels);
    a("bitsPerPixel", r.bitsPerPixel);
    a("steps", r.steps);
    a("seconds", r.seconds);
    a("processorSeconds", r.processorSeconds);
    a("psnr", r.psnr);
}

template <typename A>
void Describe(A& a, PictureRecord& r) {
    a("group", r.group);
    a("title", r.title);
    a("caption", r.caption);
    a("width", r.width);
    a("height", r.height);
    a("png", r.png);
}

template <typename A>
void Describe(A& a, HardCaseRecord& r) {
    a("name", r.name);
    a("worst", r.worst);
    a("bound", r.bound);
    a("note", r.note);
}

template <typename A>
void Describe(A& a, ChangeRecord& r) {
    a("id", r.id);
    a("device", r.device);
    a("oldMedian", r.oldMedian);
    a("newMedian", r.newMedian);
    a("ratio", r.ratio);
    a("changed", r.changed);
    a("psnrChange", r.psnrChange);
    a("worstLsbChange", r.worstLsbChange);
    a("accuracyChanged", r.accuracyChanged);
    a("missing", r.missing);
}

template <typename A>
void Describe(A& a, ReportRecord& r) {
    a("version", r.version);
    a("tool", r.tool);
    a("date", r.date);
    a("cpu", r.cpu);
    a("cores", r.cores);
    a("load", r.load);
    a.Optional("loadExceedsThreads", r.loadExceedsThreads); // not in older files
    a("quick", r.quick);
    a.Optional("cancelled", r.cancelled); // likewise
    a("seconds", r.seconds);
    a("cacheSeconds", r.cacheSeconds);
    a("cacheFilled", r.cacheFilled);
    a("trainingKernel", r.trainingKernel);
    a("devices", r.devices);
    a("encodings", r.encodings);
    a("cases", r.cases);
    a.Optional("streaming", r.streaming); // not in older files
    a.Optional("blocks", r.blocks);       // likewise
    a.Optional("blockSizes", r.blockSizes);
    a.Optional("filtering", r.filtering);
    a.Optional("scenes", r.scenes);
    a.Optional("training", r.training);
    a("pictures", r.pictures);
    a("hardCases", r.hardCases);
    a("comparedWith", r.comparedWith);
    a("changes", r.changes);
}

} // namespace openntc::report
