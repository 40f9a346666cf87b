// SPDX-License-Identifier: MIT
#include "bake/BakeFiles.h"
#include "bake/BakePlan.h"

#include "Output.h"
#include "encode/StateFile.h"

#include <algorithm>
#include <filesystem>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTasks = 1000; // of an array, where a site does not raise Slurm's MaxArraySize
constexpr int kTaskThreads = 4;          // where the user says none

/// What a task does, after the lists of the plan. Slurm signals every process of a task that is preempted, requeued or
/// cancelled: a second signal from here would end ntc before it has kept its states. Before the time limit the script alone
/// is told.
constexpr const char* kTaskScript = R"(
mine=()
for ((i = SLURM_ARRAY_TASK_ID; i < ${#materials[@]}; i += tasks)); do
    mine+=(--material "${materials[i]}")
done

out_of_time=0
worker=
trap : TERM
trap 'out_of_time=1; [[ -z "$worker" ]] || kill -TERM "$worker"' USR1
"${bake[@]}" --threads "${SLURM_CPUS_PER_TASK:-$threads}" "${mine[@]}" &
worker=$!
if [[ "$out_of_time" -eq 1 ]]; then
    kill -TERM "$worker"
fi
code=143
while [[ "$code" -gt 128 ]] && kill -0 "$worker" 2>/dev/null; do
    wait "$worker"
    code=$?
done
if [[ "$out_of_time" -eq 1 && "$code" -ne 0 ]]; then
    # Not SLURM_JOB_ID: of the array's last task that is the number of the whole array.
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
)";

} // namespace

std::string WriteSlurmPlan(const BakeOptions& options, const std::vector<std::string>& materials) {
    std::string path = (fs::path(options.folder) / "bake.sbatch").string();
    const std::string folder = GetAbsolutePath(options.folder);
    const std::size_t tasks = std::min(materials.size(), kMostTasks);
    const int threads = options.givenThreads > 0 ? options.givenThreads : kTaskThreads;
    std::string text = "#!/bin/bash\n";
    text += Format(
        "# Written by `ntc bake --plan slurm`: %zu materials in %zu tasks. Options go before the script:\n"
        "#   sbatch --partition=NAME --time=8:00:00 bake.sbatch\n",
        materials.size(), tasks);
    text += Format("#SBATCH --job-name=ntc-bake\n#SBATCH --array=0-%zu", tasks - 1) +
            (options.jobs > 1 ? Format("%%%d", options.jobs) : "") + "\n";
    text += Format("#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=%d\n", threads);
    if (options.usesGpu)
        text += "#SBATCH --gres=gpu:1\n";
    text += "#SBATCH --requeue\n#SBATCH --open-mode=append\n#SBATCH --signal=B:USR1@120\n";
    text += "#SBATCH --chdir=" + QuoteForShell(folder) + "\n#SBATCH --output=.bake/slurm-%A_%a.log\n\n";
    text += Format("tasks=%zu\nthreads=%d\n", tasks, threads);
    text += "bake=(" + QuoteForShell(GetProgramPath()) + " bake";
    for (const std::string& input : options.tree.inputs)
        text += " " + QuoteForShell(GetAbsolutePath(input));
    text += " -o " + QuoteForShell(folder);
    for (const std::string& word : options.passed)
        text += " " + QuoteForShell(word);
    text += ")\nmaterials=(\n";
    for (const std::string& material : materials)
        text += "    " + QuoteForShell(material) + "\n";
    text += ")\n";
    text += kTaskScript;
    MakeFolderOf(fs::path(GetBakeFolder(options.folder)) / "slurm");
    WriteWholeFile(path, {std::as_bytes(std::span(text))});
    return path;
}

} // namespace openntc::tool
