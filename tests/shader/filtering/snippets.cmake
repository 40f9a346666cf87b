# SPDX-License-Identifier: MIT
# The blocks of a language in docs/filtering.md, one after the other, are a shader that compiles.
#   cmake -DPAGE=docs/filtering.md -DLANGUAGE=glsl|hlsl -DSHADERS=<shaders> -DWORK=<folder> -DVALIDATOR=<glslangValidator> -P …
file(READ "${PAGE}" page)
string(REPLACE ";" "\\;" page "${page}")
set(code "")
set(blocks 0)
string(FIND "${page}" "```${LANGUAGE}\n" at)
while(NOT at EQUAL -1)
  string(LENGTH "```${LANGUAGE}\n" skip)
  math(EXPR at "${at} + ${skip}")
  string(SUBSTRING "${page}" ${at} -1 page)
  string(FIND "${page}" "\n```\n" end)
  string(SUBSTRING "${page}" 0 ${end} block)
  string(APPEND code "${block}\n")
  math(EXPR blocks "${blocks} + 1")
  string(FIND "${page}" "```${LANGUAGE}\n" at)
endwhile()
if(LANGUAGE STREQUAL "glsl")
  set(expected 3)
  set(prelude "#version 460\n#extension GL_GOOGLE_include_directive : require\n")
  set(main "layout(location = 0) in vec2 uv\;
layout(location = 0) out vec4 color\;
void main() {
    NtcStfExtent extent = NtcStfMakeExtent(64, 64, 7)\;
    NtcStfTexel exact = LookUpSetExactly(extent, uv, dFdx(uv), dFdy(uv))\;
    NtcStfTexel together = LookUpSet(extent, uv, dFdx(uv), dFdy(uv), ivec2(gl_FragCoord.xy), 0u)\;
    color = LookUp(uv, dFdx(uv), dFdy(uv), ivec2(gl_FragCoord.xy)) + exact.channels0 + together.channels4\;
}
")
  set(arguments -S frag)
else()
  set(expected 1)
  set(prelude "")
  set(main "float4 main(float4 at : SV_Position, float2 uv : TEXCOORD0) : SV_Target {
    return LookUpAlbedo(NtcStfMakeSampler(1u, 0u), int3(64, 64, 7), uv, ddx(uv), ddy(uv), int2(at.xy), 0u)\;
}
")
  set(arguments -D -S frag -e main -DNTC_HLSL=1)
endif()
if(NOT blocks EQUAL expected)
  message(FATAL_ERROR "${PAGE} has ${blocks} blocks of ${LANGUAGE}, not ${expected}")
endif()
string(REPLACE "\\;" ";" code "${prelude}${code}${main}")
file(WRITE "${WORK}/page.${LANGUAGE}" "${code}")
execute_process(COMMAND "${VALIDATOR}" ${arguments} -V --quiet --target-env vulkan1.1 "-I${SHADERS}" -DNETWORK_VERSION=1
  -DNTC_MATH=1 -o "${WORK}/page.${LANGUAGE}.spv" "${WORK}/page.${LANGUAGE}" RESULT_VARIABLE result
  OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PAGE}: blocks of ${LANGUAGE} do not compile:\n${output}")
endif()
message(STATUS "${PAGE}: ${blocks} blocks of ${LANGUAGE} compile")
