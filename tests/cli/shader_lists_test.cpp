// SPDX-License-Identifier: MIT
// The grammar of shader lists has two readers, CMake's and the program's: both agree with the cases in shader_lists.txt, and
// with each other on lines made up at random.
#include "cli/Program.h"

#include <array>
#include <map>
#include <random>
#include <sstream>

using namespace openntc_tests;

namespace {

struct Reading {
    bool accepted = false;
    std::string index;  // "source|defines" lines
    std::string errors; // without line breaks
};

std::string JoinLines(const std::string& text) {
    std::istringstream words(text);
    std::string all, word;
    while (words >> word)
        all += (all.empty() ? "" : " ") + word;
    return all;
}

Reading ReadByProgram(const Folder& folder, const std::string& arguments) {
    const ProgramResult result = RunProgram(folder, "compile-shaders " + arguments + " --dry-run");
    Reading reading{result.code == 0, {}, JoinLines(result.errors)};
    std::istringstream lines(result.output);
    std::string line;
    while (std::getline(lines, line)) {
        const std::size_t source = line.find('\t') + 1;
        line[line.find('\t', source)] = '|';
        reading.index += line.substr(source) + "\n";
    }
    return reading;
}

Reading ReadByCMake(const Folder& folder, const std::string& arguments) {
    fs::remove(folder / "index.txt");
    const std::string command = "cd '" + folder.GetPath().string() +
                                "' && '" CMAKE_PROGRAM "' '-DMODULES=" NTC_CMAKE_DIR
                                "' -DOUTPUT=index.txt '-DARGUMENTS=" +
                                arguments + "' -P '" NTC_LIST_SHADERS "' >errors.txt 2>&1";
    const int status = std::system(command.c_str());
    return {status == 0, ReadText(folder / "index.txt"), JoinLines(ReadText(folder / "errors.txt"))};
}

struct ListCase {
    std::string text, index;
    int refusedLine = -1; // -1: accepted, 0: no line is to blame
};

std::string ReplaceNames(std::string text) {
    const std::map<std::string, std::string> names = {{"<TAB>", "\t"},  {"<CR>", "\r"},
                                                      {"<BELL>", "\a"}, {"<DEL>", "\x7F"},
                                                      {"<NOLF>\n", ""}, {"<BOM>", "\xEF\xBB\xBF"}};
    for (const auto& [name, bytes] : names) {
        for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at))
            text.replace(at, name.size(), bytes);
    }
    return text;
}

std::vector<ListCase> ReadCases() {
    std::istringstream file(ReadText(NTC_SHADER_LISTS));
    std::vector<ListCase> cases;
    std::string line;
    bool isIndex = false;
    while (std::getline(file, line)) {
        if (line.starts_with(">>> ")) {
            cases.emplace_back();
            isIndex = false;
            if (line.starts_with(">>> refused "))
                cases.back().refusedLine = std::stoi(line.substr(12));
        } else if (cases.empty()) {
            continue; // what the file says of itself
        } else if (line == "---") {
            isIndex = true;
        } else if (isIndex && !line.empty()) {
            cases.back().index += line + "\n";
        } else if (!isIndex) {
            cases.back().text += line + "\n";
        }
    }
    return cases;
}

bool CheckLine(const Reading& reading, int line) {
    const bool namesLine = reading.errors.find(": line ") != std::string::npos;
    const std::string name = ": line " + std::to_string(line) + ": ";
    return line == 0 ? !namesLine : reading.errors.find(name) != std::string::npos;
}

bool IsListCommandAbsent(const Folder& folder) {
    WriteText(folder / "list.txt", "a.comp\n");
    if (RunProgram(folder, "compile-shaders --list list.txt --dry-run").code != 4)
        return false;
    MESSAGE("SKIP: ntc was built without glslang's library: lists are read by CMake only");
    return true;
}

} // namespace

TEST_CASE("shader lists: CMake and ntc agree with every case of the grammar") {
    const Folder folder;
    const bool isAbsent = IsListCommandAbsent(folder);
    const std::vector<ListCase> cases = ReadCases();
    CHECK(cases.size() > 70);
    std::size_t accepted = 0;
    for (const ListCase& c : cases) {
        CAPTURE(c.text);
        WriteText(folder / "list.txt", ReplaceNames(c.text));
        std::vector<Reading> readings = {ReadByCMake(folder, "LIST;list.txt")};
        if (!isAbsent)
            readings.push_back(ReadByProgram(folder, "--list list.txt"));
        for (const Reading& reading : readings) {
            CAPTURE(reading.errors);
            CHECK(reading.accepted == (c.refusedLine < 0));
            CHECK(reading.index == c.index);
            if (c.refusedLine >= 0) {
                CHECK(CheckLine(reading, c.refusedLine));
                CHECK(reading.errors.find("list.txt: ") != std::string::npos);
            }
        }
        accepted += c.refusedLine < 0 ? 1 : 0;
    }
    CHECK(accepted > 10);
}

TEST_CASE("shader lists: CMake and ntc agree on lines made up at random") {
    const Folder folder;
    if (IsListCommandAbsent(folder))
        return;
    const std::vector<std::string> parts = {"-T",     "cs",   "ps_6_4",   "vs_",   "-E",      "main",
                                            "Shade",  "-D",   "A",        "B=1",   "A={1,2}", "-DC",
                                            "D={,x}", "-Tcs", "--define", "{",     "E=",      "F={}",
                                            "//",     "-O",   "G={1,1}",  "H=a,b", "_=$",     "I=ü"};
    std::mt19937 random(20261126);
    const auto pick = [&](std::size_t count) {
        return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
    };
    std::string good, goodIndex;
    int refused = 0, accepted = 0;
    for (int i = 0; i < 200; ++i) {
        std::string line = "s" + std::to_string(i) + (pick(2) == 0 ? ".comp" : ".frag.hlsl");
        for (std::size_t n = pick(8); n > 0; --n)
            line += (pick(6) == 0 ? "\t" : " ") + parts[pick(parts.size())];
        CAPTURE(line);
        WriteText(folder / "list.txt", line + "\n");
        const Reading program = ReadByProgram(folder, "--list list.txt");
        if (program.accepted) {
            // Lines that are good alone are good together: no two have a source in common.
            good += line + "\n";
            goodIndex += program.index;
            ++accepted;
        } else if (++refused <= 20) {
            CHECK_FALSE(ReadByCMake(folder, "LIST;list.txt").accepted);
        }
    }
    CHECK(refused > 20);
    CHECK(accepted > 20);
    WriteText(folder / "list.txt", good);
    const Reading cmake = ReadByCMake(folder, "LIST;list.txt");
    CAPTURE(cmake.errors);
    CHECK(cmake.accepted);
    CHECK(cmake.index == goodIndex);
    CHECK(ReadByProgram(folder, "--list list.txt").index == goodIndex);
}

TEST_CASE("shader lists: names of networks and maths modes in either case, and axes around the lines'") {
    const Folder folder;
    const bool isAbsent = IsListCommandAbsent(folder);
    WriteText(folder / "list.txt", "a.comp -D A={0,1}\n");
    const std::string index =
        "a.comp|NETWORK_VERSION=1 NTC_MATH=3 B=2 A=0\na.comp|NETWORK_VERSION=1 NTC_MATH=3 B=2 A=1\n"
        "a.comp|NETWORK_VERSION=4 NTC_MATH=3 B=2 A=0\na.comp|NETWORK_VERSION=4 NTC_MATH=3 B=2 A=1\n";
    for (const auto& names : {std::array{"small", "xlarge", "fp8"}, std::array{"SMALL", "XLARGE", "FP8"},
                              std::array{"Small", "XLarge", "Fp8"}}) {
        const auto& [small, xlarge, math] = names;
        CAPTURE(names[0]);
        const Reading cmake = ReadByCMake(folder, std::string("LIST;list.txt;NETWORK_VERSIONS;") + small +
                                                      ";" + xlarge + ";MATH;" + math + ";DEFINES;B=2");
        CHECK(cmake.index == index);
        if (!isAbsent)
            CHECK(ReadByProgram(folder, std::string("--list list.txt --network ") + small + "," + xlarge +
                                            " --math " + math + " -D B=2")
                      .index == index);
    }
    Reading reading = ReadByCMake(folder, "LIST;list.txt;NETWORK_VERSIONS;tiny");
    CHECK_FALSE(reading.accepted);
    CHECK(
        reading.errors.find("NETWORK_VERSIONS: \"tiny\": one of SMALL, MEDIUM, LARGE, XLARGE, GEN2, GEN3") !=
        std::string::npos);
    reading = ReadByCMake(folder, "LIST;list.txt;MATH;int4");
    CHECK_FALSE(reading.accepted);
    CHECK(reading.errors.find("MATH: \"int4\": one of INT8, ") != std::string::npos);
    CHECK_FALSE(ReadByCMake(folder, "LIST;list.txt;DEFINES;A=2").accepted);
    CHECK_FALSE(ReadByCMake(folder, "LIST;list.txt;DEFINES;B;B=2").accepted);
    if (!isAbsent) {
        CHECK_FALSE(ReadByProgram(folder, "--list list.txt -D A=2").accepted);
        CHECK_FALSE(ReadByProgram(folder, "--list list.txt -D B -D B=2").accepted);
    }
}
