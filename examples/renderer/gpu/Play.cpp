// SPDX-License-Identifier: MIT
#include "renderer/gpu/Play.h"

#include "renderer/gpu/PictureFile.h"

#include "Arguments.h"
#include "Failure.h"
#include "InputFile.h"
#include "Output.h"

#include <sstream>

namespace openntc::renderer {

namespace {

using tool::CommandError;
using tool::ExitCode;

constexpr const char* kBlanks = " \t\r";

std::string Trim(const std::string& text) {
    const std::size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string::npos)
        return "";
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Throws CommandError(Usage).
PlayStep ParseStep(const std::string& text) {
    PlayStep step;
    if (text.starts_with("-")) {
        CommandLine scratch;
        ApplyOptions(text, scratch); // wrong ones at once
        step.action = PlayAction::Options;
        step.text = text;
        return step;
    }
    const std::size_t blank = text.find_first_of(kBlanks);
    const std::string word = text.substr(0, blank);
    const std::string rest = blank == std::string::npos ? "" : Trim(text.substr(blank));
    if (word == "frames") {
        step.action = PlayAction::Frames;
        step.frames = static_cast<int>(tool::ParseNumber(word, rest, {1, 100000}, true));
        return step;
    }
    if (word == "screenshot" || word == "capture") {
        step.action = word == "capture" ? PlayAction::Capture : PlayAction::Screenshot;
        step.text = rest;
        CheckPictureName(word, rest);
        return step;
    }
    if (word == "minimize")
        step.action = PlayAction::Minimize;
    else if (word == "restore")
        step.action = PlayAction::Restore;
    else if (word != "quit")
        tool::FailUsage(word, "one of frames, screenshot, capture, minimize, restore, quit, or options");
    if (!rest.empty())
        tool::FailUsage(word, rest + ": takes nothing");
    return step;
}

} // namespace

std::vector<PlayStep> ReadPlay(const std::string& path) {
    std::istringstream lines(tool::ReadAllText(path));
    std::vector<PlayStep> steps;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        const std::string text = Trim(line.substr(0, line.find('#')));
        if (text.empty())
            continue;
        try {
            steps.push_back(ParseStep(text));
        } catch (const CommandError& error) {
            throw CommandError(
                ExitCode::BadInput, path,
                tool::Format("line %d: %s: %s", number, error.GetSubject().c_str(), error.what()));
        }
    }
    return steps;
}

} // namespace openntc::renderer
