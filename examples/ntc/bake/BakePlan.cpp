// SPDX-License-Identifier: MIT
#include "bake/BakePlan.h"

#include "InputFile.h"
#include "Interrupt.h"
#include "Output.h"
#include "encode/ContentKey.h"
#include "encode/TextureNames.h"

#include "openntc/core/Crc32.h"

#include <algorithm>
#include <filesystem>
#include <thread>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

/// True if the file is the one that the record tells of. Its bytes are read only if its time is another.
bool IsOutputKept(const std::string& output, const BakeRecord& record) {
    const std::optional<FileStamp> stamp = ReadStamp(output);
    if (!stamp || stamp->bytes != record.output.bytes)
        return false;
    return *stamp == record.output || Crc32(ReadAll(output)) == record.crc;
}

/// What differs from the record, in words.
std::string DescribeChange(const BakeRecord& record, const std::string& settings, const BakeTask& task) {
    if (settings != record.settings)
        return "settings";
    for (const BakeSource& image : task.images) {
        const auto old = std::find_if(record.sources.begin(), record.sources.end(),
                                      [&](const BakeSource& source) { return source.path == image.path; });
        if (old == record.sources.end() || old->hash.digest != image.hash.digest)
            return "changed: " + GetRelativePath(image.path, fs::current_path().string());
    }
    return "changed: " + task.material.origin;
}

} // namespace

EncodeJob MakeBakeJob(const BakeOptions& options, const BakeMaterial& material, Manifest manifest) {
    EncodeJob job;
    job.inputs = options.inputs;
    job.inputs.paths = {material.origin};
    job.inputs.manifest = std::move(manifest);
    job.inputs.strict = options.training.strict;
    job.training = options.training;
    KeepOwnNames(job);
    job.output = (fs::path(options.folder) / (material.name + ".ntc")).string();
    job.json = options.json;
    job.quiet = true;
    return job;
}

std::string MakeBakeKey(const EncodeJob& job, const std::map<std::string, std::string>& embedded,
                        std::span<const BakeSource> images) {
    return MakeContentKey(job, [&](const ManifestTexture& texture) {
        if (texture.bytes.buffer != nullptr)
            return MakeDigest(texture.bytes.Get());
        if (const auto found = embedded.find(texture.path); found != embedded.end())
            return found->second;
        const std::string path = GetAbsolutePath(texture.path);
        return std::find_if(images.begin(), images.end(),
                            [&](const BakeSource& image) { return image.path == path; })
            ->hash.digest;
    });
}

void RememberSources(SourceHashes& hashes, std::span<const BakeRecord> records) {
    for (const BakeRecord& record : records) {
        for (const BakeSource& source : record.sources)
            hashes.Remember(source.path, source.hash);
    }
}

std::vector<BakeSource> ListImages(const BakeMaterial& material, SourceHashes& hashes) {
    std::set<std::string> paths;
    for (const ManifestTexture& texture : material.manifest.textures) {
        if (!material.embedded.contains(texture.path))
            paths.insert(GetAbsolutePath(texture.path));
    }
    std::vector<BakeSource> images;
    for (const std::string& path : paths)
        images.push_back({path, hashes.Get(path)});
    return images;
}

BakeTask MakeTask(const BakeOptions& options, BakeMaterial material, SourceHashes& hashes) {
    BakeTask task;
    task.material = std::move(material);
    const EncodeJob job = MakeBakeJob(options, task.material, task.material.manifest);
    task.output = job.output;
    task.record = ReadRecord(GetRecordPath(options.folder, task.material.name), options.folder);
    if (!task.record) {
        task.reason = "new";
        return task;
    }
    task.images = ListImages(task.material, hashes);
    if (MakeBakeKey(job, task.material.embedded, task.images) != task.record->key)
        task.reason = DescribeChange(*task.record, MakeSettingsKey(job), task);
    else if (!IsOutputKept(task.output, *task.record))
        task.reason = ReadStamp(task.output) ? "file changed" : "file missing";
    return task;
}

std::vector<BakeRecord> FindVanished(const BakeOptions& options, const MaterialTree& tree,
                                     std::span<const BakeRecord> records) {
    std::vector<BakeRecord> vanished;
    if (!tree.isWhole)
        return vanished;
    std::set<std::string> roots, names, failed;
    for (const std::string& input : options.tree.inputs)
        roots.insert(GetAbsolutePath(input));
    for (const BakeMaterial& material : tree.materials) {
        names.insert(material.name);
        if (material.error)
            failed.insert(GetAbsolutePath(material.origin));
    }
    for (const BakeRecord& record : records) {
        if (names.contains(record.name) || failed.contains(record.origin))
            continue;
        if (roots.contains(record.root))
            vanished.push_back(record);
    }
    return vanished;
}

std::vector<std::string> ListDue(const BakeOptions& options, const MaterialTree& tree) {
    SourceHashes hashes;
    RememberSources(hashes, ReadRecords(options.folder));
    std::vector<std::string> due;
    for (const BakeMaterial& material : tree.materials) {
        try {
            if (!material.error && MakeTask(options, material, hashes).reason.empty())
                continue;
        } catch (const CommandError&) {
            ThrowIfInterrupted();
        }
        if (!material.error)
            due.push_back(material.name);
    }
    return due;
}

int BakeOptions::GetThreads(int count) const {
    const int cores = std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
    return givenThreads > 0 || count <= 1 ? givenThreads : std::max(cores / count, 1);
}

std::string GetProgramPath() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    return error ? "ntc" : program.string();
}

std::string QuoteForShell(const std::string& text) {
    constexpr std::string_view kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=+,:@%";
    if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos)
        return text;
    std::string quoted = "'";
    for (const char c : text)
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

} // namespace openntc::tool
