// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: the materials of a glTF model to texture sets and a list of them.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "FileNames.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"
#include "encode/StateFile.h"
#include "encode/TrainingArguments.h"
#include "gltf/ContentKey.h"
#include "gltf/GltfMaterials.h"

#include "openntc/core/Crc32.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

namespace openntc::tool {

namespace {

struct ConvertGltfOptions {
    std::string model;
    std::string folder;
    TrainingChoices training;
    int mips = 0;
    int jobs = 1;
    bool skipExisting = false;
    bool quiet = false;
    bool json = false;
};

/// One texture set to make, for one or more materials.
struct OutputFile {
    std::string name; ///< inside the folder
    std::string key;
    EncodeJob job;
    bool finished = false;
    bool kept = false; ///< of an earlier run
    double psnr = 0.0;
    double bitsPerPixel = 0.0;
    std::uint64_t bytes = 0;
    std::uint32_t crc = 0;
};

class ConvertCommand {
public:
    explicit ConvertCommand(const ConvertGltfOptions& options)
        : options_(options), materials_(ReadGltfMaterials(options.model)) {}

    int Run() {
        std::error_code error;
        std::filesystem::create_directories(options_.folder, error);
        if (!std::filesystem::is_directory(options_.folder, error))
            throw CommandError(ExitCode::Failed, options_.folder, "folder: cannot be made");
        ListFiles();
        KeepFinished();
        EncodeAll();
        WriteList();
        if (options_.json)
            WriteOutput(MakeList());
        else
            Print();
        FinishOutput();
        if (failure_)
            throw CommandError(*failure_);
        return 0;
    }

private:
    std::string GetPath(const std::string& name) const {
        return (std::filesystem::path(options_.folder) / name).string();
    }

    /// Materials with equal images share a file.
    void ListFiles() {
        FileNames names;
        std::map<std::string, std::size_t> byKey;
        for (const GltfMaterial& material : materials_) {
            if (material.manifest.textures.empty()) {
                fileOf_.push_back(std::nullopt);
                continue;
            }
            OutputFile file;
            file.job.inputs.paths = {options_.model};
            file.job.inputs.manifest = material.manifest;
            file.job.inputs.mips = options_.mips;
            file.job.inputs.strict = options_.training.strict;
            file.job.training = options_.training;
            file.key = MakeContentKey(file.job);
            const auto [found, isNew] = byKey.emplace(file.key, files_.size());
            fileOf_.push_back(found->second);
            if (!isNew)
                continue;
            file.name = names.Add(material.name) + ".ntc";
            file.job.output = GetPath(file.name);
            file.job.json = options_.json;
            file.job.quiet = options_.quiet || options_.jobs > 1;
            file.job.keepsState = false; // the same command begins an unfinished file again
            files_.push_back(std::move(file));
        }
    }

    /// Files that the list of an earlier run has under the same key, unchanged since.
    void KeepFinished() {
        std::error_code error;
        const std::string path = GetPath(kListName);
        rapidjson::Document list;
        if (std::filesystem::is_regular_file(path, error)) {
            const std::vector<std::byte> text = ReadAll(path);
            list.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(text.data()),
                                                       text.size());
        }
        for (OutputFile& file : files_) {
            if (!std::filesystem::is_regular_file(file.job.output, error))
                continue;
            const std::vector<std::byte> bytes = ReadAll(file.job.output);
            const bool isSame = FindFinished(list, file, bytes);
            if (!isSame && !options_.skipExisting)
                continue;
            file.kept = file.finished = true;
            file.bytes = bytes.size();
            file.crc = Crc32(bytes);
            if (!isSame)
                file.key.clear(); // unknown: made from something else
        }
    }
    static bool FindFinished(const rapidjson::Document& list, OutputFile& file,
                             const std::vector<std::byte>& bytes) {
        if (list.HasParseError() || !list.IsObject() || !list.HasMember("files") || !list["files"].IsArray())
            return false;
        const auto number = [](const rapidjson::Value& entry, const char* name) {
            const auto member = entry.FindMember(name);
            return member != entry.MemberEnd() && member->value.IsNumber() ? member->value.GetDouble() : 0.0;
        };
        for (const rapidjson::Value& entry : list["files"].GetArray()) {
            if (!entry.IsObject() || !entry.HasMember("key") || !entry["key"].IsString() ||
                file.key != entry["key"].GetString())
                continue;
            file.psnr = number(entry, "psnr");
            file.bitsPerPixel = number(entry, "bitsPerPixel");
            return entry.HasMember("file") && entry["file"].IsString() &&
                   file.name == entry["file"].GetString() &&
                   number(entry, "bytes") == static_cast<double>(bytes.size()) &&
                   number(entry, "crc32") == static_cast<double>(Crc32(bytes));
        }
        return false;
    }

    void EncodeAll() {
        const int cores = std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
        const int jobs =
            std::clamp(options_.jobs, 1, static_cast<int>(std::max<std::size_t>(files_.size(), 1)));
        std::atomic<std::size_t> next{0};
        const auto work = [&] {
            for (std::size_t i = next++; i < files_.size() && !IsInterrupted(); i = next++) {
                if (files_[i].finished)
                    continue;
                if (jobs > 1 && files_[i].job.training.encode.threads == 0)
                    files_[i].job.training.encode.threads = std::max(cores / jobs, 1);
                EncodeOne(files_[i]);
            }
        };
        std::vector<std::thread> workers;
        for (int i = 1; i < jobs; ++i)
            workers.emplace_back(work);
        work();
        for (std::thread& worker : workers)
            worker.join();
        if (IsInterrupted() && !failure_)
            failure_.emplace(ExitCode::Failed, options_.model, "interrupted: finished files are kept");
    }

    void EncodeOne(OutputFile& file) {
        try {
            const EncodedFile encoded = RunEncodeJob(file.job);
            const std::lock_guard lock(mutex_);
            file.psnr = encoded.result.psnr;
            file.bitsPerPixel = static_cast<double>(GetLatentShapeBitsPerPixel(encoded.result.latentShape));
            file.bytes = encoded.bytes;
            file.crc = Crc32(encoded.result.file);
            file.finished = true;
            WriteList(); // so that an interrupted conversion keeps what it has
            Announce(file);
            CheckGoals(file.job, encoded.result);
        } catch (const CommandError& error) {
            Remember(error);
        } catch (const std::bad_alloc&) {
            Remember(CommandError(ExitCode::Failed, file.job.output, "memory: refused by the system"));
        }
    }
    void Remember(const CommandError& error) {
        const std::lock_guard lock(mutex_);
        if (!failure_)
            failure_.emplace(error);
        else
            std::fprintf(stderr, "%s\n", error.GetLine().c_str());
    }
    void Announce(const OutputFile& file) const {
        if (options_.quiet)
            return;
        const auto done = std::count_if(files_.begin(), files_.end(),
                                        [](const OutputFile& other) { return other.finished; });
        if (options_.json)
            std::fprintf(stderr, "{\"event\":\"file\",\"file\":\"%s\",\"done\":%zu,\"total\":%zu}\n",
                         file.name.c_str(), static_cast<std::size_t>(done), files_.size());
        else
            std::fprintf(stderr, "[%zu/%zu] %s: %.2f dB, %" PRIu64 " bytes\n", static_cast<std::size_t>(done),
                         files_.size(), file.name.c_str(), file.psnr, file.bytes);
    }

    void WriteList() const {
        const std::string text = MakeList();
        WriteWholeFile(GetPath(kListName), {std::as_bytes(std::span(text))});
    }
    std::string MakeList() const {
        JsonWriter json;
        json.BeginObject();
        json.Member("model", std::string_view(options_.model));
        json.Key("materials");
        json.BeginArray();
        for (std::size_t i = 0; i < materials_.size(); ++i) {
            json.BeginObject();
            json.Member("name", std::string_view(materials_[i].name));
            json.Key("file");
            if (fileOf_[i] && files_[*fileOf_[i]].finished)
                json.Value(std::string_view(files_[*fileOf_[i]].name));
            else
                json.Null();
            json.Key("textures");
            json.BeginArray();
            for (const ManifestTexture& texture : materials_[i].manifest.textures) {
                json.BeginObject();
                json.Member("name", std::string_view(texture.name));
                json.Member("firstChannel", texture.firstChannel);
                json.EndObject();
            }
            json.EndArray();
            json.EndObject();
        }
        json.EndArray();
        json.Key("files");
        json.BeginArray();
        for (const OutputFile& file : files_) {
            if (!file.finished)
                continue;
            json.BeginObject();
            json.Member("file", std::string_view(file.name));
            json.Member("key", std::string_view(file.key));
            json.Member("bytes", file.bytes);
            json.Member("crc32", file.crc);
            json.Member("bitsPerPixel", file.bitsPerPixel);
            json.Member("psnr", file.psnr);
            json.Member("kept", file.kept);
            json.EndObject();
        }
        json.EndArray();
        json.EndObject();
        return json.Take();
    }
    void Print() const {
        for (const OutputFile& file : files_) {
            if (file.finished)
                WriteOutput(Format("%s: %" PRIu64 " bytes%s\n", file.job.output.c_str(), file.bytes,
                                   file.kept ? ", kept" : ""));
        }
        WriteOutput(GetPath(kListName) + "\n");
    }

    static constexpr const char* kListName = "materials.json";

    const ConvertGltfOptions& options_;
    std::vector<GltfMaterial> materials_;
    std::vector<std::optional<std::size_t>> fileOf_; ///< per material
    std::vector<OutputFile> files_;
    std::mutex mutex_;
    std::optional<CommandError> failure_; ///< the first
};

} // namespace

void AddConvertGltfCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ConvertGltfOptions>();
    CLI::App* command = app.add_subcommand(
        "convert-gltf", "Encode the materials of a glTF model: one file per distinct material");
    command->add_option("MODEL", options->model, "Model (.gltf) with separate images")->required();
    command->add_option("-o,--output", options->folder, "Folder for the files and materials.json")
        ->required()
        ->type_name("DIR");
    AddTrainingOptions(*command, options->training);
    command->add_option("--mips", options->mips, "Number of mips (default: the full chain)")
        ->check(CLI::Range(1, 16))
        ->type_name("N");
    command->add_option("--jobs", options->jobs, "Materials encoded at the same time (default 1)")
        ->check(CLI::Range(1, 64))
        ->type_name("N");
    command->add_flag("--skip-existing", options->skipExisting,
                      "Keep every file that is there, also when it was made with other options or images");
    command->add_flag("--quiet", options->quiet, "No progress");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return ConvertCommand(*options).Run(); }; });
}

} // namespace openntc::tool
