// SPDX-License-Identifier: MIT
#include "bake/BakeFiles.h"
#include "bake/BakePlan.h"
#include "bake/Depfile.h"

#include "Output.h"

#include <filesystem>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

/// A value of a variable.
std::string EscapeValue(const std::string& text) {
    std::string escaped;
    for (const char c : text)
        escaped += c == '$' ? std::string("$$") : std::string(1, c);
    return escaped;
}
/// A path in a `build` line.
std::string EscapePath(const std::string& text) {
    std::string escaped;
    for (const char c : text)
        escaped += (c == '$' || c == ' ' || c == ':' ? "$" : "") + std::string(1, c);
    return escaped;
}

} // namespace

std::string WriteNinjaPlan(const BakeOptions& options, const MaterialTree& tree) {
    constexpr const char* kPlanDepfile = ".bake/plan.d";
    std::string text =
        "# Written by `ntc bake --plan ninja`. `ninja -C` this folder makes what changed, -k 0 also after "
        "failures.\nninja_required_version = 1.5\nbuilddir = .bake\n";
    text += "bake = " + EscapeValue(QuoteForShell(GetProgramPath()) + " bake");
    for (const std::string& input : options.tree.inputs)
        text += " " + EscapeValue(QuoteForShell(GetAbsolutePath(input)));
    text += " -o .";
    for (const std::string& word : options.passed)
        text += " " + EscapeValue(QuoteForShell(word));
    const int jobThreads = options.GetThreads(options.jobs);
    const std::string threads = jobThreads > 0 ? Format(" --threads %d", jobThreads) : "";
    text += Format("\n\npool materials\n  depth = %d\n\n", options.jobs);
    // An image that was touched and is the same by content leaves the file as it is, and what depends on it.
    text += "rule bake\n  command = $bake" + threads +
            " --material $material --depfile $depfile_word --quiet\n  description = bake $out\n  pool = "
            "materials\n"
            "  deps = gcc\n  restat = 1\n\n";
    text += "rule plan\n  command = $bake" +
            (options.givenThreads > 0 ? Format(" --threads %d", options.givenThreads) : "") +
            Format(" --plan ninja --jobs %d --depfile %s --quiet\n", options.jobs, kPlanDepfile) +
            "  description = look for materials\n  generator = 1\n  depfile = " + kPlanDepfile +
            "\n  deps = gcc\n  restat = 1\n\nbuild build.ninja: plan\n";
    for (const BakeMaterial& material : tree.materials) {
        if (material.name.find('\n') != std::string::npos)
            throw CommandError(ExitCode::Usage, material.origin, "name: a line feed: ninja cannot hold it");
        const std::string depfile = ".bake/" + material.name + ".d";
        const std::string output = EscapePath(material.name + ".ntc");
        // Without default targets ninja would plan again beside the materials, and an interrupt of that would
        // remove this file.
        text += "\nbuild " + output + ": bake\n  material = " + EscapeValue(QuoteForShell(material.name)) +
                "\n  depfile = " + EscapeValue(depfile) +
                "\n  depfile_word = " + EscapeValue(QuoteForShell(depfile)) + "\n";
        text.append("default ").append(output).append("\n");
    }
    std::string path = (fs::path(options.folder) / "build.ninja").string();
    MakeFolderOf(path);
    WriteIfDifferent(path, text);
    if (!options.depfile.empty()) {
        std::vector<std::string> sources = tree.folders;
        for (const BakeMaterial& material : tree.materials)
            sources.push_back(material.origin);
        WriteDepfile(options.depfile, {{"build.ninja", sources}});
    }
    return path;
}

} // namespace openntc::tool
