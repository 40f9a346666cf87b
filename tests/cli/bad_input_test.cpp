// SPDX-License-Identifier: MIT
// Bad input to every command: one line, the documented exit code, nothing left behind.
#include "cli/Program.h"
#include "support/SpecificationVectors.h"

using namespace openntc_tests;

namespace {

std::string MakeV1() {
    const std::vector<std::byte> bytes = SynthesizeV1();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The file with text of its JSON replaced by text of the same length.
std::string Replace(std::string file, const std::string& from, const std::string& to) {
    REQUIRE(from.size() == to.size());
    const std::size_t at = file.find(from);
    REQUIRE(at != std::string::npos);
    return file.replace(at, from.size(), to);
}

const std::vector<std::string> kCommands = {
    "info FILE", "decode FILE -o out", "sample FILE --texels list --csv",
    "constants FILE --weights int8 --json", "bench decode FILE --repeat 1"};

std::string WithFile(std::string command, const std::string& file) {
    return command.replace(command.find("FILE"), 4, file);
}

} // namespace

TEST_CASE("missing, malformed and later files: exit 3") {
    const Folder folder;
    const std::string v1 = MakeV1();
    WriteText(folder / "list", "0 0 0\n");
    WriteText(folder / "empty.ntc", "");
    WriteText(folder / "short.ntc", v1.substr(0, 1000));
    WriteText(folder / "later.ntc", Replace(v1, "\"schemaVersion\":1", "\"schemaVersion\":4"));
    WriteText(folder / "width.ntc", Replace(v1, "\"width\":24", "\"width\":-4"));
    for (const std::string& command : kCommands) {
        for (const std::string file :
             {"missing.ntc", "empty.ntc", "short.ntc", "later.ntc", "width.ntc", ".", "- < /dev/null"}) {
            const std::string line =
                file.starts_with("-") ? WithFile(command, "-") + " < /dev/null" : WithFile(command, file);
            CAPTURE(line);
            const ProgramResult result = RunProgram(folder, line);
            CAPTURE(result.errors);
            CheckFails(result, 3);
            CHECK(result.errors.starts_with("ntc: " + file.substr(0, file.find(' ')) + ": "));
            CHECK_FALSE(fs::exists(folder / "out"));
        }
        const ProgramResult later = RunProgram(folder, WithFile(command, "later.ntc"));
        CHECK(later.errors.find("schemaVersion: 4") != std::string::npos);
    }
    const ProgramResult validated = RunProgram(folder, "validate later.ntc short.ntc --json");
    CHECK(validated.code == 3);
    CHECK_FALSE(ParseValid(validated.output, "validate")["files"][1]["usable"].GetBool());
    CheckFails(RunProgram(folder, "conformance missing"), 3);
    WriteText(folder / "v1.ntc", v1);
    CheckFails(RunProgram(folder, "constants v1.ntc --weights fp8 --json"), 3);
    CheckFails(RunProgram(folder, "sample v1.ntc --texels missing"), 3);
    WriteText(folder / "words", "0 0 zero\n");
    CheckFails(RunProgram(folder, "sample v1.ntc --texels words"), 3);
}

TEST_CASE("usage errors: exit 2") {
    const Folder folder;
    WriteText(folder / "v1.ntc", MakeV1());
    WriteText(folder / "list", "0 0 0\n");
    for (const std::string command : {"",
                                      "unknown",
                                      "info",
                                      "constants v1.ntc extra",
                                      "info --nonsense v1.ntc",
                                      "decode v1.ntc",
                                      "decode v1.ntc -o",
                                      "decode v1.ntc -o out --bc bc7",
                                      "decode v1.ntc -o out --format gif",
                                      "decode v1.ntc -o out --math coopvec_int8",
                                      "decode v1.ntc -o out --math coopmat_int8",
                                      "decode v1.ntc -o out --backend reference --math coopmat_int8_half",
                                      "decode v1.ntc -o out --math INT8",
                                      "decode v1.ntc -o out --rect 0,0,8,81",
                                      "decode v1.ntc -o out --backend cuda",
                                      "sample v1.ntc",
                                      "sample v1.ntc --texels list --csv --json",
                                      "sample - --texels -",
                                      "constants v1.ntc --weights int4",
                                      "constants v1.ntc --first-mip 4 --mips 1",
                                      "constants v1.ntc --first-mip 2 --mips 3",
                                      "constants v1.ntc --first-mip -1 --mips 1",
                                      "constants v1.ntc --mips 0",
                                      "constants v1.ntc --rect 0,0,1",
                                      "constants v1.ntc --rect 0,0,1,1,",
                                      "constants v1.ntc --rect 0,0,1,x",
                                      "constants v1.ntc --rect 0,0,1,99999999999",
                                      "constants v1.ntc --rect 0,0,25,1",
                                      "constants v1.ntc --rect -1,0,1,1",
                                      "constants v1.ntc --rect 0,19,1,2",
                                      "constants v1.ntc --first-mip 2 --rect 6,0,1,1",
                                      "constants v1.ntc --coverage whole",
                                      "constants v1.ntc --rect 0,0,1,1 --coverage all",
                                      "bench slices v1.ntc --size 21",
                                      "bench slices v1.ntc --size 8 --mips 5",
                                      "bench slices v1.ntc --size 8 --first-mip 4 --mips 1",
                                      "bench loader v1.ntc --tile 0",
                                      "bench loader v1.ntc --threads 257",
                                      "bench loader v1.ntc --threads x",
                                      "conformance",
                                      "conformance export",
                                      "conformance run . --format xml",
                                      "encode",
                                      "report",
                                      "bench",
                                      "bench decode v1.ntc --repeat 0",
                                      "validate",
                                      "validate - -"}) {
        CAPTURE(command);
        const ProgramResult result = RunProgram(folder, command);
        CAPTURE(result.errors);
        CheckFails(result, 2);
        CHECK_FALSE(fs::exists(folder / "out"));
    }
    for (const std::string list : {"0 0 0\n0 24 0\n", "# one\n0 0 20\n", "\n4 0 0\n", "0 0 0\n-1 0 0\n",
                                   "0 0 0\n0 99999999999999999999 0\n", "0 0 0\n0 0 -1\n"}) {
        WriteText(folder / "outside", list);
        CAPTURE(list);
        const ProgramResult result = RunProgram(folder, "sample v1.ntc --texels outside --csv");
        CheckFails(result, 2);
        CHECK(result.errors.find("line 2") != std::string::npos);
    }
}

TEST_CASE("a command that does not exist is named") {
    const Folder folder;
    fs::create_directory(folder / "there");
    const auto getError = [&](const std::string& command, int code) {
        const ProgramResult result = RunProgram(folder, command);
        CheckFails(result, code);
        return result.errors;
    };
    CHECK(getError("nonsense v1.ntc", 2)
              .starts_with("ntc: command line: command: nonsense: one of info, validate, decode, "));
    CHECK(getError("", 2).starts_with("ntc: command line: command: missing: one of info, "));
    CHECK(getError("bench nonsense", 2) ==
          "ntc: command line: bench: command: nonsense: one of decode, load, loader, slices, tiles\n");
    CHECK(getError("conformance nonsense", 3) ==
          "ntc: nonsense: DIR: no such folder, and no command of conformance: run, export, serve\n");
    CHECK(getError("info --nonsense v1.ntc", 2).find("--nonsense") != std::string::npos);
    CHECK(RunProgram(folder, "conformance there").code == 3); // a folder without vectors
}

TEST_CASE("help and version: exit 0") {
    const Folder folder;
    for (const std::string command :
         {"--help", "--version", "info --help", "validate --help", "decode --help", "sample --help",
          "constants --help", "conformance --help", "conformance run --help", "bench --help",
          "bench decode --help"}) {
        CAPTURE(command);
        const ProgramResult result = RunProgram(folder, command);
        CHECK(result.code == 0);
        CHECK_FALSE(result.output.empty());
        CHECK(result.errors.empty());
    }
}

TEST_CASE("work that cannot be finished: exit 1 and nothing half-written") {
    const Folder folder;
    WriteText(folder / "v1.ntc", MakeV1());
    WriteText(folder / "list", "0 0 0\n");
    WriteText(folder / "file", "");
    for (const std::string output : {"file", "file/below"}) {
        const ProgramResult result = RunProgram(folder, "decode v1.ntc -o " + output);
        CheckFails(result, 1);
        CHECK(result.errors.find("Not a directory") != std::string::npos);
    }
    if (fs::exists("/dev/full")) {
        for (const std::string command : {"info v1.ntc", "sample v1.ntc --texels list",
                                          "constants v1.ntc --json", "validate v1.ntc", "--help"}) {
            CAPTURE(command);
            const ProgramResult result = RunProgram(folder, command + " > /dev/full");
            CheckFails(result, 1);
            CHECK(result.errors.find("No space left on device") != std::string::npos);
        }
    }
    // A file size limit of nothing stands in for a full disk: every write to a PNG fails.
    const ProgramResult full =
        RunProgram(folder, "--version > /dev/null; trap '' XFSZ; ulimit -f 0; '" NTC_PROGRAM
                           "' decode v1.ntc -o out > /dev/null");
    CHECK(full.code == 1);
    CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("hostile texture names stay inside the folder") {
    const Folder folder;
    const std::string v1 = MakeV1();
    for (const std::string name : {"/", ".", ":"}) {
        WriteText(folder / "hostile.ntc", Replace(v1, "\"name\":\"t\"", "\"name\":\"" + name + "\""));
        const ProgramResult result = RunProgram(folder, "decode hostile.ntc -o out");
        CHECK(result.code == 0);
        CHECK(result.output == "out/_.png 24 x 20\n");
        CHECK(fs::exists(folder / "out/_.png"));
    }
}
