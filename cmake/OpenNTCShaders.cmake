# SPDX-License-Identifier: MIT
# openntc_add_shaders(): compiles every permutation of compute shaders to SPIR-V, checks it and hands it to a target.
#
#   openntc_add_shaders(TARGET app
#     SOURCES my.comp more.comp              # GLSL; the stage comes from the ending
#     [NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE]  # -DNETWORK_VERSION=1 … 4
#     [MATH INT8 INT8_HALF FP8 FP16 FP32]    # -DNTC_MATH=1 … 5
#     [DEFINES A={0,1} B C={,1}]             # every combination of the lists; B alone is -DB=1; an empty
#                                            # element leaves the macro undefined
#     [INCLUDE_DIRECTORIES dir ...]          # besides OpenNTC's own shaders
#     [OUTPUT HEADER|FILES]                  # default HEADER
#     [HEADER_NAME app_shaders.h]            # default <TARGET>_shaders.h; its stem names the namespace and the folder
#     [TARGET_ENV vulkan1.1]                 # as glslangValidator and spirv-val take it
#     [OPTIONS ...])                         # further options for glslangValidator
#
# HEADER: `#include "<HEADER_NAME>"` declares, in a namespace named like the file,
#   std::span<const Shader> GetShaders();
#   openntc::Expected<std::span<const std::uint32_t>> FindShader(std::string_view source, std::string_view defines);
# where `defines` is, for example, "NETWORK_VERSION=2 NTC_MATH=1", in any order; a missing permutation is an error that
# names it. The values of NETWORK_VERSION and NTC_MATH are those of InferenceConstants.h and MathModes.h.
# FILES: <binary dir>/<stem>/<permutation>.spv and index.txt there (file, source and defines, separated by tabs); the
# folder is the target's property OPENNTC_SHADER_DIRECTORY.
#
# Permutations are separate build steps: they run in parallel, and again only when a file that they include changes.
include_guard(GLOBAL)

set(_OPENNTC_SHADERS_MODULE_DIR "${CMAKE_CURRENT_LIST_DIR}")
option(OPENNTC_VALIDATE_SHADERS "Check compiled shaders with spirv-val" ON)

# The numbers behind the names, as in InferenceConstants.h and MathModes.h, so that FindShader() can be asked with a number.
set(_OPENNTC_NETWORK_VERSION_SMALL 1)
set(_OPENNTC_NETWORK_VERSION_MEDIUM 2)
set(_OPENNTC_NETWORK_VERSION_LARGE 3)
set(_OPENNTC_NETWORK_VERSION_XLARGE 4)
set(_OPENNTC_MATH_INT8 1)
set(_OPENNTC_MATH_INT8_HALF 2)
set(_OPENNTC_MATH_FP8 3)
set(_OPENNTC_MATH_FP16 4)
set(_OPENNTC_MATH_FP32 5)

# Combines every combination in `out` with every element of `axis` (joined by spaces; "-" adds nothing).
function(_openntc_combine out axis)
  set(result "")
  foreach(prefix IN LISTS ${out})
    foreach(element IN LISTS axis)
      if(element STREQUAL "-")
        list(APPEND result "${prefix}")
      elseif(prefix STREQUAL "-")
        list(APPEND result "${element}")
      else()
        list(APPEND result "${prefix} ${element}")
      endif()
    endforeach()
  endforeach()
  set(${out} "${result}" PARENT_SCOPE)
endfunction()

# Lists the permutations, each as "NAME=VALUE NAME=VALUE"; "-" is the one without any define.
function(_openntc_list_permutations out versions maths defines)
  set(permutations "-")
  foreach(pair "versions|NETWORK_VERSION|NETWORK_VERSION" "maths|MATH|NTC_MATH")
    string(REPLACE "|" ";" pair "${pair}")
    list(GET pair 0 variable)
    list(GET pair 1 kind)
    list(GET pair 2 macro)
    set(axis "")
    foreach(name IN LISTS ${variable})
      if(NOT DEFINED _OPENNTC_${kind}_${name})
        message(FATAL_ERROR "openntc_add_shaders: ${kind}: \"${name}\" is not a known name")
      endif()
      list(APPEND axis "${macro}=${_OPENNTC_${kind}_${name}}")
    endforeach()
    if(axis)
      _openntc_combine(permutations "${axis}")
    endif()
  endforeach()
  foreach(define IN LISTS defines)
    if(define MATCHES "^([A-Za-z_][A-Za-z0-9_]*)={([^{}]*)}$")
      set(name "${CMAKE_MATCH_1}")
      string(REPLACE "," ";" values "${CMAKE_MATCH_2}")
    elseif(define MATCHES "^([A-Za-z_][A-Za-z0-9_]*)=([^{}]*)$")
      set(name "${CMAKE_MATCH_1}")
      set(values "${CMAKE_MATCH_2}")
    elseif(define MATCHES "^([A-Za-z_][A-Za-z0-9_]*)$")
      set(name "${define}")
      set(values 1)
    else()
      message(FATAL_ERROR "openntc_add_shaders: DEFINES: \"${define}\": NAME, NAME=VALUE or NAME={V1,V2}")
    endif()
    set(axis "")
    foreach(value IN LISTS values)
      if(value STREQUAL "")
        list(APPEND axis "-")
      else()
        list(APPEND axis "${name}=${value}")
      endif()
    endforeach()
    _openntc_combine(permutations "${axis}")
  endforeach()
  set(${out} "${permutations}" PARENT_SCOPE)
endfunction()

function(openntc_add_shaders)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "TARGET;OUTPUT;HEADER_NAME;TARGET_ENV"
    "SOURCES;NETWORK_VERSIONS;MATH;DEFINES;INCLUDE_DIRECTORIES;OPTIONS")
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "openntc_add_shaders: unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT TARGET "${ARG_TARGET}")
    message(FATAL_ERROR "openntc_add_shaders: TARGET: \"${ARG_TARGET}\" is not a target")
  endif()
  if(NOT ARG_SOURCES)
    message(FATAL_ERROR "openntc_add_shaders: SOURCES: none given")
  endif()
  if(NOT ARG_OUTPUT)
    set(ARG_OUTPUT HEADER)
  elseif(NOT ARG_OUTPUT MATCHES "^(HEADER|FILES)$")
    message(FATAL_ERROR "openntc_add_shaders: OUTPUT: \"${ARG_OUTPUT}\": HEADER or FILES")
  endif()
  if(NOT ARG_TARGET_ENV)
    set(ARG_TARGET_ENV vulkan1.1)
  endif()
  if(NOT ARG_HEADER_NAME)
    set(ARG_HEADER_NAME "${ARG_TARGET}_shaders.h")
  endif()
  cmake_path(GET ARG_HEADER_NAME STEM stem)
  string(MAKE_C_IDENTIFIER "${stem}" namespace)
  set(directory "${CMAKE_CURRENT_BINARY_DIR}/${stem}")
  set(group "${ARG_TARGET}_${stem}_spirv")
  if(TARGET "${group}")
    message(FATAL_ERROR "openntc_add_shaders: HEADER_NAME: \"${ARG_HEADER_NAME}\" is taken by an earlier call")
  endif()

  find_program(OPENNTC_GLSLANG_VALIDATOR glslangValidator REQUIRED)
  set(validation "")
  if(OPENNTC_VALIDATE_SHADERS)
    find_program(OPENNTC_SPIRV_VAL spirv-val REQUIRED)
  endif()

  set(includes "$<TARGET_PROPERTY:openntc::shaders,INTERFACE_INCLUDE_DIRECTORIES>")
  set(own_includes "${ARG_INCLUDE_DIRECTORIES}")
  list(TRANSFORM own_includes PREPEND "-I")
  _openntc_list_permutations(permutations "${ARG_NETWORK_VERSIONS}" "${ARG_MATH}" "${ARG_DEFINES}")

  set(outputs "")
  set(index_text "")
  set(declarations "")
  set(table "")
  set(number 0)
  foreach(source IN LISTS ARG_SOURCES)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE OUTPUT_VARIABLE path)
    cmake_path(GET path FILENAME source_name)
    foreach(permutation IN LISTS permutations)
      if(permutation STREQUAL "-")
        set(permutation "")
      endif()
      string(REPLACE " " ";" defines "${permutation}")
      list(TRANSFORM defines PREPEND "-D")
      string(REGEX REPLACE "[^A-Za-z0-9_.=-]" "+" file_name "${source_name} ${permutation}")
      string(REGEX REPLACE "[+]$" "" file_name "${file_name}")
      set(spirv "${directory}/${file_name}.spv")
      if(spirv IN_LIST outputs)
        message(FATAL_ERROR "openntc_add_shaders: SOURCES: two files are named ${source_name}")
      endif()
      set(step_outputs "${spirv}")
      set(commands COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" --quiet -V --target-env "${ARG_TARGET_ENV}"
        "-I$<JOIN:${includes},$<SEMICOLON>-I>" ${own_includes} ${defines} ${ARG_OPTIONS}
        --depfile "${spirv}.d" -o "${spirv}" "${path}")
      if(OPENNTC_VALIDATE_SHADERS)
        list(APPEND commands COMMAND "${OPENNTC_SPIRV_VAL}" --target-env "${ARG_TARGET_ENV}" "${spirv}")
      endif()
      if(ARG_OUTPUT STREQUAL "HEADER")
        list(APPEND step_outputs "${spirv}.inc")
        list(APPEND commands COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_EMBED_INPUT=${spirv}"
          "-DOPENNTC_EMBED_OUTPUT=${spirv}.inc" -P "${_OPENNTC_SHADERS_MODULE_DIR}/OpenNTCEmbedShader.cmake")
        string(APPEND declarations
          "constexpr std::uint32_t kWords${number}[] = {\n#include \"${spirv}.inc\"\n};\n")
        string(APPEND table "    {\"${source_name}\", \"${permutation}\", kWords${number}},\n")
      endif()
      string(APPEND index_text "${file_name}.spv\t${source_name}\t${permutation}\n")
      add_custom_command(OUTPUT ${step_outputs} ${commands}
        DEPENDS "${path}" DEPFILE "${spirv}.d" COMMENT "SPIR-V ${source_name} ${permutation}"
        COMMAND_EXPAND_LISTS VERBATIM)
      list(APPEND outputs ${step_outputs})
      math(EXPR number "${number} + 1")
    endforeach()
  endforeach()

  file(MAKE_DIRECTORY "${directory}")
  add_custom_target("${group}" DEPENDS ${outputs})
  add_dependencies("${ARG_TARGET}" "${group}")
  if(ARG_OUTPUT STREQUAL "FILES")
    file(CONFIGURE OUTPUT "${directory}/index.txt" CONTENT "${index_text}" @ONLY)
    set_property(TARGET "${ARG_TARGET}" APPEND PROPERTY OPENNTC_SHADER_DIRECTORY "${directory}")
    return()
  endif()

  set(OPENNTC_SHADER_HEADER "${ARG_HEADER_NAME}")
  set(OPENNTC_SHADER_NAMESPACE "${namespace}")
  set(OPENNTC_SHADER_COUNT "${number}")
  set(OPENNTC_SHADER_WORDS "${declarations}")
  set(OPENNTC_SHADER_TABLE "${table}")
  configure_file("${_OPENNTC_SHADERS_MODULE_DIR}/OpenNTCShaderIndex.h.in" "${directory}/${ARG_HEADER_NAME}" @ONLY)
  configure_file("${_OPENNTC_SHADERS_MODULE_DIR}/OpenNTCShaderIndex.cpp.in" "${directory}/${stem}.cpp" @ONLY)
  target_sources("${ARG_TARGET}" PRIVATE "${directory}/${stem}.cpp")
  target_include_directories("${ARG_TARGET}" PRIVATE "${directory}")
  target_link_libraries("${ARG_TARGET}" PRIVATE openntc::openntc)
endfunction()
