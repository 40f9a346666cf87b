// SPDX-License-Identifier: MIT
// What the text of the shader headers must and must not hold, for compilers and bundlers that are not at hand here.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

struct Source {
    std::string name;
    std::vector<std::string> lines; ///< comments removed, lines that are continued joined
};

std::vector<Source> ReadHeaders() {
    std::vector<Source> sources;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(NTC_SHADER_DIR "/openntc")) {
        if (entry.path().extension() != ".h" || entry.path().parent_path().filename() == "passes")
            continue;
        std::ifstream file(entry.path(), std::ios::binary);
        std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
        text = std::regex_replace(text, std::regex("//[^\n]*"), "");
        text = std::regex_replace(text, std::regex("\\\\\n"), " ");
        Source source{entry.path().lexically_relative(NTC_SHADER_DIR "/openntc").generic_string(), {}};
        std::istringstream stream(text);
        for (std::string line; std::getline(stream, line);)
            source.lines.push_back(line);
        sources.push_back(std::move(source));
    }
    REQUIRE(sources.size() > 25);
    return sources;
}

/// Words that one of the languages reserves, and functions of theirs that a variable would hide: GLSL 4.60 and ESSL 3.20
/// (3.8 and 3.9 of the specifications), HLSL (Microsoft's "Keywords" and "Reserved Words"), Metal 3 and C++, WGSL ("Keyword"
/// and "Reserved Words"). Words of C++ that shaders use alike (if, for, int, …) are left out.
const char* const kReserved =
    // GLSL, ESSL
    "active asm attribute buffer cast centroid class coherent common enum extern external filter fixed flat "
    "goto half "
    "highp hvec2 hvec3 hvec4 fvec2 fvec3 fvec4 inline input interface invariant layout long lowp mediump "
    "namespace "
    "noinline noperspective output packed partition patch precise precision public readonly resource "
    "restrict sample "
    "sampler shared short sizeof smooth subroutine superp template this typedef uniform union unsigned using "
    "varying "
    "volatile writeonly texture "
    // HLSL
    "AppendStructuredBuffer BlendState Buffer ByteAddressBuffer cbuffer column_major compile "
    "compile_fragment "
    "CompileShader ComputeShader ConsumeStructuredBuffer DepthStencilState dword export fxgroup "
    "GeometryShader "
    "groupshared line lineadj linear LineStream matrix min10float min16float min12int min16int min16uint "
    "nointerpolation "
    "pass pixelfragment PixelShader point PointStream register row_major SamplerState snorm stateblock "
    "string "
    "StructuredBuffer tbuffer technique technique10 technique11 triangle triangleadj TriangleStream unorm "
    "vector "
    "vertexfragment VertexShader auto catch char const_cast delete dynamic_cast explicit friend mutable new "
    "operator "
    "private protected reinterpret_cast signed static_cast throw try typename virtual "
    // Metal and C++
    "constant device thread threadgroup threadgroup_imageblock ray_data object_data kernel vertex fragment "
    "visible "
    "metal access alignas alignof and bitand bitor compl concept consteval constexpr constinit decltype "
    "noexcept not "
    "nullptr or requires static_assert thread_local typeid xor wchar_t ptrdiff_t size_t ushort uchar ulong "
    // WGSL
    "alias NULL Self abstract as async await become co_await co_return co_yield crate debugger demote "
    "demote_to_helper do final finally fn from get global handle impl implements import instanceof let loop "
    "macro "
    "macro_rules match meta mod module move mut nil null of override package packoffset premerge priv pub "
    "ref regardless "
    "require self set std super target trait type unless unsafe unsized use var wgsl where with workgroup "
    "yield diagnostic "
    "enable continuing fallthrough ptr storage function storageBarrier";

} // namespace

TEST_CASE("shader headers: no #if that FXC refuses") {
    // Its preprocessor knows neither ~ nor shifts (error X1500), wherever in the expression they come from.
    const std::vector<Source> sources = ReadHeaders();
    const std::regex definition("^\\s*#\\s*define\\s+(NTC_\\w+)(.*)"),
        condition("^\\s*#\\s*(if|elif)\\b(.*)");
    const std::regex word("NTC_\\w+");
    std::multimap<std::string, std::string> macros;
    for (const Source& source : sources) {
        for (const std::string& line : source.lines) {
            std::smatch match;
            if (std::regex_search(line, match, definition))
                macros.emplace(match[1], match[2]);
        }
    }
    std::size_t count = 0;
    for (const Source& source : sources) {
        for (const std::string& line : source.lines) {
            std::smatch match;
            if (!std::regex_search(line, match, condition))
                continue;
            ++count;
            std::string text = match[2];
            const std::string expression = text;
            for (std::sregex_iterator name(expression.begin(), expression.end(), word), end; name != end;
                 ++name) {
                const auto [first, last] = macros.equal_range(name->str());
                for (auto macro = first; macro != last; ++macro)
                    text += macro->second;
            }
            CAPTURE(source.name);
            CAPTURE(text);
            CHECK(text.find('~') == std::string::npos);
            CHECK(text.find(">>") == std::string::npos);
            CHECK(text.find("<<") == std::string::npos);
        }
    }
    CHECK(count > 100);
}

TEST_CASE("shader headers: nothing that a web bundler would paste in vain") {
    // three.js expands every line of the first kind, vite-plugin-glsl and the like every one of the second, whatever #if they
    // are under. C++'s own have a space behind the #.
    const std::regex system("^[ \\t]*#include +<"), own("^[ \\t]*#include +\"([^\"]+)\"");
    for (const Source& source : ReadHeaders()) {
        CAPTURE(source.name);
        if (source.name == "PortabilityCpp.h")
            continue;
        for (const std::string& line : source.lines) {
            CAPTURE(line);
            CHECK_FALSE(std::regex_search(line, system));
            std::smatch match;
            if (std::regex_search(line, match, own))
                CHECK(match[1].str() != "PortabilityCpp.h");
        }
    }
}

TEST_CASE("shader headers: no variable, parameter, member or function has a reserved name") {
    std::set<std::string> reserved;
    std::istringstream words(kReserved);
    for (std::string word; words >> word;)
        reserved.insert(word);
    // A type and the name behind it, and the names in array parameters.
    const std::regex declared(
        "\\b(uint|int|float|bool|int2|uvec4|float2|float4|void|Ntc[A-Za-z0-9]*|NTC_SUM|NTC_OPERAND)\\s+"
        "([A-Za-z_]\\w*)");
    const std::regex array("_(?:ARRAY|OUT|INOUT)\\(\\s*\\w+\\s*,\\s*(\\w+)\\s*[,)]");
    std::set<std::string> names;
    for (const Source& source : ReadHeaders()) {
        if (source.name == "InferenceCoopVec.h" || source.name == "PortabilityCpp.h")
            continue; // GLSL and C++ only
        for (const std::string& line : source.lines) {
            if (std::regex_search(
                    line, std::regex("^\\s*#\\s*(error|if|elif|include|pragma|define\\s+\\w+\\s+\\w+\\s*$)")))
                continue;
            for (std::sregex_iterator match(line.begin(), line.end(), declared), end; match != end; ++match) {
                CAPTURE(source.name);
                CAPTURE(line);
                CHECK(reserved.count((*match)[2]) == 0);
                names.insert((*match)[2]);
            }
            for (std::sregex_iterator match(line.begin(), line.end(), array), end; match != end; ++match) {
                CAPTURE(source.name);
                CHECK(reserved.count((*match)[1]) == 0);
                names.insert((*match)[1]);
            }
        }
    }
    CHECK(names.size() > 150);
    CHECK(names.count("packedBytes") == 1);
    CHECK(names.count("outputs") == 1);
}

TEST_CASE("shader headers: small files, short parameter lists") {
    for (const Source& source : ReadHeaders()) {
        CAPTURE(source.name);
        std::ifstream file(std::string(NTC_SHADER_DIR "/openntc/") + source.name, std::ios::binary);
        const auto lines =
            std::count(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>(), '\n');
        CHECK(lines < 400);
        std::string text;
        for (const std::string& line : source.lines) {
            if (line.find('#') == std::string::npos)
                text += line + " ";
        }
        const std::regex function("(?:NTC_FUNCTION|inline)\\s+\\w+\\s+(\\w+)\\s*\\(");
        for (std::sregex_iterator match(text.begin(), text.end(), function), end; match != end; ++match) {
            std::size_t at = static_cast<std::size_t>(match->position() + match->length());
            int depth = 1, parameters = 1;
            for (; depth > 0 && at < text.size(); ++at) {
                depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
                parameters += depth == 1 && text[at] == ',' ? 1 : 0;
            }
            CAPTURE((*match)[1].str());
            CHECK(parameters <= 12);
        }
    }
}
