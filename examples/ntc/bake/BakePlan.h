// SPDX-License-Identifier: MIT
// What is to be done for every material of a tree, and the plans for engines that do it on many machines.
#pragma once

#include "bake/BakeRecord.h"
#include "bake/MaterialTree.h"
#include "encode/EncodeJob.h"

#include <string>
#include <vector>

namespace openntc::tool {

struct BakeOptions {
    TreeOptions tree; ///< its output is `folder`
    std::string folder;
    TrainingChoices training;
    InputOptions inputs; ///< of all materials: without paths
    int jobs = 1;
    double saveSeconds = 120.0;
    bool prunes = false;
    bool isDryRun = false;
    bool quiet = false;
    bool json = false;
    std::string depfile;  ///< Make's rule of what decides the one material that is wanted; empty: none
    int givenThreads = 0; ///< what the user says; 0: nothing
    std::vector<std::string> passed; ///< command line of the settings above, for commands of a plan
    bool usesGpu = false;

    bool IsPart() const { return !tree.wanted.empty(); }
    /// Of each of `count` materials that are made at the same time; 0: all cores.
    int GetThreads(int count) const;
};

/// A material, and whether its file is as it should be.
struct BakeTask {
    BakeMaterial material;
    std::string output;
    std::optional<BakeRecord> record; ///< of the file that is there
    std::vector<BakeSource> images;   ///< as they are now; none where there is no record
    std::string reason;               ///< why it is made anew: `new`, `settings`, …; empty: it is unchanged
};

/// Settings of a material's encoding; without state and progress.
EncodeJob MakeBakeJob(const BakeOptions& options, const BakeMaterial& material, Manifest manifest);

/// The content key of a job; `images` are its files, `embedded` the digests of embedded images whose bytes are not there.
std::string MakeBakeKey(const EncodeJob& job, const std::map<std::string, std::string>& embedded,
                        std::span<const BakeSource> images);

/// What earlier runs know of images.
void RememberSources(SourceHashes& hashes, std::span<const BakeRecord> records);

/// Images of a material as they are now. Throws CommandError(BadInput).
std::vector<BakeSource> ListImages(const BakeMaterial& material, SourceHashes& hashes);

/// Compares a material with its record. Throws CommandError(BadInput) for images that cannot be read.
BakeTask MakeTask(const BakeOptions& options, BakeMaterial material, SourceHashes& hashes);

/// Of the records of DIR those whose materials were found under an input of this bake, and are there no longer.
std::vector<BakeRecord> FindVanished(const BakeOptions& options, const MaterialTree& tree,
                                     std::span<const BakeRecord> records);

/// DIR/build.ninja, for all materials. Returns its path; an equal plan is left alone.
std::string WriteNinjaPlan(const BakeOptions& options, const MaterialTree& tree);

/// Materials that are not as they should be, by name. Images that cannot be read are left to those who make them.
std::vector<std::string> ListDue(const BakeOptions& options, const MaterialTree& tree);

/// DIR/bake.sbatch, which makes these materials.
std::string WriteSlurmPlan(const BakeOptions& options, const std::vector<std::string>& materials);

/// The program that runs now, for commands of a plan.
std::string GetProgramPath();

/// `text` as one word of a POSIX shell.
std::string QuoteForShell(const std::string& text);

} // namespace openntc::tool
