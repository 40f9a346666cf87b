// SPDX-License-Identifier: MIT
// `ntc-viewer`: a glTF model with neural materials in a window.
#include "renderer/gpu/CommandLine.h"
#include "renderer/window/Viewer.h"

#include "RunMain.h"

namespace {

int Run(int argc, char** argv) {
    openntc::renderer::CommandLine line;
    if (!ParseCommandLine(argc, argv, line, openntc::renderer::Program::Window))
        return 0;
    openntc::renderer::Viewer(line).Run();
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return openntc::tool::RunMain("ntc-viewer", [&] { return Run(argc, argv); });
}
