// SPDX-License-Identifier: MIT
#include "DeviceList.h"

#include "Output.h"

#include "vulkan_harness/Devices.h"

namespace openntc::tool {

namespace {

struct Use {
    harness::Feature feature;
    const char* text;
};

constexpr Use kUses[] = {
    {harness::Feature::IntegerDotProduct, "int8 and int8_half faster"},
    {harness::Feature::Float16, "16-bit arithmetic of the epilogue (NTC_NATIVE_FLOAT16)"},
    {harness::Feature::BufferArrays, "many sets, by a uniform index"},
    {harness::Feature::NonUniformIndexing, "many sets, by an index that differs between texels"},
    {harness::Feature::BufferDeviceAddress, "many sets, by address"},
    {harness::Feature::CooperativeVectors, "coopvec_int8 and coopvec_fp8"},
    {harness::Feature::MemoryDecompression, "compressed latents of generation 3 by the device itself"},
};

DeviceEntry Describe(const harness::DeviceInfo& info) {
    constexpr std::uint32_t kShuffleLanes = 8; // NTC_FETCH_SUBGROUP passes words between as many
    DeviceEntry entry;
    entry.index = info.index;
    entry.name = info.name;
    entry.driver = info.driver;
    entry.apiVersion = Format("%u.%u.%u", info.apiVersion >> 22 & 0x7fu, info.apiVersion >> 12 & 0x3ffu,
                              info.apiVersion & 0xfffu);
    entry.isCpu = info.isCpu;
    entry.subgroupSize = info.subgroupSize;
    entry.math = {"int8", "int8_half", "fp8", "fp16", "fp32"}; // with plain 32-bit arithmetic
    if (info.cooperativeVectors.hasCooperativeVectors && info.cooperativeVectors.hasInt8)
        entry.math.emplace_back("coopvec_int8");
    if (info.cooperativeVectors.hasCooperativeVectors && info.cooperativeVectors.hasE4M3)
        entry.math.emplace_back("coopvec_fp8");
    if (info.hasByteMatrices) {
        entry.math.emplace_back("coopmat_int8");
        entry.math.emplace_back("coopmat_int8_half");
    }
    for (const Use& use : kUses)
        entry.features.push_back(
            {harness::GetFeatureName(use.feature), use.text, info.features.GetAbsence(use.feature)});
    std::string matrices = info.features.GetAbsence(harness::Feature::CooperativeMatrices);
    if (matrices.empty() && !info.hasByteMatrices)
        matrices =
            Format("none of signed bytes, 16 x 16 x 32, at subgroup scope with 32 lanes; subgroups of %u",
                   info.subgroupSize);
    entry.features.push_back({harness::GetFeatureName(harness::Feature::CooperativeMatrices),
                              "coopmat_int8 and coopmat_int8_half, in passes that decode blocks", matrices});
    std::string shuffle;
    if (!info.hasSubgroupShuffle)
        shuffle = "not in compute shaders";
    else if (info.subgroupSize < kShuffleLanes)
        shuffle = Format("%u lanes: %u are needed", info.subgroupSize, kShuffleLanes);
    entry.features.push_back(
        {"subgroup shuffle", "weights fetched once a subgroup (NTC_FETCH_SUBGROUP)", shuffle});
    return entry;
}

} // namespace

Expected<std::vector<DeviceEntry>> ListVulkanDevices() {
    OPENNTC_ASSIGN(const std::vector<harness::DeviceInfo> devices, harness::ListDevices());
    std::vector<DeviceEntry> entries;
    for (const harness::DeviceInfo& info : devices)
        entries.push_back(Describe(info));
    return entries;
}

} // namespace openntc::tool
