// SPDX-License-Identifier: MIT
#include "Help.h"

#include "Arguments.h"
#include "HelpFormats.h"
#include "Output.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 ok, 1 the work failed, 2 usage, 3 bad input file, 4 no device. More in docs/cli.md.";

struct Examples {
    const char* command; ///< with its parents, separated by spaces; empty: ntc itself
    const char* text;
};

constexpr std::array kExamples = {
    Examples{"", "  ntc encode albedo.png normal.png roughness.png -o material.ntc\n"
                 "  ntc info material.ntc\n"
                 "  ntc decode material.ntc -o out\n"
                 "  ntc help encode"},
    Examples{"info", "  ntc info material.ntc\n  ntc info *.ntc --json"},
    Examples{"validate", "  ntc validate *.ntc\n  curl -s URL | ntc validate -"},
    Examples{"decode", "  ntc decode material.ntc -o out --mips\n"
                       "  ntc decode material.ntc -o out --backend vulkan --device 0\n"
                       "  ntc decode material.ntc -o out --format ktx2 --quality best --zstd 19"},
    Examples{"optimize-bc", "  ntc optimize-bc material.ntc\n"
                            "  ntc decode material.ntc -o out --format dds --quality best"},
    Examples{"bc-test", "  ntc bc-test albedo.png normal.png\n"
                        "  ntc bc-test *.png --bc bc7 --json > before.json\n"
                        "  ntc bc-test *.png --bc bc7 --baseline before.json"},
    Examples{"sample", "  echo \"0 12 34\" | ntc sample material.ntc --texels - --csv"},
    Examples{"constants",
             "  ntc constants material.ntc\n  ntc constants material.ntc --first-mip 2 --mips 3 --json\n"
             "  ntc constants material.ntc --rect 128,0,128,128 --first-mip 0 --mips 4 --json"},
    Examples{"export", "  ntc export material.ntc -o out"},
    Examples{"devices", "  ntc devices\n  ntc devices --json"},
    Examples{"encode", "  ntc encode albedo.png normal.png roughness.png -o material.ntc --bits-per-pixel 4\n"
                       "  ntc encode material.json -o material.ntc --target-psnr 40\n"
                       "  ntc encode folder -o material.ntc --seconds 60\n"
                       "  ntc encode material.json -o material.ntc --generation 3 --compress --bc7-modes"},
    Examples{"migrate", "  ntc migrate archived.ntc -o material.ntc --generation 3\n"
                        "  ntc migrate material.ntc -o small.ntc --generation 1 --network small"},
    Examples{"bake", "  ntc bake art -o out --jobs 2\n"
                     "  ntc bake art -o out --dry-run\n"
                     "  ntc bake art -o out --plan ninja && ninja -C out\n"
                     "  ntc bake art -o out --plan slurm --threads 8 && sbatch out/bake.sbatch"},
    Examples{"convert-gltf", "  ntc convert-gltf model.glb -o out --bits-per-pixel 4\n"
                             "  ntc convert-gltf model.gltf -o out --normal-map Normal --weight BaseColor=4\n"
                             "  ntc convert-gltf model.gltf -o out --jobs 4 --keep-manifests --strict"},
    Examples{"compare", "  ntc compare material.ntc reference.ntc\n"
                        "  ntc compare material.ntc folder_of_images --images out"},
    Examples{"conformance", "  ntc conformance vectors\n"
                            "  ntc conformance export vectors\n"
                            "  ntc conformance run vectors --adapter ./my_adapter"},
    Examples{"bench decode", "  ntc bench decode material.ntc"},
    Examples{"bench load", "  ntc bench load material.ntc"},
    Examples{"bench loader",
             "  ntc bench loader material.ntc\n  ntc bench loader material.ntc --tile 64 --threads 0,2"},
    Examples{"bench slices",
             "  ntc bench slices material.ntc\n  ntc bench slices material.ntc --size 256 --mips 2"},
    Examples{"bench tiles",
             "  ntc bench tiles\n  ntc bench tiles --variant C --textures 10000 --change 1 --repeat 5"},
    Examples{"report", "  ntc report -o out/report --quick\n  ntc report -o out/report --device NVIDIA"},
    Examples{"compile-shaders",
             "  ntc compile-shaders my.comp --network medium --math int8 --output-dir spirv\n"
             "  ntc compile-shaders my.comp --network medium --math int8 -D X={0,1} --blob all.bin"}};

/// CLI11 appends what validators say of themselves to the type: `N:INT in [1 - 16]`, `ENUM:value in {json->1,text->0} OR
/// {1,0}`, `TEXT:FILE`. In plain words: `N (1 to 16)`, `NAME (json, text)`, `FILE`.
std::string MakePlainType(const std::string& full) {
    const std::size_t colon = full.find(':');
    std::string type = full.substr(0, colon);
    static constexpr std::array<std::array<const char*, 2>, 4> kTypes = {
        {{"INT", "N"}, {"UINT", "N"}, {"FLOAT", "NUMBER"}, {"ENUM", "NAME"}}};
    for (const auto& [cli, plain] : kTypes) {
        if (type == cli)
            type = plain;
    }
    if (colon == std::string::npos)
        return type;
    const std::string rule = full.substr(colon + 1);
    std::string names;
    for (const std::string& value : GetListedValues(rule))
        names += (names.empty() ? "" : ", ") + value;
    if (!names.empty())
        return type + " (" + names + ")";
    const std::size_t range = rule.find(" in [");
    if (range == std::string::npos)
        return type == "TEXT" ? rule : type;
    const std::string text = rule.substr(range + 5);
    const std::size_t dash = text.find(" - ");
    if (dash == std::string::npos)
        return type;
    const std::string low = text.substr(0, dash), high = text.substr(dash + 3, text.find(']') - dash - 3);
    constexpr double kNoLimit = 1e6; // where the rule only keeps nonsense out
    if (std::strtod(high.c_str(), nullptr) >= kNoLimit)
        return type;
    return type + " (" + low + " to " + high + ")";
}

class PlainFormatter final : public CLI::Formatter {
public:
    PlainFormatter() { column_width(34); }

    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text;
        if (option->get_type_size() != 0) {
            const std::string type = MakePlainType(option->get_type_name());
            text = type.empty() ? "" : " " + type;
            if (option->get_expected_max() == CLI::detail::expected_max_vector_size)
                text += "...";
            if (option->get_required() && !option->get_positional())
                text += " (required)";
        }
        for (const CLI::Option* other : option->get_needs())
            text += " (with " + other->get_name() + ")";
        for (const CLI::Option* other : option->get_excludes())
            text += " (not with " + other->get_name() + ")";
        return text;
    }
    /// Positionals say their name in the list already.
    std::string make_option_name(const CLI::Option* option, bool isPositional) const override {
        return isPositional ? option->get_name(true, false) : option->get_name(false, true);
    }
    std::string make_footer(const CLI::App* app) const override {
        const std::string footer = app->get_footer();
        return footer.empty() ? footer : "\n" + footer + "\n";
    }
};

CLI::App* FindCommand(CLI::App& app, const std::vector<std::string>& names) {
    CLI::App* command = &app;
    for (const std::string& name : names) {
        CLI::App* next = nullptr;
        for (CLI::App* candidate : command->get_subcommands([](const CLI::App*) { return true; })) {
            if (candidate->get_name() == name)
                next = candidate;
        }
        if (next == nullptr)
            return nullptr;
        command = next;
    }
    return command;
}

std::vector<std::string> Split(const std::string& text) {
    std::vector<std::string> words;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return words;
}

} // namespace

void UsePlainHelp(CLI::App& app) {
    app.formatter(std::make_shared<PlainFormatter>());
    app.get_formatter()->label("REQUIRED", "(required)");
}

void AddHelpCommand(CLI::App& app, Action& action) {
    auto names = std::make_shared<std::vector<std::string>>();
    auto wantsManual = std::make_shared<bool>(false);
    auto shell = std::make_shared<std::string>();
    CLI::App* help = app.add_subcommand("help", "Explain a command: the same as ntc COMMAND --help");
    help->add_option("COMMAND", *names, "Command, for example encode or conformance export");
    CLI::Option* manual = help->add_flag("--man", *wantsManual, "Instead: the manual page ntc.1, in roff");
    help->add_option("--completion", *shell, "Instead: the completions of a shell")
        ->check(CLI::IsMember({"bash", "zsh", "fish"}))
        ->excludes(manual);
    help->callback([names, wantsManual, shell, &action, &app] {
        action = [names, wantsManual, shell, &app]() -> int {
            if (*wantsManual || !shell->empty()) {
                if (!names->empty())
                    FailUsage("help", names->front() + ": --man and --completion are of all commands");
                WriteOutput(*wantsManual ? MakeManualPage(app) : MakeCompletion(app, *shell));
                return 0;
            }
            std::string all;
            for (const std::string& name : *names)
                all += (all.empty() ? "" : " ") + name;
            CLI::App* command = FindCommand(app, *names);
            if (command == nullptr)
                FailUsage("help", all + ": no such command");
            // Not App::help: of a command with a chosen sub-command that is the sub-command's.
            WriteOutput(command->get_formatter()->make_help(command, all.empty() ? "ntc" : "ntc " + all,
                                                            CLI::AppFormatMode::Normal));
            return 0;
        };
    });
    app.footer("Examples:\n" + std::string(kExamples[0].text) + "\n\n" + kExitCodes);
    for (const Examples& examples : kExamples) {
        CLI::App* command = FindCommand(app, Split(examples.command));
        if (command != nullptr && command != &app)
            command->footer("Examples:\n" + std::string(examples.text) + "\n\n" + kExitCodes);
    }
}

} // namespace openntc::tool
