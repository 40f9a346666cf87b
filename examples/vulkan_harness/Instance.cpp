// SPDX-License-Identifier: MIT
// The loader and the instance.
#include "VulkanObjects.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace openntc::harness {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// The Vulkan loader. It is never closed: drivers leave threads and exit handlers behind in it.
PFN_vkGetInstanceProcAddr OpenLoader(const std::string& library) {
#if defined(_WIN32)
    const HMODULE module = LoadLibraryA(library.empty() ? "vulkan-1.dll" : library.c_str());
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(
        reinterpret_cast<void*>(GetProcAddress(module, "vkGetInstanceProcAddr")));
#else
    void* module = nullptr;
    if (!library.empty()) {
        module = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    } else {
        for (const char* name : {"libvulkan.so.1", "libvulkan.so"}) {
            if (module == nullptr)
                module = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        }
    }
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(module, "vkGetInstanceProcAddr"));
#endif
}

VKAPI_ATTR VkBool32 VKAPI_CALL OnMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    ValidationLog& log = *static_cast<ValidationLog*>(user);
    try {
        const std::string text = data->pMessage != nullptr ? data->pMessage : "(no text)";
        if ((severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT) != 0)
            log.errors.push_back(text);
        else
            log.warnings.push_back(text);
    } catch (const std::exception&) {
        std::abort(); // no memory left to keep the message, and it must not be lost
    }
    return VK_FALSE;
}

bool HasName(const std::vector<vk::ExtensionProperties>& list, const char* name) {
    return std::any_of(list.begin(), list.end(),
                       [name](const auto& item) { return std::strcmp(item.extensionName, name) == 0; });
}

} // namespace

Expected<std::unique_ptr<Instance>> MakeInstance(const std::string& loaderLibrary, ValidationLog* log,
                                                 const std::vector<std::string>& surfaceExtensions) {
    const PFN_vkGetInstanceProcAddr loader = OpenLoader(loaderLibrary);
    if (loader == nullptr) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan loader %s: cannot be opened",
                    loaderLibrary.empty() ? "(system)" : loaderLibrary.c_str());
    }
    auto result = std::make_unique<Instance>(loader);
    result->apiVersion = result->context.enumerateInstanceVersion();
    if (result->apiVersion < VK_API_VERSION_1_1)
        return Fail(Status::Unsupported, "device or feature absent: Vulkan 1.1: the loader offers 1.0 only");

    const vk::ApplicationInfo application("openntc", 1, "openntc", 1,
                                          std::min<std::uint32_t>(result->apiVersion, VK_API_VERSION_1_3));
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    vk::DebugUtilsMessengerCreateInfoEXT messages(
        {},
        vk::DebugUtilsMessageSeverityFlagBitsEXT::eError | vk::DebugUtilsMessageSeverityFlagBitsEXT::eWarning,
        vk::DebugUtilsMessageTypeFlagBitsEXT::eValidation | vk::DebugUtilsMessageTypeFlagBitsEXT::eGeneral,
        OnMessage, log);
    vk::InstanceCreateInfo info({}, &application);
    if (log != nullptr) {
        const auto available = result->context.enumerateInstanceLayerProperties();
        const bool found = std::any_of(available.begin(), available.end(), [](const auto& layer) {
            return std::strcmp(layer.layerName, kValidationLayer) == 0;
        });
        if (!found)
            return Fail(Status::Unsupported, "device or feature absent: %s: layer not installed",
                        kValidationLayer);
        const std::string layerName = kValidationLayer;
        if (!HasName(result->context.enumerateInstanceExtensionProperties(layerName),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME) &&
            !HasName(result->context.enumerateInstanceExtensionProperties(),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME))
            return Fail(Status::Unsupported,
                        "device or feature absent: VK_EXT_debug_utils: needed for validation");
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        info.setPNext(&messages);
    }
    for (const std::string& extension : surfaceExtensions) {
        if (!HasName(result->context.enumerateInstanceExtensionProperties(), extension.c_str()))
            return Fail(Status::Unsupported, "device or feature absent: %s: the loader does not have it",
                        extension.c_str());
        extensions.push_back(extension.c_str());
    }
    info.setPEnabledLayerNames(layers);
    info.setPEnabledExtensionNames(extensions);
    result->instance = vk::raii::Instance(result->context, info);
    if (log != nullptr)
        result->messenger = vk::raii::DebugUtilsMessengerEXT(result->instance, messages);
    return result;
}

} // namespace openntc::harness
