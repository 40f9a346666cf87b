// SPDX-License-Identifier: MIT
// `synthesize v1|v2|xlarge|gen2|gen3 FILE` writes a texture set with pseudo-random weights and latents: the sets V1 and V2 of
// the format specification, byte for byte; one of the largest network; one of generation 2, which no encoder of ours writes;
// one of generation 3 with compressed latents.
#include <openntc/core/FileStream.h>
#include <openntc/inference/Synthesis.h>

#include <cstdio>
#include <string_view>

namespace {

using namespace openntc;

Expected<SynthesisDesc> MakeDesc(std::string_view name) {
    SynthesisDesc synthesis;
    if (name == "v1") {
        synthesis.seed = 1;
        synthesis.desc = {24, 20, 4, 4};
        synthesis.shape = {4, 4, 8, 2, 4};
    } else if (name == "v2") {
        synthesis.seed = 2;
        synthesis.desc = {40, 64, 4, 6};
        synthesis.shape = {2, 12, 16, 4, 8};
    } else if (name == "xlarge") {
        synthesis.seed = 3;
        synthesis.desc = {30, 22, 16, 4};
        synthesis.networkVersion = NTC_NETWORK_XLARGE;
        synthesis.shape = {2, 16, 16, 4, 4};
    } else if (name == "gen2") {
        synthesis.seed = 4;
        synthesis.desc = {50, 38, 6, 4};
        synthesis.networkVersion = NTC_NETWORK_GENERATION_2;
        synthesis.shape = MakeLayeredShape(4, 8);
        synthesis.withFP8 = true; // every set of generation 2 has it
    } else if (name == "gen3") {
        synthesis.seed = 5;
        synthesis.desc = {37, 50, 6, 4};
        synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
        synthesis.shape = MakeLayeredShape(3, 12);
        synthesis.compression.latents = true;
        synthesis.compression.largestRatio = 2.0f; // noise does not get smaller
    } else {
        return Fail(Status::InvalidArgument, "set: must be v1, v2, xlarge, gen2 or gen3");
    }
    return synthesis;
}

Expected<void> Run(std::string_view name, const char* path) {
    OPENNTC_ASSIGN(const SynthesisDesc synthesis, MakeDesc(name));
    OPENNTC_ASSIGN(FileWriter file, FileWriter::Create(path));
    OPENNTC_CHECK(SynthesizeTextureSet(file, synthesis));
    return file.Commit();
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: synthesize v1|v2|xlarge|gen2|gen3 FILE\n");
        return 2;
    }
    if (const Expected<void> done = Run(argv[1], argv[2]); !done) {
        std::fprintf(stderr, "synthesize: %s: %s\n", argv[2], done.error().GetText());
        return 1;
    }
    return 0;
}
