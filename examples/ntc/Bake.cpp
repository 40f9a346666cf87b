// SPDX-License-Identifier: MIT
// `ntc bake`: every material under a tree to a texture set, again only where something changed.
#include "Arguments.h"
#include "Commands.h"
#include "Output.h"
#include "Progress.h"
#include "bake/BakeRun.h"
#include "encode/InputArguments.h"
#include "encode/TextureNames.h"
#include "encode/TrainingArguments.h"

#include <algorithm>
#include <memory>
#include <thread>

namespace openntc::tool {

namespace {

struct BakeArguments {
    BakeOptions bake;
    std::vector<std::string> materials;
    std::string plan;
};

/// The options that decide what files are made of, as the user wrote them.
std::vector<std::string> GetPassedOptions(CLI::App& command, const std::vector<CLI::Option*>& settings) {
    std::vector<std::string> words;
    for (const CLI::Option* option : command.get_options()) {
        if (option->count() == 0 || std::find(settings.begin(), settings.end(), option) == settings.end())
            continue;
        if (option->get_type_size() == 0)
            words.push_back(option->get_name());
        else
            for (const std::string& value : option->results()) // repeated ones take one value each
                words.insert(words.end(), {option->get_name(), value});
    }
    return words;
}

int WritePlan(const BakeArguments& arguments, const MaterialTree& tree) {
    const BakeOptions& options = arguments.bake;
    for (const BakeMaterial& material : tree.materials) {
        if (material.error)
            PrintWarning(material.name + ": " + material.error->GetSubject() + ": " + material.error->what(),
                         options.json);
    }
    if (arguments.plan == "ninja") {
        const std::string path = WriteNinjaPlan(options, tree);
        if (!options.quiet)
            WriteOutput(Format("%s: materials: %zu: ninja -C %s\n", path.c_str(), tree.materials.size(),
                               options.folder.c_str()));
        return 0;
    }
    const std::vector<std::string> due = ListDue(options, tree);
    if (due.empty()) {
        WriteOutput(Format("%zu materials: nothing to make: no script was written\n", tree.materials.size()));
        return 0;
    }
    const std::string path = WriteSlurmPlan(options, due);
    WriteOutput(Format("%s: %zu of %zu materials: sbatch %s\n", path.c_str(), due.size(),
                       tree.materials.size(), path.c_str()));
    return 0;
}

/// What options say of a texture must be of at least one material. Of those that are broken today nobody knows the textures.
void CheckNames(const BakeOptions& options, const MaterialTree& tree) {
    TextureNames names;
    bool isWhole = tree.isWhole;
    for (const BakeMaterial& material : tree.materials) {
        names.Add(material.manifest);
        isWhole = isWhole && !material.error;
    }
    const auto unknown = names.FindUnknown(options.inputs, options.training);
    if (unknown && isWhole)
        throw CommandError(*unknown);
    if (unknown)
        PrintWarning(unknown->GetSubject() + ": " + unknown->what(), options.json);
}

int Bake(const BakeArguments& arguments) {
    const BakeOptions& options = arguments.bake;
    MaterialTree tree = FindMaterials(options.tree);
    if (!options.IsPart()) { // each part would say them again, and a part knows few textures
        for (const std::string& warning : tree.warnings)
            PrintWarning(warning, options.json);
        CheckNames(options, tree);
    }
    if (tree.materials.empty())
        throw CommandError(ExitCode::BadInput, options.tree.inputs.front(),
                           "materials: none: no manifest, no model with images and no images");
    return arguments.plan.empty() ? RunBake(options, std::move(tree)) : WritePlan(arguments, tree);
}

void CheckArguments(BakeArguments& arguments) {
    BakeOptions& options = arguments.bake;
    if (!arguments.plan.empty() && arguments.plan != "ninja" && arguments.plan != "slurm")
        FailUsage("--plan", arguments.plan + ": ninja, slurm");
    options.tree.wanted.insert(arguments.materials.begin(), arguments.materials.end());
    if (!options.depfile.empty() && options.tree.wanted.size() != 1 && arguments.plan != "ninja")
        FailUsage("--depfile", "needs one --material, or --plan ninja");
    options.tree.output = options.folder;
    options.tree.strict = options.training.strict;
    options.givenThreads = options.training.encode.threads;
}

} // namespace

void AddBakeCommand(CLI::App& app, Action& action) {
    auto arguments = std::make_shared<BakeArguments>();
    BakeOptions& options = arguments->bake;
    CLI::App* command =
        app.add_subcommand("bake", "Encode every material under a tree; again only what changed");
    command
        ->add_option(
            "INPUTS", options.tree.inputs,
            "Folders, which are searched for manifests, models and images; manifests (.json); models")
        ->required();
    command->add_option("-o,--output", options.folder, "Folder for the files")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    const std::size_t before = command->get_options().size();
    AddTrainingOptions(*command, options.training);
    AddInputOptions(*command, options.inputs);
    AddNumberOption(
        *command, "--save-every", options.saveSeconds, {0.0, 1e9},
        "Seconds between states, from which a killed bake goes on (default 120; 0: only when interrupted)");
    std::vector<CLI::Option*> settings = command->get_options();
    settings.erase(settings.begin(), settings.begin() + static_cast<std::ptrdiff_t>(before));
    std::erase(settings, command->get_option("--threads"));
    AddNumberOption(*command, "--jobs", options.jobs, {1, 64},
                    "Materials made at the same time (default 1); they share the cores");
    CLI::Option* material = command
                                ->add_option("--material", arguments->materials,
                                             "Only this material, as its file without .ntc; may be repeated")
                                ->type_name("NAME")
                                ->allow_extra_args(false);
    CLI::Option* prune =
        command->add_flag("--prune", options.prunes, "Remove files whose sources are no longer under INPUTS")
            ->excludes(material);
    CLI::Option* dryRun = command->add_flag("--dry-run", options.isDryRun, "Say what would be made, and why");
    command
        ->add_option("--plan", arguments->plan,
                     "Make nothing: write DIR/build.ninja (ninja) or DIR/bake.sbatch (slurm), which do")
        ->type_name("NAME")
        ->excludes(material)
        ->excludes(prune)
        ->excludes(dryRun);
    command
        ->add_option("--depfile", options.depfile, "Also write what the file is made of, for ninja and Make")
        ->type_name("FILE");
    command->add_flag("--quiet", options.quiet, "No progress");
    AddJsonFlag(*command, options.json);
    command->callback([arguments, command, settings, &action] {
        action = [arguments, command, settings] {
            CheckArguments(*arguments);
            arguments->bake.passed = GetPassedOptions(*command, settings);
            const CLI::Option* device = command->get_option_no_throw("--device");
            arguments->bake.usesGpu = device != nullptr && device->count() > 0;
            return Bake(*arguments);
        };
    });
}

} // namespace openntc::tool
