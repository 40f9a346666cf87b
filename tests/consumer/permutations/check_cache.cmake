# SPDX-License-Identifier: MIT
# cmake -DROOT=… -DGLSLANG=… -DVALIDATOR=… -DDIRECTORY=… -P: what OPENNTC_SHADER_CACHE keeps is found from another folder, and only
# where source, included files and options are the same. A word put in the place of what is kept shows where a result is from.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE "${DIRECTORY}")
set(ENV{OPENNTC_SHADER_CACHE} "${DIRECTORY}/kept")

foreach(copy one two)
  file(WRITE "${DIRECTORY}/${copy}/own/a.comp"
    "#version 450\n#include \"value.h\"\n#include \"local.h\"\nlayout(local_size_x = 1) in;\n"
    "layout(set = 0, binding = 0) buffer Result { uint result; };\nvoid main() { result = VALUE + LOCAL + X; }\n")
  file(WRITE "${DIRECTORY}/${copy}/own/local.h" "#define LOCAL 2\n")
  file(WRITE "${DIRECTORY}/${copy}/shared/value.h" "#define VALUE 1\n")
endforeach()

# Compiles a.comp of a copy, with further options; `bytes` is the SPIR-V, `embedded` the text, `depends` the depfile.
function(compile copy)
  set(output "${DIRECTORY}/${copy}/a.spv")
  file(REMOVE "${output}" "${output}.inc" "${output}.d")
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_SOURCE=${DIRECTORY}/${copy}/own/a.comp" "-DOPENNTC_OUTPUT=${output}"
      "-DOPENNTC_EMBED=${output}.inc" -DOPENNTC_LABEL=a "-DOPENNTC_VALIDATOR=${VALIDATOR}" -DOPENNTC_ENVIRONMENT=vulkan1.1
      -P "${ROOT}/cmake/OpenNTCCompileShader.cmake" -- "${GLSLANG}" --quiet -V --target-env vulkan1.1
      "-I${DIRECTORY}/${copy}/shared" ${ARGN}
    COMMAND_ERROR_IS_FATAL ANY)
  file(READ "${output}" bytes HEX)
  file(READ "${output}.inc" embedded)
  file(READ "${output}.d" depends)
  set(bytes "${bytes}" PARENT_SCOPE)
  set(embedded "${embedded}" PARENT_SCOPE)
  set(depends "${depends}" PARENT_SCOPE)
endfunction()

function(expect condition text)
  cmake_language(EVAL CODE "set(holds FALSE)\nif(${condition})\nset(holds TRUE)\nendif()")
  if(NOT holds)
    message(FATAL_ERROR "${text}")
  endif()
endfunction()

compile(one -DX=3)
set(compiled "${bytes}")
file(GLOB kept "${DIRECTORY}/kept/*.spv")
list(LENGTH kept number)
expect("${number} EQUAL 1" "one compilation kept ${number} results")
file(WRITE "${kept}" "marked")
string(REPLACE ".spv" ".inc" text "${kept}")
file(WRITE "${text}" "0x1,")

compile(two -DX=3)
expect("bytes STREQUAL 6d61726b6564 AND embedded STREQUAL \"0x1,\"" "not found from another folder")
foreach(name own/a.comp own/local.h shared/value.h)
  expect("depends MATCHES \"two/${name}\"" "the depfile does not name two/${name}: ${depends}")
endforeach()
expect("NOT depends MATCHES \"/one/\"" "the depfile names files of another folder: ${depends}")

compile(two -DX=4)
expect("NOT bytes STREQUAL 6d61726b6564 AND NOT bytes STREQUAL compiled" "another definition, the same result")
foreach(name own/local.h shared/value.h)
  file(READ "${DIRECTORY}/two/${name}" before)
  file(APPEND "${DIRECTORY}/two/${name}" "// changed\n")
  compile(two -DX=3)
  expect("bytes STREQUAL compiled" "${name} changed, and what was kept is still used")
  file(WRITE "${DIRECTORY}/two/${name}" "${before}")
endforeach()
compile(two -DX=3 -gVS)
expect("NOT bytes STREQUAL 6d61726b6564" "with debug information: a result of another folder")
compile(two -DX=3)
expect("bytes STREQUAL 6d61726b6564" "files as they were, and what was kept is not found")

# The source's own folder counts before the others.
file(WRITE "${DIRECTORY}/two/own/value.h" "#define VALUE 7\n")
file(APPEND "${DIRECTORY}/two/own/a.comp" "// changed\n")
compile(two -DX=3)
expect("depends MATCHES \"two/own/value.h\" AND NOT depends MATCHES \"two/shared/value.h\"" "value.h of the wrong folder: ${depends}")
