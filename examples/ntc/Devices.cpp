// SPDX-License-Identifier: MIT
// `ntc devices`: what --device can name, and what it can do.
#include "Arguments.h"
#include "Commands.h"
#include "DeviceList.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"

#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

namespace {

void PrintText(const std::vector<DeviceEntry>& devices) {
    for (const DeviceEntry& device : devices) {
        std::string math;
        for (const std::string& mode : device.math)
            math += (math.empty() ? "" : ", ") + mode;
        WriteOutput(Format(
            "%u  %s\n   driver  %s, Vulkan %s\n   type    %s, subgroups of %u\n   maths   %s\n", device.index,
            Printable(device.name).c_str(), Printable(device.driver).c_str(), device.apiVersion.c_str(),
            device.isCpu ? "CPU" : "GPU", device.subgroupSize, math.c_str()));
        for (const DeviceFeature& feature : device.features)
            WriteOutput(Format("   %-3s     %s: %s%s\n", feature.reason.empty() ? "has" : "no",
                               feature.name.c_str(), feature.use.c_str(),
                               feature.reason.empty() ? "" : (" (" + feature.reason + ")").c_str()));
    }
    WriteOutput(devices.empty() ? "no Vulkan devices\n" : "");
}

void PrintJson(const std::vector<DeviceEntry>& devices) {
    JsonWriter json;
    json.BeginObject();
    json.Key("devices");
    json.BeginArray();
    for (const DeviceEntry& device : devices) {
        json.BeginObject();
        json.Member("index", device.index);
        json.Member("name", std::string_view(device.name));
        json.Member("driver", std::string_view(device.driver));
        json.Member("apiVersion", std::string_view(device.apiVersion));
        json.Member("type", device.isCpu ? "CPU" : "GPU");
        json.Member("subgroupSize", device.subgroupSize);
        json.Key("math");
        json.BeginArray();
        for (const std::string& mode : device.math)
            json.Value(std::string_view(mode));
        json.EndArray();
        json.Key("features");
        json.BeginArray();
        for (const DeviceFeature& feature : device.features) {
            json.BeginObject();
            json.Member("name", std::string_view(feature.name));
            json.Member("use", std::string_view(feature.use));
            json.Member("present", feature.reason.empty());
            json.Member("reason", std::string_view(feature.reason));
            json.EndObject();
        }
        json.EndArray();
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(json.Take());
}

} // namespace

void AddDevicesCommand(CLI::App& app, Action& action) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand("devices", "List the Vulkan devices that --device can name");
    AddJsonFlag(*command, *json);
    command->callback([json, &action] {
        action = [json] {
            const std::vector<DeviceEntry> devices =
                Require(ListVulkanDevices(), ExitCode::NoDevice, "devices");
            *json ? PrintJson(devices) : PrintText(devices);
            return static_cast<int>(devices.empty() ? ExitCode::NoDevice : ExitCode::Ok);
        };
    });
}

} // namespace openntc::tool
