// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: the materials of a glTF model to texture sets and a list of them.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"
#include "encode/ContentKey.h"
#include "encode/InputArguments.h"
#include "encode/StateFile.h"
#include "encode/TextureNames.h"
#include "encode/TrainingArguments.h"
#include "gltf/GltfSets.h"
#include "gltf/KeptManifest.h"
#include "gltf/MaterialList.h"

#include "openntc/core/Crc32.h"

#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <filesystem>
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
    InputOptions inputs; ///< without paths
    int jobs = 1;
    bool skipExisting = false;
    bool keepManifests = false;
    bool quiet = false;
    bool json = false;
};

class ConvertCommand {
public:
    explicit ConvertCommand(const ConvertGltfOptions& options) : options_(options) {
        for (GltfMaterial& material : ReadGltfMaterials(options.model))
            materials_.push_back({std::move(material), {}});
        CheckOptions();
    }

    int Run() {
        ListFiles();
        const bool isNew = MakeFolder();
        KeepFinishedFiles(options_.folder, files_, options_.skipExisting);
        if (options_.keepManifests) {
            for (const OutputFile& file : files_)
                KeepManifest(*file.job.inputs.manifest, options_.folder,
                             file.name.substr(0, file.name.size() - kExtension.size()));
        }
        EncodeAll();
        // A model of which nothing could be encoded leaves what was there before.
        const bool hasResult =
            !HasFailed() ||
            std::any_of(files_.begin(), files_.end(), [](const OutputFile& file) { return file.finished; });
        if (hasResult)
            WriteResult();
        else if (isNew)
            RemoveFolder();
        return PrintErrors();
    }

private:
    static constexpr std::string_view kExtension = ".ntc";

    /// What the options say of textures must be of at least one material.
    void CheckOptions() const {
        TextureNames names;
        bool hasAlpha = false;
        for (const ConvertedMaterial& converted : materials_) {
            const Manifest manifest = MakeManifest(converted.material);
            names.Add(manifest);
            hasAlpha = hasAlpha || HasAlpha(manifest);
        }
        if (const auto error = names.FindUnknown(options_.inputs, options_.training))
            throw CommandError(*error);
        if (options_.inputs.keepCoverage > 0.0f && !hasAlpha)
            FailUsage("--keep-coverage", "no material has alpha: alphaMode MASK or BLEND");
    }

    std::string GetPath(const std::string& name) const {
        return (std::filesystem::path(options_.folder) / name).string();
    }

    /// True if there was none.
    bool MakeFolder() const {
        std::error_code error;
        const bool exists = std::filesystem::exists(options_.folder, error);
        std::filesystem::create_directories(options_.folder, error);
        if (error)
            throw CommandError(ExitCode::Failed, options_.folder,
                               "folder: cannot be made: " + error.message());
        return !exists;
    }
    void RemoveFolder() const {
        std::error_code ignored;
        std::filesystem::remove(options_.folder, ignored); // only an empty one
    }

    void Warn(const std::string& text) const { PrintWarning(options_.model + ": " + text, options_.json); }

    void ListFiles() {
        GltfSetPlanner planner(options_.training.strict, [this](const Manifest& manifest) {
            return MakeContentKey(MakeJob(manifest));
        });
        for (ConvertedMaterial& material : materials_)
            planner.Add(material);
        for (const std::string& warning : planner.GetWarnings())
            Warn(warning);
        code_ = planner.GetCode();
        for (GltfSet& set : planner.GetSets()) {
            OutputFile file;
            file.name = set.name + std::string(kExtension);
            file.key = std::move(set.key);
            file.job = MakeJob(std::move(set.manifest));
            file.job.output = GetPath(file.name);
            file.job.json = options_.json;
            file.job.quiet = options_.quiet || options_.jobs > 1;
            file.job.isAlone = options_.jobs == 1;
            file.job.keepsState = false; // the same command begins an unfinished file again
            files_.push_back(std::move(file));
        }
    }
    EncodeJob MakeJob(Manifest manifest) const {
        EncodeJob job;
        job.inputs = options_.inputs;
        job.inputs.paths = {options_.model};
        if (!HasAlpha(manifest))
            job.inputs.keepCoverage = 0.0f;
        job.inputs.manifest = std::move(manifest);
        job.inputs.strict = options_.training.strict;
        job.training = options_.training;
        KeepOwnNames(job);
        return job;
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
                EncodeOne(i);
            }
        };
        std::vector<std::thread> workers;
        for (int i = 1; i < jobs; ++i)
            workers.emplace_back(work);
        work();
        for (std::thread& worker : workers)
            worker.join();
        if (IsInterrupted() && failures_.empty())
            failures_.emplace_back(ExitCode::Failed, options_.model, "interrupted: finished files are kept");
    }

    void EncodeOne(std::size_t index) {
        OutputFile& file = files_[index];
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
            CheckGoals(file.job, encoded);
        } catch (const CommandError& error) {
            Remember(index, error);
        } catch (const std::bad_alloc&) {
            Remember(index, CommandError(ExitCode::Failed, file.job.output, "memory: refused by the system"));
        }
    }

    /// An error about an image becomes one of every material that has it, and names the slot; others are
    /// about the file.
    void Remember(std::size_t index, const CommandError& error) {
        const std::lock_guard lock(mutex_);
        bool isOfImage = false;
        for (ConvertedMaterial& converted : materials_) {
            for (std::size_t i = 0; i < converted.files.size(); ++i) {
                const GltfTexture& texture = converted.material.textures[i];
                if (converted.files[i] != index || texture.source.path != error.GetSubject())
                    continue;
                converted.material.errors.push_back(texture.slot + ": " + texture.image + ": " +
                                                    error.what());
                isOfImage = true;
                break;
            }
        }
        if (!isOfImage)
            failures_.push_back(error);
        else
            code_ = code_.value_or(error.GetCode());
    }
    bool HasFailed() const { return code_.has_value() || !failures_.empty(); }

    int PrintErrors() const {
        for (const ConvertedMaterial& converted : materials_) {
            for (const std::string& error : converted.material.errors)
                std::fprintf(stderr, "%s\n", CommandError(*code_, options_.model, error).GetLine().c_str());
        }
        for (const CommandError& failure : failures_)
            std::fprintf(stderr, "%s\n", failure.GetLine().c_str());
        if (code_)
            return static_cast<int>(*code_);
        return static_cast<int>(failures_.empty() ? ExitCode::Ok : failures_.front().GetCode());
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

    std::string MakeList() const {
        return MakeMaterialList(GetRelativePath(options_.model, options_.folder), materials_, files_);
    }
    void WriteList() const {
        const std::string text = MakeList();
        WriteWholeFile(GetPath(kMaterialListName), {std::as_bytes(std::span(text))});
    }
    void WriteResult() const {
        WriteList();
        if (options_.json) {
            WriteOutput(MakeList());
        } else {
            for (const OutputFile& file : files_) {
                if (file.finished)
                    WriteOutput(Format("%s: %" PRIu64 " bytes%s\n", file.job.output.c_str(), file.bytes,
                                       file.kept ? ", kept" : ""));
            }
            WriteOutput(GetPath(kMaterialListName) + "\n");
        }
        FinishOutput();
    }

    const ConvertGltfOptions& options_;
    std::vector<ConvertedMaterial> materials_;
    std::vector<OutputFile> files_;
    std::mutex mutex_;
    std::optional<ExitCode> code_; ///< of the first error of a material
    std::vector<CommandError> failures_;
};

} // namespace

void AddConvertGltfCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ConvertGltfOptions>();
    CLI::App* command = app.add_subcommand(
        "convert-gltf", "Encode the materials of a glTF model: one file per distinct material");
    command
        ->add_option("MODEL", options->model,
                     "Model (.gltf or .glb); its images are separate files or part of it")
        ->required();
    command->add_option("-o,--output", options->folder, "Folder for the files and materials.json")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    AddTrainingOptions(*command, options->training);
    AddInputOptions(*command, options->inputs);
    AddNumberOption(*command, "--jobs", options->jobs, {1, 64},
                    "Materials encoded at the same time (default 1)");
    command->add_flag("--skip-existing", options->skipExisting,
                      "Keep every file that is there, also when it was made with other options or images");
    command->add_flag("--keep-manifests", options->keepManifests,
                      "Also write NAME.manifest.json for every file, from which `ntc encode` makes it again");
    command->add_flag("--quiet", options->quiet, "No progress");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return ConvertCommand(*options).Run(); }; });
}

} // namespace openntc::tool
