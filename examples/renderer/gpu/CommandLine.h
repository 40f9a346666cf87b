// SPDX-License-Identifier: MIT
// Options of `ntc-renderer`.
#pragma once

#include "renderer/gpu/RenderOptions.h"

#include <string>

namespace openntc::renderer {

/// Which program's options are parsed: the window has no files to write from the start, and takes a script.
enum class Program { Headless, Window };

struct CommandLine {
    std::string model;     ///< empty: the sample scene
    std::string testScene; ///< the name of a generated scene
    std::string materialDir;
    std::string output;
    std::string stats;
    std::string device;
    std::string camera; ///< a name or a number in the file, or "orbit"; empty: the file's first, else orbit
    std::string sources;
    std::string glslang; ///< a program for cooperative vectors; empty: one on the path
    std::string play;    ///< of the window: a script (Play.h)
    int scene = -1;
    int frames = 1;
    int samples = 1;
    int warmUp = 0;          ///< milliseconds
    float azimuth = 30.0f;   ///< degrees
    float elevation = 15.0f; ///< degrees
    float distance = 1.0f;   ///< factor
    bool debug = false;
    bool choosesMode = true;   ///< no --mode: by what the model has
    bool allowsCoopVec = true; ///< cooperative vectors, on the device
    bool allowsOnLoad = true;
    bool allowsOnSample = true;
    bool allowsOnFeedback = true;
    RenderOptions render;

    CommandLine();
};

/// Throws CommandError(Usage). False: help or the version was asked for and has been printed.
bool ParseCommandLine(int argc, char** argv, CommandLine& line, Program program = Program::Headless);

/// Options of view and rendering, as on the command line, on top of what `line` has. Throws CommandError(Usage).
void ApplyOptions(const std::string& options, CommandLine& line);

const char* GetName(Mode mode);
const char* GetName(TextureFilter filter);
const char* GetName(Stochastic stochastic);
const char* GetName(ShadingPath path);
const char* GetName(MaskPath masks);
const char* GetMathName(int math);

} // namespace openntc::renderer
