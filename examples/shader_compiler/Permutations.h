// SPDX-License-Identifier: MIT
// Which permutations there are, and what they are called: the same rules as cmake/OpenNTCShaderPlan.cmake, which says why
// there are two, and by what they are kept equal.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::shader_compiler {

enum class Stage { Compute, Fragment, Vertex };

/// Is a definition a maths mode of cooperative vectors or matrices, which few compilers know?
bool IsCooperativeMath(std::string_view define);

/// One thing to compile.
struct Permutation {
    std::filesystem::path path; ///< the source file
    std::string source;         ///< its name in an index: file name, and ":ENTRY" unless that is main
    Stage stage = Stage::Compute;
    bool hlsl = false;
    std::string entry = "main";
    std::vector<std::string> defines; ///< "NAME=VALUE", in the order of the axes

    std::string GetDefines() const;  ///< joined by spaces
    std::string GetFileName() const; ///< "SOURCE+NAME=VALUE+….spv"
    std::string GetFlatName() const; ///< the same of flattened text: .glsl or .hlsl
    std::string
    GetKey() const; ///< "SOURCE|DEFINES", the defines sorted; identifies the permutation in a blob
    bool NeedsCooperativeVectors() const; ///< or matrices, which are older in glslang
};

/// A list of alternatives for one macro: "NAME", "NAME=VALUE" or "NAME={V1,V2}"; an empty alternative leaves the macro
/// undefined. Throws Failure(Usage).
struct DefineAxis {
    std::string name;
    std::vector<std::string> values;
};
DefineAxis ParseDefine(std::string_view text);

/// A source with the axes of its own.
struct SourceRequest {
    std::filesystem::path path;
    std::string stage; ///< "comp", "frag", "vert" or empty: the file's ending says it
    std::string entry; ///< empty: main
    std::vector<DefineAxis> axes;
    std::string list{}; ///< the list file that names it, or empty
    int line = 0;       ///< there
};

/// Reads a list file: lines `path -T cs|ps|vs [-E entry] [-D X={0,1}]…` with `//` comments and #if 0, #if 1, #ifdef,
/// #else, #endif (ShaderMake's grammar; no name is defined). Paths are relative to the file. Throws Failure(Input), also
/// when nothing is listed.
std::vector<SourceRequest> ReadListFile(const std::filesystem::path& file);

/// Every combination of `axes` and then of each source's own. Throws Failure(Usage), of a list's line Failure(Input): a stage
/// that nothing tells, a macro or a permutation twice.
std::vector<Permutation> ListPermutations(const std::vector<SourceRequest>& sources,
                                          const std::vector<DefineAxis>& axes);

} // namespace openntc::shader_compiler
