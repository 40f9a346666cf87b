// SPDX-License-Identifier: MIT
// The SPIR-V of cooperative vectors that is kept in the tree has the shape that its defines call for: capabilities, bindings,
// the layout of the constants, and the four multiplications of the network.
#include "shader/ConstantFields.h"
#include "shader/SpirvLayout.h"

#include "openntc/format/NetworkDescription.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

// From SPIR-V's registry: SPV_NV_cooperative_vector.
constexpr std::uint32_t kCooperativeVector = 5394, kMultiplyAdd = 5292;
constexpr std::uint32_t kSignedInt8 = 3, kSignedInt32 = 5, kFloat16 = 0, kSignedInt8Packed = 1000491000,
                        kE4M3 = 1000491002;
constexpr std::uint32_t kInferencingOptimal = 2;

struct StoredModule {
    std::string source, defines;
    std::vector<std::uint32_t> words;

    int GetNumber(const std::string& name) const {
        const std::size_t at = (" " + defines).find(" " + name + "=");
        REQUIRE(at != std::string::npos);
        return std::stoi(defines.substr(at + name.size() + 1));
    }
};

std::vector<StoredModule> ReadModules() {
    std::ifstream index(NTC_COOPVEC_FOLDER "/index.txt");
    std::vector<StoredModule> modules;
    std::string file, line;
    while (std::getline(index, line)) {
        std::istringstream fields(line);
        StoredModule module;
        std::getline(fields, file, '\t');
        std::getline(fields, module.source, '\t');
        std::getline(fields, module.defines, '\t');
        std::ifstream stream(NTC_COOPVEC_FOLDER "/" + file, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
        REQUIRE(bytes.size() % 4 == 0);
        module.words.resize(bytes.size() / 4);
        std::memcpy(module.words.data(), bytes.data(), bytes.size());
        modules.push_back(std::move(module));
    }
    return modules;
}

/// What the instructions of a module say; `isWhole`: they end where the module does.
struct Contents {
    std::set<std::uint32_t> capabilities;
    std::set<std::string> extensions;
    std::set<std::pair<std::uint32_t, std::uint32_t>> bindings; // set, binding
    std::vector<std::vector<std::uint32_t>> products;           // operands, constants by value
    std::vector<std::uint32_t> workgroup;
    std::size_t entryPoints = 0;
    bool isWhole = false;
};

Contents ReadContents(const std::vector<std::uint32_t>& words) {
    constexpr std::uint32_t kExtension = 10, kEntryPoint = 15, kExecutionMode = 16, kCapability = 17,
                            kConstant = 43;
    constexpr std::uint32_t kDecorate = 71, kBinding = 33, kDescriptorSet = 34, kLocalSize = 17;
    Contents contents;
    std::map<std::uint32_t, std::uint32_t> constants, sets, bindings;
    std::size_t at = 5;
    while (at < words.size()) {
        const std::size_t count = words[at] >> 16;
        if (count == 0 || count > words.size() - at)
            return contents;
        const std::uint32_t op = words[at] & 0xFFFFu;
        const std::vector<std::uint32_t> operands(words.begin() + static_cast<std::ptrdiff_t>(at + 1),
                                                  words.begin() + static_cast<std::ptrdiff_t>(at + count));
        if (op == kCapability)
            contents.capabilities.insert(operands.at(0));
        else if (op == kExtension)
            contents.extensions.insert(reinterpret_cast<const char*>(operands.data()));
        else if (op == kEntryPoint)
            ++contents.entryPoints;
        else if (op == kExecutionMode && operands.at(1) == kLocalSize)
            contents.workgroup.assign(operands.begin() + 2, operands.end());
        else if (op == kConstant)
            constants[operands.at(1)] = operands.at(2);
        else if (op == kDecorate && operands.at(1) == kBinding)
            bindings[operands.at(0)] = operands.at(2);
        else if (op == kDecorate && operands.at(1) == kDescriptorSet)
            sets[operands.at(0)] = operands.at(2);
        else if (op == kMultiplyAdd)
            contents.products.push_back(operands);
        at += count;
    }
    for (const auto& [id, binding] : bindings)
        contents.bindings.insert({sets[id], binding});
    for (std::vector<std::uint32_t>& product : contents.products) {
        // All but the types and the operands that are computed.
        for (const std::size_t i : {3u, 6u, 9u, 10u, 11u, 12u})
            product.at(i) = constants.at(product.at(i));
    }
    contents.isWhole = true;
    return contents;
}

} // namespace

TEST_CASE("stored cooperative vectors: every network and both maths modes are there") {
    std::set<std::pair<int, int>> report, bench;
    for (const StoredModule& module : ReadModules()) {
        const std::pair<int, int> kind{module.GetNumber("NETWORK_VERSION"), module.GetNumber("NTC_MATH")};
        (module.source.ends_with("ReportDecode.comp") ? report : bench).insert(kind);
    }
    CHECK(report.size() == 12);
    CHECK(bench.size() == 12);
}

TEST_CASE("stored cooperative vectors: capabilities, bindings and constants") {
    for (const StoredModule& module : ReadModules()) {
        CAPTURE(module.source);
        CAPTURE(module.defines);
        REQUIRE(module.words.size() > 5);
        CHECK(module.words[0] == 0x07230203u);
        CHECK(module.words[1] == 0x00010600u); // SPIR-V 1.6, of Vulkan 1.3
        const Contents contents = ReadContents(module.words);
        REQUIRE(contents.isWhole);
        CHECK(contents.entryPoints == 1);
        CHECK(contents.workgroup == std::vector<std::uint32_t>{8, 8, 1});
        CHECK(contents.capabilities.count(kCooperativeVector) == 1);
        CHECK(contents.extensions.count("SPV_NV_cooperative_vector") == 1);
        CHECK(contents.bindings ==
              std::set<std::pair<std::uint32_t, std::uint32_t>>{{0, 0}, {0, 1}, {0, 2}, {0, 3}});
        const SpirvLayout layout(module.words);
        const auto* members = layout.FindStruct("NtcTextureSetConstants");
        REQUIRE(members != nullptr);
        Fields fields;
        layout.Flatten(*members, "", 0, fields);
        CHECK(fields == GetCppFields());
    }
}

TEST_CASE("stored cooperative vectors: the multiplications of the network") {
    for (const StoredModule& module : ReadModules()) {
        CAPTURE(module.source);
        CAPTURE(module.defines);
        const NetworkDescription network = GetNetworkDescription(module.GetNumber("NETWORK_VERSION"));
        const bool isFP8 = module.GetNumber("NTC_MATH") == 7;
        const Contents contents = ReadContents(module.words);
        REQUIRE(contents.products.size() == 4);
        for (std::size_t layer = 0; layer < 4; ++layer) {
            CAPTURE(layer);
            const std::vector<std::uint32_t>& product = contents.products[layer];
            // The last layer is Int8 in both modes.
            const bool isE4M3 = isFP8 && layer < 3;
            const bool isPacked = !isFP8 && layer == 0;
            CHECK(product.at(3) == (isE4M3 ? kE4M3 : isPacked ? kSignedInt8Packed : kSignedInt8));
            CHECK(product.at(6) == (isE4M3 ? kE4M3 : kSignedInt8));
            CHECK(product.at(9) == (isE4M3 ? kFloat16 : kSignedInt32));
            CHECK(product.at(10) == static_cast<std::uint32_t>(network.outputs.at(layer)));
            CHECK(product.at(11) == static_cast<std::uint32_t>(network.inputs.at(layer)));
            CHECK(product.at(12) == kInferencingOptimal);
        }
    }
}
