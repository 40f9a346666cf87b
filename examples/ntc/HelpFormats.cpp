// SPDX-License-Identifier: MIT
#include "HelpFormats.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace openntc::tool {

namespace {

struct HelpCommand {
    std::string path; ///< "bench decode"; empty: ntc itself
    const CLI::App* app;
};

void ListHelpCommands(const CLI::App& app, const std::string& path, std::vector<HelpCommand>& list) {
    list.push_back({path, &app});
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        ListHelpCommands(*command, path + (path.empty() ? "" : " ") + command->get_name(), list);
}

std::vector<HelpCommand> ListHelpCommands(const CLI::App& app) {
    std::vector<HelpCommand> list;
    ListHelpCommands(app, "", list);
    return list;
}

std::vector<std::string> GetSubcommandNames(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

std::string Join(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : " ") + word;
    return text;
}

std::string ReplaceAll(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
        text.replace(at, what.size(), by);
    return text;
}

/// `-o` and `--output`, as they are typed.
std::vector<std::string> GetTypedNames(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames())
        names.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        names.push_back("--" + name);
    return names;
}

bool TakesValue(const CLI::Option& option) {
    return option.get_type_size() != 0;
}

// Roff: a backslash is \e, a hyphen that is typed is \-, and a line must not begin with a dot or a quote.
std::string EscapeRoff(const std::string& text) {
    std::string lines = ReplaceAll(ReplaceAll(text, "\\", "\\e"), "-", "\\-");
    lines = ReplaceAll(ReplaceAll(lines, "\n.", "\n\\&."), "\n'", "\n\\&'");
    return !lines.empty() && (lines[0] == '.' || lines[0] == '\'') ? "\\&" + lines : lines;
}

std::string DescribeInRoff(const CLI::Option& option) {
    const bool isPositional = option.get_positional();
    std::string head = isPositional ? option.get_name(true, false) : "";
    for (const std::string& name : isPositional ? std::vector<std::string>{} : GetTypedNames(option))
        head += (head.empty() ? "" : ", ") + name;
    std::string text = ".TP\n.B " + EscapeRoff(head) + "\n";
    const std::vector<std::string> values = GetListedValues(option.get_type_name());
    text += EscapeRoff(option.get_description());
    if (!values.empty())
        text += EscapeRoff(" (" + Join(values) + ")");
    return text + "\n";
}

// Bash and zsh: the command that was typed so far, as "bench decode".
std::string MakeCommandSearch(const std::vector<HelpCommand>& commands, const std::string& words) {
    std::string known;
    for (const HelpCommand& command : commands) {
        if (!command.path.empty())
            known += (known.empty() ? "'" : " | '") + command.path + "'";
    }
    return "    local command=\"\" word\n"
           "    for word in " +
           words +
           "; do\n"
           "        case \"${command:+$command }$word\" in\n"
           "            " +
           known +
           ") command=\"${command:+$command }$word\" ;;\n"
           "        esac\n"
           "    done\n";
}

std::string MakeBashCompletion(const std::vector<HelpCommand>& commands) {
    std::string words, values;
    for (const HelpCommand& command : commands) {
        std::vector<std::string> options;
        for (const CLI::Option* option : command.app->get_options()) {
            if (option->get_positional())
                continue;
            const std::vector<std::string> names = GetTypedNames(*option);
            options.insert(options.end(), names.begin(), names.end());
            const std::vector<std::string> listed = GetListedValues(option->get_type_name());
            for (const std::string& name : listed.empty() ? std::vector<std::string>{} : names)
                values += "        '" + command.path + " " + name + "') words='" + Join(listed) + "' ;;\n";
        }
        words += "        '" + command.path + "') options='" + Join(options) + "' words='" +
                 Join(GetSubcommandNames(*command.app)) + "' ;;\n";
    }
    return "# bash completion of ntc; made by: ntc help --completion bash\n"
           "_ntc() {\n"
           "    local current=\"${COMP_WORDS[COMP_CWORD]}\" options=\"\" words=\"\"\n" +
           MakeCommandSearch(commands, "\"${COMP_WORDS[@]:1:COMP_CWORD-1}\"") + "    case \"$command\" in\n" +
           words +
           "    esac\n"
           "    [[ \"$current\" != -* ]] || words=\"$options\"\n"
           "    case \"$command ${COMP_WORDS[COMP_CWORD - 1]}\" in\n" +
           values +
           "    esac\n"
           "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
           "}\n"
           "complete -o default -F _ntc ntc # default: files, where nothing else fits\n";
}

std::string EscapeZsh(const std::string& text) {
    std::string escaped = ReplaceAll(text, "'", "'\\''");
    for (const char* special : {"[", "]", ":"})
        escaped = ReplaceAll(escaped, special, std::string("\\") + special);
    return escaped;
}

std::string MakeZshCompletion(const std::vector<HelpCommand>& commands) {
    std::string cases;
    for (const HelpCommand& command : commands) {
        cases += "        '" + command.path + "')\n            _arguments";
        for (const CLI::Option* option : command.app->get_options()) {
            const std::vector<std::string> listed = GetListedValues(option->get_type_name());
            const std::string value = listed.empty() ? "_files" : "(" + Join(listed) + ")";
            for (const std::string& name :
                 option->get_positional() ? std::vector<std::string>{} : GetTypedNames(*option))
                cases += " \\\n                '*" + name + "[" + EscapeZsh(option->get_description()) + "]" +
                         (TakesValue(*option) ? ":value:" + value : "") + "'";
        }
        const std::vector<std::string> names = GetSubcommandNames(*command.app);
        cases += " \\\n                '*::" +
                 (names.empty() ? std::string("file:_files") : "command:(" + Join(names) + ")") + "' ;;\n";
    }
    return "#compdef ntc\n"
           "# zsh completion of ntc; made by: ntc help --completion zsh\n"
           "_ntc() {\n" +
           MakeCommandSearch(commands, "\"${(@)words[2,CURRENT-1]}\"") + "    case \"$command\" in\n" +
           cases +
           "    esac\n"
           "}\n"
           "_ntc \"$@\"\n";
}

std::string EscapeFish(const std::string& text) {
    return ReplaceAll(ReplaceAll(text, "\\", "\\\\"), "'", "\\'");
}

// Fish: a command of its own that prints what was typed so far would be called for each line; its words are asked for instead.
std::string MakeFishCompletion(const std::vector<HelpCommand>& commands) {
    std::string text = "# fish completion of ntc; made by: ntc help --completion fish\n";
    for (const HelpCommand& command : commands) {
        std::string typed = command.path.empty()
                                ? "__fish_use_subcommand"
                                : "__fish_seen_subcommand_from " +
                                      ReplaceAll(command.path, " ", "; and __fish_seen_subcommand_from ");
        const std::vector<std::string> names = GetSubcommandNames(*command.app);
        const std::string without = names.empty() || command.path.empty()
                                        ? ""
                                        : "; and not __fish_seen_subcommand_from " + Join(names);
        const std::string condition = " -n '" + typed + without + "'";
        for (const CLI::App* sub : command.app->get_subcommands([](const CLI::App*) { return true; }))
            text += "complete -c ntc -f" + condition + " -a " + sub->get_name() + " -d '" +
                    EscapeFish(sub->get_description()) + "'\n";
        for (const CLI::Option* option : command.app->get_options()) {
            if (option->get_positional())
                continue;
            text += "complete -c ntc" + condition;
            for (const std::string& name : option->get_snames())
                text += " -s " + name;
            for (const std::string& name : option->get_lnames())
                text += " -l " + name;
            const std::vector<std::string> listed = GetListedValues(option->get_type_name());
            if (TakesValue(*option))
                text += listed.empty() ? " -r" : " -x -a '" + Join(listed) + "'";
            text += " -d '" + EscapeFish(option->get_description()) + "'\n";
        }
    }
    return text;
}

} // namespace

std::vector<std::string> GetListedValues(const std::string& type) {
    const std::size_t open = type.find('{'), close = type.find('}');
    std::vector<std::string> values;
    if (open == std::string::npos || close == std::string::npos || close < open)
        return values;
    for (std::size_t at = open + 1; at < close;) {
        const std::size_t end = std::min(type.find(',', at), close);
        const std::string item = type.substr(at, end - at);
        values.push_back(item.substr(0, item.find("->")));
        at = end + 1;
    }
    return values;
}

std::string MakeManualPage(const CLI::App& app) {
    const std::string version = app.version();
    std::string text =
        ".TH NTC 1 \"\" \"" + EscapeRoff(version.substr(0, version.find('\n'))) +
        "\" \"OpenNTC\"\n.SH NAME\nntc \\- " + EscapeRoff(app.get_description()) +
        "\n.SH SYNOPSIS\n.B ntc\n.I COMMAND\n[\\fIOPTIONS\\fR] ...\n.SH DESCRIPTION\n"
        "Made of what the commands say of themselves; \\fBntc help\\fR \\fICOMMAND\\fR prints the "
        "part of one command.\n.SH COMMANDS\n";
    for (const HelpCommand& command : ListHelpCommands(app)) {
        const std::string name = command.path.empty() ? "ntc" : "ntc " + command.path;
        text += ".SS \"" + EscapeRoff(name) + "\"\n";
        if (!command.path.empty())
            text += EscapeRoff(command.app->get_description()) + "\n";
        for (const CLI::Option* option : command.app->get_options())
            text += DescribeInRoff(*option);
        const std::string footer = command.app->get_footer();
        if (!footer.empty())
            text += ".PP\n.nf\n" + EscapeRoff(footer) + "\n.fi\n";
    }
    return text;
}

std::string MakeCompletion(const CLI::App& app, const std::string& shell) {
    const std::vector<HelpCommand> commands = ListHelpCommands(app);
    if (shell == "bash")
        return MakeBashCompletion(commands);
    if (shell == "zsh")
        return MakeZshCompletion(commands);
    return shell == "fish" ? MakeFishCompletion(commands) : "";
}

} // namespace openntc::tool
