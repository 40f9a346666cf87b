// SPDX-License-Identifier: MIT
// What the program with a window and the one without do alike: a scene, a mode, a device, cameras.
#pragma once

#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/ShaderCache.h"
#include "renderer/scene/Scene.h"

#include "vulkan_harness/Vulkan.h"

#include <memory>
#include <string>
#include <vector>

namespace openntc::renderer {

/// The model, the generated scene or the sample scene that the command line names. Throws CommandError.
Scene LoadScene(const CommandLine& line);

/// The mode of a command line that names none, by what the scene has. Throws CommandError(BadInput) for a mode that needs
/// texture sets where there are none.
void ChooseMode(const Scene& scene, CommandLine& line);

/// Of the orbit, turned by `turn` degrees; or of the file. Throws CommandError(Usage) for a name that the scene does not have.
Camera ChooseCamera(const Scene& scene, const CommandLine& line, float turn = 0.0f);

/// A device that can do what the renderer needs; with extensions of the instance also windows. Throws CommandError(NoDevice).
std::unique_ptr<harness::Context> OpenDevice(const CommandLine& line,
                                             const std::vector<std::string>& surfaceExtensions = {});

/// Where shaders and the sample scene's texture sets are: --sources, else <prefix>/share/openntc of a program that was installed,
/// else the source that it was built from.
std::string FindSources(const CommandLine& line);

/// The compiler of those shaders.
ShaderCache MakeShaderCache(const CommandLine& line);

/// A line on standard error for each thing that is not shown as the files say. `program`: its name.
void PrintWarnings(const char* program, const Scene& scene);

} // namespace openntc::renderer
