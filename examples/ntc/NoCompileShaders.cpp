// SPDX-License-Identifier: MIT
// `ntc compile-shaders` of a build without glslang's library.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"

namespace openntc::tool {

void AddCompileShadersCommand(CLI::App& app, Action& action) {
    CLI::App* command =
        app.add_subcommand("compile-shaders", "Shader permutations to SPIR-V")->allow_extras();
    command->callback([&action] {
        action = []() -> int {
            throw CommandError(ExitCode::NoDevice, "compile-shaders",
                               "compiler: not in this build: it was made without glslang's library");
        };
    });
}

} // namespace openntc::tool
