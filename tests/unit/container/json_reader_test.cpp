// SPDX-License-Identifier: MIT
// What the JSON reader accepts and refuses, and that its messages name the place.
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

namespace {

constexpr std::string_view kStart = R"({"schemaVersion":1,"width":1,"height":2,"numChannels":3)";

/// The minimal document with more members.
std::string With(std::string_view members) {
    return Join({kStart, ",", members, "}"});
}

std::string ErrorWith(std::string_view members) {
    return JsonError(With(members));
}

Document Parse(std::string_view json) {
    Expected<Container> container = ReadJson(json);
    INFO(std::string(json));
    REQUIRE_MESSAGE(container, std::string(container.error().GetText()));
    return std::move(container->document);
}

Document ParseWith(std::string_view members) {
    return Parse(With(members));
}

} // namespace

TEST_CASE("json: the minimal document, and the defaults of what is absent") {
    const Document document = Parse(kMinimalJson);
    CHECK(document.schemaVersion == 1);
    CHECK(document.width == 1);
    CHECK(document.height == 2);
    CHECK(document.numChannels == 3);
    CHECK(document.numColorMips == 1);
    CHECK_FALSE(document.latentShape);
    CHECK_FALSE(document.mlp);
    CHECK(document.textures.empty());
    const Document texture = ParseWith(R"("textures":[{"name":"","firstChannel":0,"numChannels":1}])");
    REQUIRE(texture.textures.size() == 1);
    CHECK_FALSE(texture.textures[0].channelFormat);
    CHECK(texture.textures[0].rgbColorSpace == ColorSpace::Linear);
    CHECK(texture.textures[0].bcFormat == BlockCompressedFormat::None);
    CHECK(texture.textures[0].bcQuality == 255);
}

TEST_CASE("json: each missing required field is named") {
    CHECK(JsonError("{}") == "schemaVersion: absent: is required");
    // Whatever else is absent, which depends on it.
    CHECK(JsonError(
              R"({"width":1,"height":2,"numChannels":3,"latentShape":{"numFeatures":4},"latents":[{}]})") ==
          "schemaVersion: absent: is required");
    CHECK(JsonError(R"({"schemaVersion":1})") == "width: absent: is required");
    CHECK(JsonError(R"({"schemaVersion":1,"width":1,"height":2})") == "numChannels: absent: is required");
    CHECK(ErrorWith(R"("latentShape":{"highResFeatures":4,"lowResFeatures":4,"lowResQuantBits":2})") ==
          "latentShape.highResQuantBits: absent: is required");
    CHECK(ErrorWith(R"("textures":[{"name":"a","firstChannel":0,"numChannels":1},{"firstChannel":0}])") ==
          "textures[1].name: absent: is required");
    CHECK(ErrorWith(R"("mlpVersions":[{},{"layers":[{"inputChannels":1}]}])") ==
          "mlpVersions[1].layers[0].outputChannels: absent: is required");
    CHECK(ErrorWith(R"("views":[{"offset":0}])") == "views[0].storedSize: absent: is required");
}

TEST_CASE("json: unknown keys of any nesting are skipped and never satisfy a required field") {
    const Document document = Parse(
        R"({"a":[[1,[{"width":[7]}]],{}],"schemaVersion":1,"b":null,"width":5,"c":{"height":{}},"height":2,)"
        R"("d":"x","numChannels":3,"e":[],"f":1e-400000,"views":[{"x":[[]],"offset":0,"storedSize":4}]})");
    CHECK(document.width == 5);
    CHECK(document.views.size() == 1);
    CHECK(JsonError(R"({"x":[1],"width":1,"height":2,"numChannels":3})") ==
          "schemaVersion: absent: is required");
    CHECK(ErrorWith(R"("latentShape":{"highResFeatures":1,"x":[],"lowResFeatures":4,"lowResQuantBits":2})") ==
          "latentShape.highResQuantBits: absent: is required");
    CHECK(ErrorWith(R"("colorMips":[{"combinedColorData":{"view":0},"perTextureColorData":[{"view":1}]}])") ==
          "");
}

TEST_CASE("json: integers are JSON integers in range") {
    CHECK(Parse(R"({"schemaVersion":1,"width":4294967295,"height":0,"numChannels":-0})").width ==
          4294967295u);
    for (const char* bad : {"64.0", "6.4e1", "-1", "4294967296", "99999999999999999999999", "1e0"})
        CHECK(JsonError(Replace(std::string(kMinimalJson), "\"width\":1", std::string("\"width\":") + bad)) ==
              std::string("width: ") + bad + ": must be an integer from 0 to 4294967295");
    for (const char* bad : {"true", "null", "false"})
        CHECK(JsonError(Replace(std::string(kMinimalJson), "\"width\":1", std::string("\"width\":") + bad)) ==
              std::string("width: ") + bad + ": must be an integer");
    CHECK(ErrorWith(R"("numColorMips":"4")") == "numColorMips: 4: must be an integer");
    CHECK(ErrorWith(R"("numColorMips":{})") == "numColorMips: an object: must be an integer");
    CHECK(ErrorWith(R"("numColorMips":[1])") == "numColorMips: an array: must be an integer");
    for (const char* bad : {"01", "+1", ".5", "1.", "1e", "0x1", "NaN", "Infinity", "--1"})
        CHECK(ErrorWith(std::string("\"numColorMips\":") + bad).find("JSON: byte ") == 0);
}

TEST_CASE("json: 64-bit fields are strict") {
    const Document document = ParseWith(
        R"("views":[{"offset":0,"storedSize":64,"uncompressedSize":18446744073709551615,"compression":"none"}])");
    CHECK(document.views[0].uncompressedSize == std::numeric_limits<std::uint64_t>::max());
    CHECK(document.views[0].compression == Compression::None);
    for (const char* bad : {"-4", "18446744073709551616", "4.0"})
        CHECK(ErrorWith(std::string(R"("views":[{"storedSize":0,"offset":)") + bad + "}]") ==
              std::string("views[0].offset: ") + bad + ": must be an integer from 0 to 18446744073709551615");
}

TEST_CASE("json: reals round from decimal to binary64 to binary32, and never to infinity") {
    const auto parse = [](const std::string& text) {
        const Document document = ParseWith(Join({"\"colorMips\":[{\"positionLod\":", text, "}]"}));
        return *document.colorMips[0].positionLod;
    };
    CHECK(parse("0.3333333432674408") == 1.0f / 3.0f);
    CHECK(parse("-2") == -2.0f);
    CHECK(parse("1E+2") == 100.0f);
    CHECK(std::signbit(parse("-0.0")));
    CHECK(parse("3.4028234663852886e38") == std::numeric_limits<float>::max());
    CHECK(parse("3.4028235677973364e38") ==
          std::numeric_limits<float>::max()); // just below the halfway point
    // 1 + 2^-24 + 2^-60: binary64 drops the last term, and the tie goes to the even 1; a direct conversion
    // would not.
    CHECK(parse("1.00000005960464477626252188533712478908660127605") == 1.0f);
    CHECK(parse("1e-45") == std::numeric_limits<float>::denorm_min());
    CHECK(parse("1e-400") == 0.0f);
    CHECK(parse("-1e-99999999999") == 0.0f);
    CHECK(parse("0." + std::string(400, '0') + "1") == 0.0f);
    for (const char* bad : {"3.4028235677973366e38", "-1e39", "1e308"})
        CHECK(ErrorWith(std::string("\"colorMips\":[{\"positionScale\":") + bad + "}]") ==
              std::string("colorMips[0].positionScale: ") + bad +
                  ": must be a number that a 32-bit float can hold");
    CHECK(ErrorWith("\"colorMips\":[{\"positionLod\":1e309}]") != "");
    CHECK(ErrorWith("\"colorMips\":[{\"positionLod\":\"1\"}]") ==
          "colorMips[0].positionLod: 1: must be a number");
}

TEST_CASE("json: enumerations are strings, compared without case") {
    const Document document = ParseWith(
        R"("textures":{"name":"n","firstChannel":0,"numChannels":1,"channelFormat":"unorm16","rgbColorSpace":"SRGB",)"
        R"("alphaColorSpace":"hlg","bcFormat":"bc7","bcQuality":300},"mlp":{"weightLayout":"ROWMAJOR",)"
        R"("activation":"hgeluclamp","weightType":"floate4m3","scaleBiasType":"FLOAT16"})");
    REQUIRE(document.textures.size() == 1);
    CHECK(document.textures[0].channelFormat == ChannelFormat::UNORM16);
    CHECK(document.textures[0].rgbColorSpace == ColorSpace::sRGB);
    CHECK(document.textures[0].alphaColorSpace == ColorSpace::HLG);
    CHECK(document.textures[0].bcFormat == BlockCompressedFormat::BC7);
    CHECK(document.textures[0].bcQuality == 300);
    REQUIRE(document.mlp);
    CHECK(document.mlp->weightLayout == MatrixLayout::RowMajor);
    CHECK(document.mlp->activation == MlpActivation::HGELUClamp);
    CHECK(document.mlp->weightType == MlpDataType::FloatE4M3);
    CHECK(document.mlp->scaleBiasType == MlpDataType::Float16);
    CHECK(ErrorWith(R"("mlp":{"weightType":"Int16"})") ==
          "mlp.weightType: Int16: is not one of the known names");
    CHECK(ErrorWith(R"("mlp":{"weightType":0})") == "mlp.weightType: 0: must be a string");
    CHECK(ErrorWith(R"("channels":[{},{"colorSpace":null}])") ==
          "channels[1].colorSpace: null: must be a string");
    CHECK(ErrorWith(R"("channels":[{"colorSpace":"sRGB "}])") != "");
}

TEST_CASE("json: the last of repeated scalars counts; repeated arrays and objects are refused") {
    CHECK(ParseWith(R"("width":7,"width":8)").width == 8);
    const Document named =
        ParseWith(R"("textures":[{"name":"first","firstChannel":0,"numChannels":1,"name":"last"}])");
    CHECK(named.textures[0].name.View() == "last");
    CHECK(ErrorWith(R"("channels":[],"channels":[])") ==
          "channels: again: an object or array may be given once");
    CHECK(ErrorWith(R"("channels":{},"channels":[])") ==
          "channels: again: an object or array may be given once");
    CHECK(ErrorWith(R"("channels":[],"channels":{})") ==
          "channels: again: an object or array may be given once");
    CHECK(ErrorWith(R"("mlp":{},"mlp":{})") == "mlp: again: an object or array may be given once");
    CHECK(ErrorWith(R"("mlp":{"layers":[],"layers":[]})") ==
          "mlp.layers: again: an object or array may be given once");
}

TEST_CASE("json: a bare object stands for an array of one; other things do not") {
    CHECK(ParseWith(R"("channels":{"colorSpace":"HLG"})").channels[0].colorSpace == ColorSpace::HLG);
    CHECK(
        ParseWith(
            R"("mlpVersions":{"layers":{"inputChannels":1,"outputChannels":2,"weightView":0,"biasView":0}},)"
            R"("views":{"offset":0,"storedSize":0})")
            .mlpVersions[0]
            .layers.size() == 1);
    CHECK(ErrorWith(R"("channels":[[{}]])") == "channels[0]: an array: must be an array of objects");
    CHECK(ErrorWith(R"("channels":[{},1])") == "channels[1]: 1: must be an array of objects");
    CHECK(ErrorWith(R"("channels":[null])") == "channels[0]: null: must be an array of objects");
    CHECK(ErrorWith(R"("channels":null)") == "channels: null: must be an array of objects");
    CHECK(ErrorWith(R"("mlp":[{}])") == "mlp: an array: must be an object");
    CHECK(ErrorWith(R"("mlp":null)") == "mlp: null: must be an object");
    for (const char* bad : {"[]", "1", "\"x\"", "null", "true", "[{}]"})
        CHECK(JsonError(bad).find("JSON: ") == 0);
}

TEST_CASE("json: another schema version is what a refusal names, whatever else differs") {
    const auto refuse = [](const std::string& version) {
        return "schemaVersion: " + version +
               ": must be 1 to 3 (LibNTC 0.5 - 0.9): of a later release, of whose files this version of "
               "OpenNTC "
               "knows nothing: take a later one, or encode the images again";
    };
    const std::string refusal = refuse("4");
    CHECK(JsonError(R"({"schemaVersion":4294967295})") == refuse("4294967295"));
    CHECK(JsonError(R"({"schemaVersion":4})") == refusal);
    CHECK(JsonError(R"({"schemaVersion":4,"width":"?","height":[]})") == refusal);
    CHECK(JsonError(R"({"latentShape":{"numFeatures":4},"views":7,"schemaVersion":4})") == refusal);
    CHECK(JsonError(R"({"width":{"schemaVersion":2},"schemaVersion" : 4 ,)") == refusal);
    CHECK(JsonError(R"({"mlp":[[{"schemaVersion":4}]]})") == "mlp: an array: must be an object");
    CHECK(JsonError(R"({"schemaVersion":0,"width":1,"height":2,"numChannels":3})") ==
          "schemaVersion: 0: must be 1 to 3");
    CHECK(JsonError(R"({"schemaVersion":4,"schemaVersion":1,"width":1,"height":2,"numChannels":3})") == "");
    CHECK(JsonError(R"({"schemaVersion":"4"})") == "schemaVersion: 4: must be an integer");
    CHECK(JsonError(R"({"schema\u0056ersion":3,"width":1,"height":2,"numChannels":3})") ==
          "schemaVersion: 3: its key: must be written without escapes");
}

TEST_CASE("json: the schema version counts wherever it stands") {
    constexpr std::string_view kRest = R"("width":8,"height":8,"numChannels":4,"mlp":5,)"
                                       R"("latentShape":{"numFeatures":12},"a":"\"schemaVersion\":1")";
    for (const std::string version : {"2", "3"}) {
        for (const std::string& text : {"{\"schemaVersion\":" + version + "," + std::string(kRest) + "}",
                                        "{" + std::string(kRest) + ",\"schemaVersion\":" + version + "}"}) {
            CAPTURE(text);
            const Expected<Container> container = ReadJson(text);
            REQUIRE_MESSAGE(container, std::string(container.error().GetText()));
            CHECK(container->document.latentShape->numFeatures == 12);
            CHECK_FALSE(container->document.mlp); // an unknown key there
        }
    }
    CHECK(JsonError("{\"schemaVersion\":1," + std::string(kRest) + "}") == "mlp: 5: must be an object");
}

namespace {

std::string OfGeneration(int generation, std::string_view member) {
    return "{\"schemaVersion\":" + std::to_string(generation) +
           R"(,"width":1,"height":2,"numChannels":3,"views":[{"offset":0,"storedSize":4}],)" +
           std::string(member) + "}";
}

} // namespace

TEST_CASE("json: fields of generations 2 and 3, required and not") {
    const auto error = [](int generation, std::string_view member) {
        return JsonError(OfGeneration(generation, member));
    };
    for (const int generation : {2, 3}) {
        CAPTURE(generation);
        CHECK(error(generation, R"("latentShape":{})") == "latentShape.numFeatures: absent: is required");
        CHECK(error(generation, R"("colorMips":[{"latentMip":0,"positionLod":0}])") ==
              "colorMips[0].positionScale: absent: is required");
        CHECK(error(generation, R"("colorMips":[{"positionLod":0,"positionScale":1}])") ==
              "colorMips[0].latentMip: absent: is required");
        CHECK(error(generation,
                    R"("mlpVersions":[{"layers":[{"inputChannels":1,"outputChannels":1,"weightView":0,)"
                    R"("biasView":0,"weightType":"Int8"}]}])") ==
              "mlpVersions[0].layers[0].biasType: absent: is required");
        CHECK(error(generation, R"("channels":[{"scale":"x","bias":null}])") == ""); // unknown there
    }
    CHECK(error(2, R"("latents":[{"width":1,"height":1,"view":0}])") ==
          "latents[0].arraySize: absent: is required");
    CHECK(error(2, R"("latents":[{"width":1,"height":1,"arraySize":1,"view":1}])") ==
          "latents[0].view: 1: must be below 1");
    CHECK(error(2, R"("views":[])") == "views: again: an object or array may be given once");
    CHECK(error(2, R"("textures":[{"name":"","firstChannel":0,"numChannels":1,"bcModeBuffers":7}])") == "");
    CHECK(error(3, R"("textures":[{"name":"","firstChannel":0,"numChannels":1,"bcModeBuffers":7}])") ==
          "textures[0].bcModeBuffers: 7: must be an array of objects");
    CHECK(error(3, R"("textures":[{"name":"","firstChannel":0,"numChannels":1,)"
                   R"("bcModeBuffers":[{"mipLevel":0,"view":0},{"mipLevel":0,"view":1}]}])") ==
          "textures[0].bcModeBuffers[1].view: 1: must be below 1");
}

TEST_CASE("json: lists of views") {
    const auto error = [](std::string_view list) {
        return JsonError(OfGeneration(
            3, "\"latents\":[{\"width\":1,\"height\":1,\"layerViews\":" + std::string(list) + "}]"));
    };
    CHECK(error("[]") == "");
    CHECK(error("[0,0,0,0]") == "");
    CHECK(error("[0,0,0,0,0]") == "latents[0].layerViews: too many elements: at most 4");
    CHECK(error("[0,1]") == "latents[0].layerViews[1]: 1: must be below 1");
    CHECK(error("[0,-1]") == "latents[0].layerViews[1]: -1: must be an integer from 0 to 4294967295");
    CHECK(error("[\"0\"]") == "latents[0].layerViews[0]: 0: must be an integer");
    CHECK(error("[null]") == "latents[0].layerViews[0]: null: must be an integer");
    CHECK(error("[{}]") == "latents[0].layerViews[0]: an object: must be an integer");
    CHECK(error("[[0]]") == "latents[0].layerViews[0]: an array: must be an integer");
    CHECK(error("0") == "latents[0].layerViews: 0: must be an array of integers");
    CHECK(error("{}") == "latents[0].layerViews: an object: must be an array of integers");
    CHECK(error("[0],\"layerViews\":[0]") ==
          "latents[0].layerViews: again: an object or array may be given once");
}

TEST_CASE("json: compression is generation 3's") {
    constexpr std::string_view kView =
        R"("width":1,"height":2,"numChannels":3,"views":[{"offset":0,"storedSize":4,"compression":"gdeflate",)"
        R"("uncompressedSize":8,"crc32":4294967295}]})";
    CHECK(JsonError("{\"schemaVersion\":2," + std::string(kView)) ==
          "views[0].compression: gdeflate: is not one of the known names");
    const Expected<Container> third = ReadJson("{\"schemaVersion\":3," + std::string(kView));
    REQUIRE(third);
    CHECK(third->document.views[0].compression == Compression::GDeflate);
    CHECK(third->document.views[0].uncompressedSize == 8u);
    CHECK(third->document.views[0].crc32 == 0xFFFFFFFFu);
    CHECK(FormatToString(third->document)
              .find(R"("compression":"GDeflate","uncompressedSize":8,"crc32":4294967295)") !=
          std::string::npos);
}

TEST_CASE("json: syntax") {
    CHECK(JsonError("") != "");
    CHECK(JsonError(Join({"\xEF\xBB\xBF", kMinimalJson})) != "");
    CHECK(JsonError(std::string(kMinimalJson) + " x").find("JSON: byte ") == 0);
    CHECK(JsonError(std::string(kMinimalJson) + "{}") != "");
    CHECK(JsonError(Join({"/* c */", kMinimalJson})) != "");
    CHECK(JsonError(std::string(kMinimalJson) + "// c") != "");
    CHECK(JsonError(With(R"("views":[],)")) != "");
    CHECK(JsonError(With(R"("channels":[{},])")) != "");
    CHECK(JsonError(With(R"("a":"\x")")) != "");
    CHECK(JsonError(With("\"a\":\"tab\there\"")) != "");
    CHECK(JsonError(Join({" \t\r\n", kMinimalJson, " \n"})) == "");
    CHECK(ReadBytes(WrapJson(std::string(kMinimalJson) + std::string("\0garbage", 8))));
    const std::string text(kMinimalJson);
    for (std::size_t length = 0; length < text.size(); ++length)
        CHECK(JsonError(text.substr(0, length)) != "");
}

TEST_CASE("json: nesting is limited to 64 levels, at any kind of place") {
    const auto nested = [](std::size_t levels) {
        return Join({"\"x\":", std::string(levels, '['), std::string(levels, ']')});
    };
    CHECK(ErrorWith(nested(63)) == "");
    CHECK(ErrorWith(nested(64)) == "JSON: nesting: at most 64 levels");
    CHECK(ErrorWith(nested(1000000)) == "JSON: nesting: at most 64 levels");
    std::string objects;
    for (int i = 0; i < 100000; ++i)
        objects += "{\"a\":";
    CHECK(JsonError(objects) == "JSON: nesting: at most 64 levels");
    CHECK(JsonError(Join({"{\"schemaVersion\":4,\"x\":", objects})).find("schemaVersion: 4: ") == 0);
}

TEST_CASE("json: names are UTF-8, escapes included") {
    const auto name = [](const std::string& literal) {
        return std::string(ParseWith(Join({"\"textures\":[{\"name\":\"", literal,
                                           "\",\"firstChannel\":0,\"numChannels\":1}]"}))
                               .textures[0]
                               .name.View());
    };
    CHECK(name("a\\u00e9\\u20ac\\ud83d\\ude00") == "a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80");
    CHECK(name("\xC3\xA9\xF4\x8F\xBF\xBF") == "\xC3\xA9\xF4\x8F\xBF\xBF");
    CHECK(name("\\\"\\\\\\/\\b\\f\\n\\r\\t") == "\"\\/\b\f\n\r\t");
    for (const char* bad : {"\\ud800", "\\ud800x", "\\udc00", "\\u12g4", "\\ud800\\u0041"})
        CHECK(ErrorWith(Join({R"("textures":{"firstChannel":0,"numChannels":1,"name":")", bad, "\"}"})) !=
              "");
    for (const char* bad : {"\x80", "\xC0\xAF", "\xC3", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                            "\xF5\x80\x80\x80", "\xE2\x82", "\xF0\x8F\xBF\xBF", "\xFF"})
        CHECK(ErrorWith(std::string("\"a\":\"") + bad + "\"") == "JSON: text: must be UTF-8");
}

TEST_CASE("json: arrays are limited") {
    const auto repeated = [](std::string_view key, std::string_view element, std::size_t count) {
        std::string text = Join({"\"", key, "\":["});
        for (std::size_t i = 0; i < count; ++i)
            text.append(i > 0 ? "," : "").append(element);
        return text + "]";
    };
    struct Case {
        std::string_view key;
        std::string_view element;
        std::size_t limit;
    };
    for (const Case& c :
         {Case{"channels", "{}", 16}, Case{"colorMips", "{}", 16}, Case{"mlpVersions", "{}", 16},
          Case{"textures", R"({"name":"","firstChannel":0,"numChannels":0})", 64},
          Case{"views", R"({"offset":0,"storedSize":0})", 65536}}) {
        CHECK(ErrorWith(repeated(c.key, c.element, c.limit)) == "");
        CHECK(ErrorWith(repeated(c.key, c.element, c.limit + 1)) ==
              std::string(c.key) + ": too many elements: at most " + std::to_string(c.limit));
    }
    CHECK(ErrorWith(repeated("latents", "{}", 9)) == "latents[0].highResWidth: absent: is required");
}

TEST_CASE("reader: views are multiples of 4 inside the chunk, without overflow; view indices are in range") {
    const auto view = [](const char* offset, const char* size) {
        return std::string("\"views\":[{\"offset\":0,\"storedSize\":64},{\"offset\":") + offset +
               ",\"storedSize\":" + size + "}]";
    };
    CHECK(ErrorWith(view("64", "0")) == "");
    CHECK(ErrorWith(view("60", "4")) == "");
    CHECK(ErrorWith(view("60", "5")) ==
          "views[1].storedSize: 5 bytes at offset 60: the binary chunk has 64 bytes");
    CHECK(ErrorWith(view("3", "1")) == "views[1].offset: 3: must be a multiple of 4");
    CHECK(ErrorWith(view("68", "0")) != "");
    CHECK(ErrorWith(view("18446744073709551612", "8")) != "");
    CHECK(ErrorWith(view("4", "18446744073709551615")) != "");

    const std::string latent =
        R"({"highResWidth":1,"highResHeight":1,"lowResWidth":1,"lowResHeight":1,)"
        R"("highResBitsPerPixel":1,"lowResBitsPerPixel":1,"highResView":0,"lowResView":0})";
    const std::string bad = Replace(latent, "\"highResView\":0", "\"highResView\":99");
    const std::string views = ",\"views\":[{\"offset\":0,\"storedSize\":0}]";
    CHECK(ErrorWith(Join({"\"latents\":[", latent, "]", views})) == "");
    CHECK(ErrorWith(Join({"\"latents\":[", latent, ",", bad, "]", views})) ==
          "latents[1].highResView: 99: must be below 1");
    CHECK(
        ErrorWith(R"("textures":{"name":"","firstChannel":0,"numChannels":0,"bcAccelerationDataView":0})") ==
        "textures[0].bcAccelerationDataView: 0: must be below 0");
    CHECK(
        ErrorWith(R"("mlp":{"layers":[{"inputChannels":1,"outputChannels":2,"weightView":0,"biasView":1}]})" +
                  views) == "mlp.layers[0].biasView: 1: must be below 1");
}

TEST_CASE("messages: long and hostile text is cut and stays on one line") {
    const std::string message =
        ErrorWith(R"("mlp":{"weightType":"a\u001b[2J\nb)" + std::string(5000, 'x') + "\"}");
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.find('\x1b') == std::string::npos);
    CHECK(message.find("mlp.weightType: a?[2J?bxxxx") == 0);
    CHECK(message.size() < Error::kMaxMessageBytes);
}
