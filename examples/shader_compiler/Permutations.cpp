// SPDX-License-Identifier: MIT
#include "shader_compiler/Permutations.h"

#include "shader_compiler/Failure.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace openntc::shader_compiler {

namespace {

bool IsNameCharacter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

bool IsName(std::string_view text) {
    return !text.empty() && !(text[0] >= '0' && text[0] <= '9') &&
           std::all_of(text.begin(), text.end(), IsNameCharacter);
}

// What CMake's lists, generator expressions and templates and an index's lines would read.
constexpr std::string_view kRefused = "[]{}|\"\\;$@";

bool IsValue(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [&](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte > 0x20 && byte < 0x7F && kRefused.find(c) == std::string_view::npos;
    });
}

bool IsRefusedInList(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t') || byte == 0x7F ||
           std::string_view("[];\\").find(c) != std::string_view::npos;
}

std::string GetStageFromName(std::string_view name) {
    for (const std::string_view language : {".glsl", ".hlsl"}) {
        if (name.ends_with(language)) {
            name.remove_suffix(language.size());
            break;
        }
    }
    for (const char* stage : {"comp", "frag", "vert"}) {
        if (name.ends_with(std::string(".") + stage))
            return stage;
    }
    return {};
}

Stage ParseStage(const std::string& text, const std::string& name) {
    if (text == "comp")
        return Stage::Compute;
    if (text == "frag")
        return Stage::Fragment;
    if (text == "vert")
        return Stage::Vertex;
    throw Failure(FailureKind::Usage, name,
                  "stage: " + text +
                      ": the file's ending (.comp, .frag, .vert, .comp.hlsl ...), --stage or the list's "
                      "-T must say comp, frag or vert");
}

Permutation MakePermutation(const SourceRequest& request) {
    Permutation result;
    result.path = request.path;
    result.source = request.path.filename().string();
    if (result.source.find_first_of(kRefused) != std::string::npos)
        throw Failure(FailureKind::Usage, result.source, R"(a file's name without " $ ; @ [ \ ] { | })");
    result.hlsl = result.source.ends_with(".hlsl");
    result.stage =
        ParseStage(request.stage.empty() ? GetStageFromName(result.source) : request.stage, result.source);
    if (!request.entry.empty() && request.entry != "main") {
        if (!result.hlsl || !IsName(request.entry))
            throw Failure(FailureKind::Usage, result.source,
                          "entry point: " + request.entry + (result.hlsl ? ": a name" : ": GLSL's is main"));
        result.entry = request.entry;
        result.source += ":" + request.entry;
    }
    return result;
}

// Every one of `lists` with every value of every axis. `macros` are those that have their axis, and grows.
std::vector<std::vector<std::string>> Multiply(std::vector<std::vector<std::string>> lists,
                                               const std::vector<DefineAxis>& axes,
                                               std::set<std::string>& macros) {
    for (const DefineAxis& axis : axes) {
        if (!macros.insert(axis.name).second)
            throw Failure(FailureKind::Usage, "-D " + axis.name, "is defined twice");
        std::vector<std::vector<std::string>> result;
        for (const std::vector<std::string>& list : lists) {
            for (const std::string& value : axis.values) {
                result.push_back(list);
                if (!value.empty())
                    result.back().push_back(axis.name + "=" + value);
            }
        }
        lists = std::move(result);
    }
    return lists;
}

std::string Join(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : " ") + word;
    return text;
}

std::string GetStageOfProfile(std::string_view profile) {
    const std::size_t model = profile.find('_');
    const bool plain = model == std::string_view::npos ||
                       (profile.size() > model + 1 &&
                        profile.substr(model).find_first_not_of("_0123456789") == std::string_view::npos);
    const std::string_view kind = profile.substr(0, model);
    if (plain && kind == "cs")
        return "comp";
    if (plain && kind == "ps")
        return "frag";
    if (plain && kind == "vs")
        return "vert";
    return {};
}

// The blocks of #if in a list file.
class Conditions {
public:
    bool IsEnabled() const { return enabled_; }

    /// Takes a line that begins with '#'; false if it is none of the directives.
    bool Take(std::istringstream words) {
        std::string directive, argument, rest;
        words >> directive >> argument >> rest;
        if (directive == "#") { // "# if"
            directive += argument;
            argument = rest;
            rest.clear();
            words >> rest;
        }
        if (!rest.empty())
            return false;
        const bool isIf = directive == "#if" && (argument == "0" || argument == "1");
        if (isIf || (directive == "#ifdef" && IsName(argument))) {
            around_.push_back(enabled_);
            enabled_ = enabled_ && isIf && argument == "1";
            return true;
        }
        if (around_.empty() || !argument.empty())
            return false;
        if (directive == "#endif") {
            enabled_ = around_.back();
            around_.pop_back();
            return true;
        }
        enabled_ = around_.back() && !enabled_;
        return directive == "#else";
    }

    bool IsComplete() const { return around_.empty(); }

private:
    bool enabled_ = true;
    std::vector<bool> around_;
};

SourceRequest ParseListLine(const std::filesystem::path& file, int number, std::istringstream words) {
    const auto fail = [&](const std::string& text) {
        return Failure(FailureKind::Input, file.string(), "line " + std::to_string(number) + ": " + text);
    };
    SourceRequest request;
    request.list = file.string();
    request.line = number;
    std::string option, value;
    words >> option;
    request.path = file.parent_path() / option;
    while (words >> option) {
        if (option == "-T" || option == "--profile" || option == "-E" || option == "--entryPoint" ||
            option == "-D" || option == "--define") {
            if (!(words >> value))
                throw fail(option + ": nothing follows");
        } else if (option.size() > 2 &&
                   (option.starts_with("-T") || option.starts_with("-E") || option.starts_with("-D"))) {
            value = option.substr(2);
            option.resize(2);
        } else {
            throw fail(option + ": -T, -E or -D");
        }
        if (option == "-T" || option == "--profile") {
            request.stage = GetStageOfProfile(value);
            if (request.stage.empty())
                throw fail("-T " + value + ": cs, ps or vs");
        } else if (option == "-E" || option == "--entryPoint") {
            request.entry = value;
        } else {
            try {
                request.axes.push_back(ParseDefine(value));
            } catch (const Failure& failure) {
                throw fail(std::string("-D ") + failure.what());
            }
        }
    }
    return request;
}

} // namespace

std::string Permutation::GetDefines() const {
    return Join(defines);
}

std::string Permutation::GetFileName() const {
    std::string name = source + " " + GetDefines();
    for (char& c : name) {
        if (!IsNameCharacter(c) && c != '.' && c != '=' && c != '-')
            c = '+';
    }
    if (name.ends_with('+'))
        name.pop_back();
    return name + ".spv";
}

std::string Permutation::GetFlatName() const {
    const std::string name = GetFileName();
    // A header says by its macro which language it is made for.
    const bool isHlsl = hlsl || std::find(defines.begin(), defines.end(), "NTC_HLSL=1") != defines.end();
    return name.substr(0, name.size() - 4) + (isHlsl ? ".hlsl" : ".glsl");
}

std::string Permutation::GetKey() const {
    std::vector<std::string> sorted = defines;
    std::sort(sorted.begin(), sorted.end());
    return source + "|" + Join(sorted);
}

bool IsCooperativeMath(std::string_view define) {
    return define == "NTC_MATH=6" || define == "NTC_MATH=7" || define == "NTC_MATH=8" ||
           define == "NTC_MATH=9";
}

bool Permutation::NeedsCooperativeVectors() const {
    if (std::find(defines.begin(), defines.end(), "NTC_COOPMAT_EMULATED=1") != defines.end())
        return false;
    return std::any_of(defines.begin(), defines.end(), IsCooperativeMath);
}

DefineAxis ParseDefine(std::string_view text) {
    const auto fail = [&] {
        return Failure(FailureKind::Usage, "--define",
                       std::string(text) +
                           ": NAME, NAME=VALUE or NAME={V1,V2}; values without space, control and other than "
                           R"(ASCII characters, " $ ; @ [ \ ] { | })");
    };
    const std::size_t equal = text.find('=');
    DefineAxis axis{std::string(text.substr(0, equal)), {}};
    if (!IsName(axis.name))
        throw fail();
    if (equal == std::string_view::npos) {
        axis.values = {"1"};
        return axis;
    }
    std::string_view values = text.substr(equal + 1);
    const bool list = values.size() >= 2 && values.front() == '{' && values.back() == '}';
    if (list)
        values = values.substr(1, values.size() - 2);
    if (!IsValue(values))
        throw fail();
    while (list && values.find(',') != std::string_view::npos) {
        axis.values.emplace_back(values.substr(0, values.find(',')));
        values.remove_prefix(values.find(',') + 1);
    }
    axis.values.emplace_back(values);
    return axis;
}

std::vector<SourceRequest> ReadListFile(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (const std::string reason = WhyUnreadable(file, stream); !reason.empty())
        throw Failure(FailureKind::Input, file.string(), "file: cannot be read: " + reason);
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    std::vector<SourceRequest> requests;
    Conditions conditions;
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        const auto fail = [&](const std::string& text) {
            return Failure(FailureKind::Input, file.string(), "line " + std::to_string(number) + ": " + text);
        };
        if (number == 1 && line.starts_with(kByteOrderMark))
            line.erase(0, kByteOrderMark.size());
        if (line.ends_with('\r')) // CR LF
            line.pop_back();
        if (std::any_of(line.begin(), line.end(), IsRefusedInList))
            throw fail("brackets, semicolons, backslashes and control characters are not allowed");
        line.resize(std::min(line.size(), line.find("//")));
        const std::size_t first = line.find_first_not_of(" \t");
        if (first == std::string::npos)
            continue;
        if (line[first] == '#') {
            if (!conditions.Take(std::istringstream(line)))
                throw fail(line.substr(first) + ": #if 0, #if 1, #ifdef NAME, #else or #endif");
        } else if (conditions.IsEnabled()) {
            requests.push_back(ParseListLine(file, number, std::istringstream(line)));
        }
    }
    if (!conditions.IsComplete())
        throw Failure(FailureKind::Input, file.string(), "#if: without #endif");
    if (requests.empty())
        throw Failure(FailureKind::Input, file.string(), "no shader is listed");
    return requests;
}

std::vector<Permutation> ListPermutations(const std::vector<SourceRequest>& sources,
                                          const std::vector<DefineAxis>& axes) {
    std::vector<Permutation> result;
    std::set<std::string> names;
    std::set<std::string> macros;
    Multiply({}, axes, macros); // no line of a list is to blame for these
    for (const SourceRequest& source : sources) {
        try {
            const Permutation base = MakePermutation(source);
            std::set<std::string> own;
            std::vector<std::vector<std::string>> lists = Multiply({{}}, axes, own);
            for (std::vector<std::string>& list : Multiply(std::move(lists), source.axes, own)) {
                result.push_back(base);
                result.back().defines = std::move(list);
                if (!names.insert(result.back().GetFileName()).second)
                    throw Failure(FailureKind::Usage, base.source,
                                  "permutation: " + result.back().GetDefines() +
                                      ": asked for twice, or two files have that name");
            }
        } catch (const Failure& failure) {
            if (source.list.empty())
                throw;
            throw Failure(FailureKind::Input, source.list,
                          "line " + std::to_string(source.line) + ": " + failure.GetSubject() + ": " +
                              failure.what());
        }
    }
    return result;
}

} // namespace openntc::shader_compiler
