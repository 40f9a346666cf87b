// SPDX-License-Identifier: MIT
#include "bake/BakeRun.h"

#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"
#include "bake/BakeFiles.h"
#include "bake/BakeProgress.h"
#include "bake/Depfile.h"
#include "bake/FolderLock.h"
#include "encode/ContentKey.h"
#include "encode/StateFile.h"

#include "openntc/core/Crc32.h"

#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <filesystem>
#include <memory>
#include <new>
#include <thread>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

class BakeRunner {
public:
    BakeRunner(const BakeOptions& options, MaterialTree tree) : options_(options), tree_(std::move(tree)) {
        if (!options.isDryRun)
            lock_.emplace(options.folder,
                          options.IsPart() ? FolderLock::Scope::Part : FolderLock::Scope::Whole);
    }

    int Run() {
        if (!options_.IsPart()) {
            const std::vector<BakeRecord> records = ReadRecords(options_.folder);
            RememberSources(hashes_, records);
            vanished_ = FindVanished(options_, tree_, records);
        }
        for (BakeMaterial& material : tree_.materials)
            Compare(std::move(material));
        if (!options_.isDryRun) {
            MakeAll();
            for (const BakeModel& model : tree_.models)
                WriteModelList(model);
            for (const BakeRecord& record : vanished_) {
                if (options_.prunes)
                    RemoveMaterial(options_.folder, record.name);
            }
            if (!options_.depfile.empty())
                WriteDepfile(options_.depfile,
                             {{tasks_.front().material.name + ".ntc", ListSources(tasks_.front().material)}});
        }
        return PrintResult(options_, outcomes_, vanished_);
    }

private:
    void Compare(BakeMaterial material) {
        BakeOutcome outcome{material.name, BakeStatus::Due, {}, {}, {}};
        BakeTask task;
        try {
            if (material.error)
                throw CommandError(*material.error);
            if (options_.IsPart()) {
                if (const auto record =
                        ReadRecord(GetRecordPath(options_.folder, material.name), options_.folder))
                    RememberSources(hashes_, {&*record, 1});
            }
            task = MakeTask(options_, material, hashes_);
            outcome.reason = task.reason;
            if (task.reason.empty())
                Keep(task, outcome);
        } catch (const CommandError& error) {
            ThrowIfInterrupted();
            Fail(outcome, error);
            task.material = std::move(material);
        }
        if (outcome.status == BakeStatus::Due)
            due_.push_back(tasks_.size());
        outcomes_.push_back(std::move(outcome));
        tasks_.push_back(std::move(task));
    }

    /// A file that misses a goal of its user misses it for as long as it stays.
    void Keep(const BakeTask& task, BakeOutcome& outcome) const {
        outcome.status = BakeStatus::Unchanged;
        outcome.record = task.record;
        if (!options_.isDryRun &&
            task.images != task.record->sources) { // touched: next time nobody reads them again
            BakeRecord record = *task.record;
            record.sources = task.images;
            WriteRecord(record, options_.folder);
        }
        if (!task.record->missed.empty())
            Fail(outcome, CommandError(ExitCode::Failed, task.output, task.record->missed));
    }

    static void Fail(BakeOutcome& outcome, const CommandError& error) {
        outcome.status = BakeStatus::Failed;
        outcome.error = Printable(outcome.name + ": " + error.GetSubject() + ": " + error.what());
    }

    void MakeAll() {
        progress_ = std::make_unique<BakeProgress>(options_, tasks_.size(), due_.size());
        const int jobs =
            std::clamp(options_.jobs, 1, static_cast<int>(std::max<std::size_t>(due_.size(), 1)));
        threads_ = options_.GetThreads(jobs);
        std::atomic<std::size_t> next{0};
        const auto work = [&] {
            for (std::size_t i = next++; i < due_.size() && !IsInterrupted(); i = next++)
                MakeOne(due_[i]);
        };
        std::vector<std::thread> workers;
        for (int i = 1; i < jobs; ++i)
            workers.emplace_back(work);
        work();
        for (std::thread& worker : workers)
            worker.join();
    }

    void MakeOne(std::size_t index) {
        BakeTask& task = tasks_[index];
        BakeOutcome& outcome = outcomes_[index];
        const std::string name = task.material.name;
        try {
            lock_->LockName(name);
            if (options_.IsPart()) // who had the lock may have made it
                task = MakeTask(options_, std::move(task.material), hashes_);
            if (task.reason.empty())
                Keep(task, outcome);
            else
                Encode(index, task, outcome);
            lock_->UnlockName(name);
        } catch (const CommandError& error) {
            lock_->UnlockName(name);
            if (IsInterrupted())
                outcome.status = BakeStatus::Interrupted;
            else
                Fail(outcome, error);
        } catch (const std::bad_alloc&) {
            lock_->UnlockName(name);
            Fail(outcome, CommandError(ExitCode::Failed, "memory", "allocation: refused by the system"));
        }
        progress_->Finish(index, outcome);
    }

    void Encode(std::size_t index, const BakeTask& task, BakeOutcome& outcome) {
        const BakeMaterial& material = task.material;
        EncodeJob job = MakeBakeJob(options_, material, LoadManifest(material, options_.training.strict));
        const std::vector<BakeSource> images = ListImages(material, hashes_);
        const std::string key = MakeBakeKey(job, {}, images);
        job.training.encode.threads = threads_;
        job.saveSeconds = options_.saveSeconds;
        job.isAlone = options_.jobs == 1;
        job.statePath = GetBakeStatePath(options_.folder, material.name, key);
        job.watch = [this, index](const encode::Progress& progress) {
            progress_->Advance(index, progress.fraction);
        };
        RemoveLeftovers(options_.folder, material.name, key);
        MakeFolderOf(job.output);
        MakeFolderOf(job.statePath);

        const EncodedFile encoded = EncodeOrResume(job);
        for (const BakeSource& image : images) {
            if (ReadStamp(image.path) != image.hash.stamp)
                throw CommandError(
                    ExitCode::Failed, image.path,
                    "image: changed while it was being encoded: the next bake makes the file anew");
        }
        BakeRecord record;
        record.name = material.name;
        record.root = GetAbsolutePath(material.root);
        record.origin = GetAbsolutePath(material.origin);
        record.key = key;
        record.settings = MakeSettingsKey(job);
        record.kernel = encoded.result.kernel;
        record.output = ReadStamp(job.output).value_or(FileStamp{});
        record.crc = Crc32(encoded.result.file);
        record.psnr = encoded.result.psnr;
        record.bitsPerPixel = static_cast<double>(GetLatentShapeBitsPerPixel(encoded.result.latentShape));
        record.steps = encoded.result.steps;
        record.sources = images;
        try {
            CheckGoals(job, encoded);
        } catch (const CommandError& error) {
            record.missed = error.what();
        }
        WriteRecord(record, options_.folder);
        outcome.status = BakeStatus::Made;
        outcome.record = record;
        if (!record.missed.empty())
            Fail(outcome, CommandError(ExitCode::Failed, job.output, record.missed));
    }

    EncodedFile EncodeOrResume(EncodeJob& job) const {
        std::error_code error;
        job.resume = fs::is_regular_file(job.statePath, error);
        if (!job.resume)
            return RunEncodeJob(job);
        try {
            return RunEncodeJob(job);
        } catch (const CommandError& failure) {
            if (failure.GetCode() != ExitCode::BadInput)
                throw;
            PrintWarning(job.statePath + ": " + failure.what() + ": begun again", options_.json);
        }
        fs::remove(job.statePath, error);
        job.resume = false;
        return RunEncodeJob(job);
    }

    /// From the records, because sets of a model may be made by several processes: the last one lists all.
    void WriteModelList(const BakeModel& model) {
        std::vector<OutputFile> files;
        lock_->LockName("list of " + model.name);
        for (const std::string& set : model.sets) {
            OutputFile file;
            file.name = set + ".ntc";
            const std::string name = model.name + "/" + set;
            if (const auto record = ReadRecord(GetRecordPath(options_.folder, name), options_.folder)) {
                file.key = record->key;
                file.psnr = record->psnr;
                file.bitsPerPixel = record->bitsPerPixel;
                file.bytes = record->output.bytes;
                file.crc = record->crc;
                file.finished = true;
            }
            files.push_back(std::move(file));
        }
        const fs::path folder = fs::path(options_.folder) / model.name;
        if (std::any_of(files.begin(), files.end(), [](const OutputFile& file) { return file.finished; })) {
            MakeFolderOf(folder / kMaterialListName);
            WriteIfDifferent(
                (folder / kMaterialListName).string(),
                MakeMaterialList(GetRelativePath(model.path, folder.string()), model.materials, files));
        }
        lock_->UnlockName("list of " + model.name);
    }

    const BakeOptions& options_;
    MaterialTree tree_;
    std::optional<FolderLock> lock_; // none of a dry run
    SourceHashes hashes_;
    std::vector<BakeTask> tasks_;
    std::vector<BakeOutcome> outcomes_; // of the tasks
    std::vector<std::size_t> due_;
    std::vector<BakeRecord> vanished_;
    std::unique_ptr<BakeProgress> progress_;
    int threads_ = 0;
};

} // namespace

int RunBake(const BakeOptions& options, MaterialTree tree) {
    return BakeRunner(options, std::move(tree)).Run();
}

} // namespace openntc::tool
