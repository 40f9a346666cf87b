// SPDX-License-Identifier: MIT
#include "renderer/window/Panel.h"

#include "renderer/gpu/Stats.h"

#define GLFW_INCLUDE_VULKAN // as Window.cpp, with which a unity build compiles it
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_vulkan.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace openntc::renderer {

namespace {

constexpr int kMostSamples = 65535;

/// A list of what GetName has names for.
template <typename T, typename GetText>
void Choose(const char* label, T& value, GetText getText) {
    constexpr int kMost = 16; // more than any of the lists
    if (!ImGui::BeginCombo(label, getText(value)))
        return;
    for (int i = 0; i < kMost; ++i) {
        const T candidate = static_cast<T>(i);
        const char* const name = getText(candidate);
        if (std::strcmp(name, "?") != 0 && ImGui::Selectable(name, candidate == value))
            value = candidate;
    }
    ImGui::EndCombo();
}

template <typename T>
void Choose(const char* label, T& value) {
    Choose(label, value, [](T candidate) { return GetName(candidate); });
}

void BuildOptions(CommandLine& line, int usedMath, int& shrink) {
    RenderOptions& render = line.render;
    Choose("mode", render.mode);
    Choose("filter", render.filter);
    Choose("stf", render.stochastic);
    Choose("math", render.math, [](int math) { return GetMathName(math); });
    if (render.mode == Mode::OnSample)
        ImGui::TextDisabled("decodes with %s", GetMathName(usedMath));
    Choose("path", render.path);
    Choose("masks", render.masks);
    if (bool hasBlocks = !render.keepsTexels; ImGui::Checkbox("blocks on load", &hasBlocks))
        render.keepsTexels = !hasBlocks;
    if (render.mode == Mode::OnFeedback) {
        ImGui::SameLine();
        if (bool waits = render.settle != 0; ImGui::Checkbox("wait for tiles", &waits))
            render.settle = waits ? -1 : 0;
    }
    if (bool accumulates = line.samples > 1; ImGui::Checkbox("mean of frames", &accumulates))
        line.samples = accumulates ? kMostSamples : 1;
    ImGui::SameLine();
    ImGui::Checkbox("R2", &render.randomR2);
    bool allEffects = render.forcedEffects == GetForceableEffects();
    if (ImGui::Checkbox("all effects", &allEffects))
        render.forcedEffects = allEffects ? GetForceableEffects() : 0;
    ImGui::SameLine();
    ImGui::Checkbox("count texels", &render.counts);
    float stops = std::log2(render.exposure);
    if (ImGui::SliderFloat("exposure", &stops, -4.0f, 4.0f, "%.1f EV"))
        render.exposure = std::exp2(stops);
    constexpr const char* kShrinks[] = {"1", "1/2", "1/4"};
    int index = shrink == 4 ? 2 : shrink - 1;
    if (ImGui::Combo("scale", &index, kShrinks, 3))
        shrink = 1 << index;
}

void BuildCameras(const PanelFacts& facts, PanelRequests& requests) {
    requests.orbit = ImGui::Button("orbit");
    ImGui::SameLine();
    requests.firstPerson = ImGui::Button("first person");
    for (std::size_t i = 0; i < facts.cameras.size(); ++i) {
        ImGui::SameLine();
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::Button(facts.cameras[i].empty() ? "camera" : facts.cameras[i].c_str()))
            requests.camera = static_cast<int>(i);
        ImGui::PopID();
    }
    ImGui::TextDisabled("drag: turn; wheel: nearer; right drag: pan");
    ImGui::TextDisabled("first person: W A S D Q E, Shift: faster");
}

void BuildTimes(const PanelFacts& facts) {
    double total = 0.0;
    for (const double seconds : facts.seconds)
        total += seconds;
    ImGui::Text("%.2f ms a frame, %d in the mean, %d x %d", 1e3 * total, facts.frames, facts.width,
                facts.height);
    for (std::size_t pass = 0; pass < kPassCount; ++pass) {
        if (facts.seconds[pass] > 0.0)
            ImGui::Text("  %-10s %8.3f ms", GetPassName(static_cast<Pass>(pass)), 1e3 * facts.seconds[pass]);
    }
    const double pixels = std::max(1.0, static_cast<double>(facts.width) * facts.height);
    if (facts.renderer->GetOptions().counts)
        ImGui::Text("texels per pixel: %.2f read, %.2f decoded",
                    static_cast<double>(facts.texels.read) / pixels,
                    static_cast<double>(facts.texels.decoded) / pixels);
}

void BuildBytes(const Renderer& renderer) {
    for (const BytesOfKind& kind : ListBytes(renderer)) {
        if (kind.bytes > 0)
            ImGui::Text("  %-16s %10.3f MB", kind.name, 1e-6 * static_cast<double>(kind.bytes));
    }
}

ViewMotion ReadMotion(float seconds) {
    constexpr float kTurn = 0.005f; // radians a pixel
    constexpr float kPan = 0.004f;  // radii a pixel
    constexpr float kZoom = 0.15f;  // of a step of the wheel
    constexpr float kWalk = 0.5f;   // radii a second
    ViewMotion motion;
    const ImGuiIO& io = ImGui::GetIO();
    if (!io.WantCaptureMouse) {
        const glm::vec2 moved(io.MouseDelta.x, -io.MouseDelta.y);
        if (io.MouseDown[0])
            motion.turn = kTurn * moved;
        else if (io.MouseDown[1] || io.MouseDown[2])
            motion.step = -kPan * glm::vec3(moved, 0.0f);
        motion.zoom = kZoom * io.MouseWheel;
    }
    if (!io.WantCaptureKeyboard) {
        const auto axis = [](int more, int less) {
            return static_cast<float>(ImGui::IsKeyDown(more)) - static_cast<float>(ImGui::IsKeyDown(less));
        };
        motion.step += (io.KeyShift ? 4.0f : 1.0f) * kWalk * seconds *
                       glm::vec3(axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_E, GLFW_KEY_Q),
                                 axis(GLFW_KEY_W, GLFW_KEY_S));
    }
    return motion;
}

} // namespace

Panel::Panel(harness::Context& context, GLFWwindow* window)
    : context_(context), overlay_(RequireDevice(context.CreateOverlay())) {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // no file is left behind
    ImGui::StyleColorsDark();
    ImGui_ImplGlfw_InitForVulkan(window, true);
    const harness::NativeHandles handles = context.GetHandles();
    ImGui_ImplVulkan_InitInfo info = {};
    info.Instance = handles.instance;
    info.PhysicalDevice = handles.physicalDevice;
    info.Device = handles.device;
    info.Queue = handles.queue;
    info.QueueFamily = handles.queueFamily;
    info.DescriptorPool = (VkDescriptorPool)overlay_.GetDescriptorPool(); // NOLINT: a pointer or a number
    info.MinImageCount = info.ImageCount = 2;                             // the least that it takes
    ImGui_ImplVulkan_Init(&info, (VkRenderPass)overlay_.GetRenderPass()); // NOLINT: likewise
    RequireDevice(
        context.Record([](VkCommandBuffer_T* commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); }));
    ImGui_ImplVulkan_DestroyFontUploadObjects();
}

Panel::~Panel() {
    ImGui_ImplVulkan_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

void Panel::Build(const PanelFacts& facts, PanelRequests& requests, float seconds) {
    ImGui_ImplVulkan_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (ImGui::IsKeyPressed(GLFW_KEY_H, false) && !ImGui::GetIO().WantCaptureKeyboard)
        isShown_ = !isShown_;
    requests.screenshot = ImGui::IsKeyPressed(GLFW_KEY_F12, false);
    requests.motion = ReadMotion(seconds);
    if (isShown_) {
        ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
        ImGui::Begin("ntc-viewer", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
        ImGui::PushItemWidth(150.0f);
        ImGui::TextUnformatted(facts.device.c_str());
        BuildOptions(requests.line, facts.renderer->GetTextures().GetMath().math, requests.shrink);
        BuildCameras(facts, requests);
        if (ImGui::CollapsingHeader("time", ImGuiTreeNodeFlags_DefaultOpen))
            BuildTimes(facts);
        if (ImGui::CollapsingHeader("bytes", ImGuiTreeNodeFlags_DefaultOpen))
            BuildBytes(*facts.renderer);
        requests.screenshot = ImGui::Button("screenshot (F12)") || requests.screenshot;
        ImGui::SameLine();
        ImGui::TextDisabled("H: hide");
        if (!facts.message.empty())
            ImGui::TextWrapped("%s", facts.message.c_str());
        ImGui::PopItemWidth();
        ImGui::End();
    }
    ImGui::Render();
}

void Panel::Draw(const harness::Image& target) {
    RequireDevice(context_.Draw(overlay_, target, [](VkCommandBuffer_T* commands) {
        ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands);
    }));
}

} // namespace openntc::renderer
