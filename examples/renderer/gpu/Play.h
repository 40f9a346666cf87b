// SPDX-License-Identifier: MIT
// Scripts for the window (`--play FILE`), a step a line:
//   --mode on-load --size 320x240   options of rendering and view; --size is the window's
//   frames 16                       goes on after so many frames
//   screenshot a.png                the picture, without the panel
//   capture b.png                   what the window shows
//   minimize / restore / quit
// Empty lines, and what follows #, are nothing.
#pragma once

#include "renderer/gpu/CommandLine.h"

#include <string>
#include <vector>

namespace openntc::renderer {

enum class PlayAction { Options, Frames, Screenshot, Capture, Minimize, Restore, Quit };

struct PlayStep {
    PlayAction action = PlayAction::Quit;
    std::string text; ///< options, or a file's name
    int frames = 0;   ///< of Frames, 1 ... 100000
};

/// Throws CommandError(BadInput) that names the line, for options too.
std::vector<PlayStep> ReadPlay(const std::string& path);

} // namespace openntc::renderer
