// SPDX-License-Identifier: MIT
// The shipped sample texture sets load and decode alike everywhere.
#include "cli/Program.h"

#include <sstream>

using namespace openntc_tests;

TEST_CASE("sample texture sets decode to the same values on every CPU back end") {
    const Folder folder;
    const fs::path data = fs::path(NTC_SCHEMA_DIR).parent_path() / "examples/materials/data";
    std::uintmax_t bytes = 0;
    for (const std::string name : {"bricks.ntc", "grille.ntc"}) {
        CAPTURE(name);
        const std::string file = " '" + (data / name).string() + "' ";
        bytes += fs::file_size(data / name);
        CHECK(RunProgram(folder, "validate" + file).code == 0);
        const ProgramResult result =
            RunProgram(folder, "bench decode" + file + "--backend cpu --repeat 1 --json");
        REQUIRE(result.code == 0);
        const auto bench = ParseValid(result.output, "bench-decode");
        REQUIRE(bench["results"].Size() >= 1);
        // A kernel that this processor lacks has a reason in place of a checksum; the first entry, the reference,
        // always runs.
        for (const auto& decoder : bench["results"].GetArray()) {
            if (decoder.HasMember("skipped")) {
                MESSAGE("SKIP: " << std::string(decoder["skipped"].GetString()));
                continue;
            }
            REQUIRE(decoder.HasMember("crc32"));
            CHECK(decoder["crc32"].GetUint() == bench["results"][0]["crc32"].GetUint());
        }
        std::ostringstream list;
        for (int mip = 0; mip < 9; ++mip) {
            for (int i = 0; i < 256 >> mip; i += 3)
                list << mip << ' ' << i << ' ' << i / 2 << '\n';
        }
        WriteText(folder / "list", list.str());
        const ProgramResult fast = RunProgram(folder, "sample" + file + "--texels list --csv");
        CHECK(fast.code == 0);
        CHECK(RunProgram(folder, "sample" + file + "--texels list --csv --backend reference").output ==
              fast.output);
    }
    CHECK(bytes <= 300 * 1024);
}

TEST_CASE("OPENNTC_SIMD_CAP takes kernels away from the whole program, and a name that it does not know is "
          "an error") {
    const Folder folder;
    const std::string set =
        "'" + (fs::path(NTC_SCHEMA_DIR).parent_path() / "examples/materials/data/bricks.ntc").string() + "'";
    const auto count = [&](const std::string& cap) {
        const ProgramResult result = RunProgramWith(
            folder, "OPENNTC_SIMD_CAP=" + cap, "bench decode " + set + " --backend cpu --repeat 1 --json");
        REQUIRE(result.code == 0);
        const auto bench = ParseValid(result.output, "bench-decode");
        int kernels = 0;
        for (const auto& decoder : bench["results"].GetArray())
            kernels += decoder.HasMember("skipped") ? 0 : 1;
        return kernels;
    };
    // The portable kernel always runs; a wider cap never takes a kernel away.
    const int portable = count("none");
    CHECK(portable >= 1);
    int before = portable;
    for (const char* cap : {"avx2", "avxvnni", "avx512", "amx"}) {
        CAPTURE(cap);
        const int kernels = count(cap);
        CHECK(kernels >= before);
        before = kernels;
    }
    const ProgramResult unknown = RunProgramWith(folder, "OPENNTC_SIMD_CAP=avx3", "info " + set);
    CHECK(unknown.code == 2);
    CHECK(unknown.errors ==
          "ntc: environment: OPENNTC_SIMD_CAP: avx3: must be none, avx2, avxvnni, avx512 or amx\n");
    CHECK(unknown.output.empty());
}
