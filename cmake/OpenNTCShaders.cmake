# SPDX-License-Identifier: MIT
# openntc_add_shaders(): compiles every permutation of shaders to SPIR-V, checks it and hands it to a target.
#
#   openntc_add_shaders(TARGET app
#     SOURCES my.comp more.comp.hlsl         # GLSL or HLSL; the stage comes from the ending
#     [LIST shaders.txt]                     # and/or a file of lines "path -T cs|ps|vs [-E entry] [-D X={0,1}]…"
#     [NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE GEN2 GEN3] # -DNETWORK_VERSION=1 … 6; these and MATH's in any case
#     [MATH INT8 INT8_HALF FP8 FP16 FP32 COOPVEC_INT8 COOPVEC_FP8 COOPMAT_INT8
#      COOPMAT_INT8_HALF]                  # -DNTC_MATH=1 … 9
#     [DEFINES A={0,1} B C={,1}]             # every combination of the lists; B alone is -DB=1; an empty
#                                            # element leaves the macro undefined
#     [STAGE comp|frag|vert]                 # of SOURCES whose ending does not say it (x.hlsl)
#     [INCLUDE_DIRECTORIES dir ...]          # besides OpenNTC's own shaders
#     [OUTPUT HEADER|FILES|BLOB|FLAT]        # default HEADER
#     [HEADER_NAME app_shaders.h]            # default <TARGET>_shaders.h; its stem names the namespace and the folder
#     [TARGET_ENV vulkan1.1]                 # as glslangValidator and spirv-val take it
#     [OPTIONS ...])                         # further options for glslangValidator
#
# HEADER: `#include "<HEADER_NAME>"` declares, in a namespace named like the file,
#   std::span<const Shader> GetShaders();
#   openntc::Expected<std::span<const std::uint32_t>> FindShader(std::string_view source, std::string_view defines);
# where `defines` is, for example, "NETWORK_VERSION=2 NTC_MATH=1", in any order; a missing permutation is an error that
# names it and the nearest. The values of NETWORK_VERSION and NTC_MATH are those of InferenceConstants.h and MathModes.h.
# FILES: <binary dir>/<stem>/<permutation>.spv and index.txt there (file, source and defines, separated by tabs); the
# folder is the target's property OPENNTC_SHADER_DIRECTORY.
# BLOB: <binary dir>/<stem>/<stem>.bin, one file for openntc::ShaderBlob (include/openntc/permutation/ShaderBlob.h); its
# path is the target's property OPENNTC_SHADER_BLOB.
# FLAT: text instead of SPIR-V, without #include and other directives, for hosts that have none (docs/shaders.md):
# <binary dir>/<stem>/<permutation>.glsl or .hlsl and index.txt there; the folder is the target's property
# OPENNTC_SHADER_DIRECTORY. SOURCES may be headers and files of functions alone.
#
# Permutations are separate build steps: they run in parallel, and again only when a file that they include changes. With
# OPENNTC_SHADER_CACHE=DIR in the environment of a build, what was compiled once is found again by content, also from other
# build folders.
#
# Cooperative vectors (NTC_MATH 6 and 7) and matrices (8 and 9) are GLSL for Vulkan 1.3, and need a glslang that knows
# GL_NV_cooperative_vector (but for NTC_COOPMAT_EMULATED=1, which every one compiles): OPENNTC_COOPVEC_GLSLANG, else `glslang`
# or `glslangValidator` if it does. Without one those permutations are left out with a message, and a lookup of one says so.
# docs/shaders.md has the whole story.
include_guard(GLOBAL)

option(OPENNTC_VALIDATE_SHADERS "Check compiled shaders with spirv-val" ON)

include("${CMAKE_CURRENT_LIST_DIR}/OpenNTCShaderPlan.cmake")

# Sets file_name, source_name, permutation, language_options and path to what a record of the plan holds.
macro(_openntc_split_record record)
  string(REPLACE "\t" ";" fields "${record}")
  list(GET fields 0 file_name)
  list(GET fields 1 source_name)
  list(GET fields 2 permutation)
  list(GET fields 3 language_options)
  list(GET fields 4 path)
endmacro()

# Adds the build step of one record of the plan that is to be text, likewise.
macro(_openntc_flatten_record record)
  _openntc_split_record("${${record}}")
  set(language glsl)
  if(path MATCHES "\\.hlsl$" OR " ${permutation} " MATCHES " NTC_HLSL=1 ")
    set(language hlsl)
  endif()
  string(REGEX REPLACE "spv$" "${language}" file_name "${file_name}")
  string(REPLACE " " ";" language_options "${language_options}")
  list(FILTER language_options EXCLUDE REGEX "^--no-storage-format$")
  list(TRANSFORM language_options REPLACE "^(comp|vert)$" frag) # as Flatten.cpp's: it exists in every version
  string(REPLACE " " ";" defines "${permutation}")
  list(TRANSFORM defines PREPEND "-D")
  set(flat "${directory}/${file_name}")
  string(APPEND index_text "${file_name}\t${source_name}\t${permutation}\n")
  add_custom_command(OUTPUT "${flat}"
    COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_SOURCE=${path}" "-DOPENNTC_OUTPUT=${flat}" "-DOPENNTC_LABEL=${source_name} ${permutation}"
      -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenNTCFlattenShader.cmake"
      -- "${OPENNTC_GLSLANG_VALIDATOR}" -E ${language_options} "-I$<JOIN:${includes},$<SEMICOLON>-I>" ${own_includes} ${defines} ${ARG_OPTIONS}
    DEPENDS "${path}" DEPFILE "${flat}.d" COMMENT "Text ${source_name} ${permutation}"
    COMMAND_EXPAND_LISTS VERBATIM)
  list(APPEND outputs "${flat}")
endmacro()

# Adds the build step of one record of the plan, in the scope and with the variables of openntc_add_shaders(); appends to
# `outputs`, `index_text`, `declarations`, `table` and `left_out`, and counts in `number`.
macro(_openntc_compile_record record)
  _openntc_split_record("${${record}}")
  set(compiler "${OPENNTC_GLSLANG_VALIDATOR}")
  set(environment "${ARG_TARGET_ENV}")
  set(validator "")
  if(OPENNTC_VALIDATE_SHADERS)
    set(validator "${OPENNTC_SPIRV_VAL}")
  endif()
  set(coopvec_define "")
  set(stored "")
  if(NOT permutation MATCHES "NTC_COOPMAT_EMULATED=1" AND " ${permutation} " MATCHES " (NTC_MATH=[6-9]) ")
    set(coopvec_define "${CMAKE_MATCH_1}")
    _openntc_find_coopvec_glslang()
    set(compiler "${_OPENNTC_COOPVEC_COMPILER}")
    if(environment MATCHES "^vulkan1\\.[0-2]$")
      set(environment vulkan1.3)
    endif()
    if(NOT compiler)
      _openntc_find_stored_spirv(stored "${path}" "${permutation}")
    endif()
    if(stored OR NOT _OPENNTC_COOPVEC_VALIDATES)
      set(validator "")
    endif()
  endif()
  set(environments --target-env "${environment}")
  if(path MATCHES "\\.hlsl$" AND environment MATCHES "^vulkan1\\.[2-9]$")
    # glslang 12 crashes on a function with a ByteAddressBuffer parameter when it writes SPIR-V later than 1.3, which is
    # all that its HLSL needs.
    list(APPEND environments --target-env spirv1.3)
  endif()
  if(coopvec_define AND (path MATCHES "\\.hlsl$" OR NOT compiler) AND NOT stored)
    list(APPEND left_out "${coopvec_define}")
  else()
    string(REPLACE " " ";" language_options "${language_options}")
    string(REPLACE " " ";" defines "${permutation}")
    list(TRANSFORM defines PREPEND "-D")
    set(spirv "${directory}/${file_name}")
    set(step_outputs "${spirv}")
    set(embedded "")
    if(ARG_OUTPUT STREQUAL "HEADER")
      set(embedded "${spirv}.inc")
      list(APPEND step_outputs "${embedded}")
      string(APPEND declarations
        "constexpr std::uint32_t kWords${number}[] = {\n#include \"${embedded}\"\n};\n")
      string(APPEND table "    {\"${source_name}\", \"${permutation}\", kWords${number}},\n")
    endif()
    string(APPEND index_text "${file_name}\t${source_name}\t${permutation}\n")
    add_custom_command(OUTPUT ${step_outputs}
      COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_SOURCE=${path}" "-DOPENNTC_OUTPUT=${spirv}" "-DOPENNTC_EMBED=${embedded}"
        "-DOPENNTC_LABEL=${source_name} ${permutation}" "-DOPENNTC_VALIDATOR=${validator}"
        "-DOPENNTC_ENVIRONMENT=${environment}" "-DOPENNTC_STORED=${stored}" -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenNTCCompileShader.cmake"
        -- "${compiler}" --quiet -V ${environments} ${language_options}
        "-I$<JOIN:${includes},$<SEMICOLON>-I>" ${own_includes} ${defines} ${ARG_OPTIONS}
      DEPENDS "${path}" DEPFILE "${spirv}.d" COMMENT "SPIR-V ${source_name} ${permutation}"
      COMMAND_EXPAND_LISTS VERBATIM)
    list(APPEND outputs ${step_outputs})
    list(APPEND spirv_files "${spirv}")
    math(EXPR number "${number} + 1")
  endif()
endmacro()

function(openntc_add_shaders)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "TARGET;OUTPUT;HEADER_NAME;TARGET_ENV;LIST;STAGE"
    "SOURCES;NETWORK_VERSIONS;MATH;DEFINES;INCLUDE_DIRECTORIES;OPTIONS")
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "openntc_add_shaders: unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT TARGET "${ARG_TARGET}")
    message(FATAL_ERROR "openntc_add_shaders: TARGET: \"${ARG_TARGET}\" is not a target")
  endif()
  if(NOT ARG_SOURCES AND NOT ARG_LIST)
    message(FATAL_ERROR "openntc_add_shaders: SOURCES: none given, and no LIST")
  endif()
  if(NOT ARG_OUTPUT)
    set(ARG_OUTPUT HEADER)
  elseif(NOT ARG_OUTPUT MATCHES "^(HEADER|FILES|BLOB|FLAT)$")
    message(FATAL_ERROR "openntc_add_shaders: OUTPUT: \"${ARG_OUTPUT}\": HEADER, FILES, BLOB or FLAT")
  endif()
  if(NOT ARG_STAGE AND ARG_OPTIONS MATCHES "(^|;)-S;(comp|frag|vert)(;|$)")
    set(ARG_STAGE "${CMAKE_MATCH_2}") # said the way of glslangValidator
  endif()
  if(ARG_OUTPUT STREQUAL "FLAT")
    set(ARG_STAGE frag) # any will do, and functions alone have none
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
  if(OPENNTC_VALIDATE_SHADERS)
    find_program(OPENNTC_SPIRV_VAL spirv-val REQUIRED)
  endif()

  set(includes "$<TARGET_PROPERTY:openntc::shaders,INTERFACE_INCLUDE_DIRECTORIES>")
  set(own_includes "${ARG_INCLUDE_DIRECTORIES}")
  list(TRANSFORM own_includes PREPEND "-I")
  _openntc_plan_shaders(plan SOURCES ${ARG_SOURCES} LIST "${ARG_LIST}" STAGE "${ARG_STAGE}"
    NETWORK_VERSIONS ${ARG_NETWORK_VERSIONS} MATH ${ARG_MATH} DEFINES ${ARG_DEFINES})

  set(outputs "")
  set(spirv_files "")
  set(index_text "")
  set(declarations "")
  set(table "")
  set(left_out "")
  set(number 0)
  foreach(record IN LISTS plan)
    if(ARG_OUTPUT STREQUAL "FLAT" AND NOT record MATCHES "NTC_COOPMAT_EMULATED=1" AND record MATCHES "(NTC_MATH=[6-9])[ \t].*\\.hlsl$")
      list(APPEND left_out "${CMAKE_MATCH_1}")
    elseif(ARG_OUTPUT STREQUAL "FLAT")
      _openntc_flatten_record(record)
    else()
      _openntc_compile_record(record)
    endif()
  endforeach()
  list(REMOVE_DUPLICATES left_out)
  list(SORT left_out)
  list(JOIN left_out " " left_out)
  if(left_out)
    string(REPLACE "NTC_MATH=6" "COOPVEC_INT8" left_out_names "${left_out}")
    string(REPLACE "NTC_MATH=7" "COOPVEC_FP8" left_out_names "${left_out_names}")
    string(REPLACE "NTC_MATH=8" "COOPMAT_INT8" left_out_names "${left_out_names}")
    string(REPLACE "NTC_MATH=9" "COOPMAT_INT8_HALF" left_out_names "${left_out_names}")
    message(STATUS "openntc_add_shaders(${ARG_TARGET} ${stem}): left out: ${left_out_names}: cooperative vectors and matrices need GLSL and a "
      "glslang that knows GL_NV_cooperative_vector${_OPENNTC_COOPVEC_HINT}")
  endif()

  file(MAKE_DIRECTORY "${directory}")
  if(ARG_OUTPUT STREQUAL "BLOB")
    set(list_file "${directory}/blob.txt")
    set(blob "${directory}/${stem}.bin")
    file(CONFIGURE OUTPUT "${list_file}" CONTENT "${left_out}\n${index_text}" @ONLY)
    add_custom_command(OUTPUT "${blob}" COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_BLOB_LIST=${list_file}"
        "-DOPENNTC_BLOB_OUTPUT=${blob}" -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenNTCShaderBlob.cmake"
      DEPENDS ${spirv_files} "${list_file}" COMMENT "SPIR-V ${stem}.bin: ${number} permutations" VERBATIM)
    list(APPEND outputs "${blob}")
    set_property(TARGET "${ARG_TARGET}" APPEND PROPERTY OPENNTC_SHADER_BLOB "${blob}")
  endif()
  add_custom_target("${group}" DEPENDS ${outputs})
  add_dependencies("${ARG_TARGET}" "${group}")
  if(ARG_OUTPUT MATCHES "^(FILES|FLAT)$")
    file(CONFIGURE OUTPUT "${directory}/index.txt" CONTENT "${index_text}" @ONLY)
    set_property(TARGET "${ARG_TARGET}" APPEND PROPERTY OPENNTC_SHADER_DIRECTORY "${directory}")
  endif()
  if(NOT ARG_OUTPUT STREQUAL "HEADER")
    return()
  endif()

  set(OPENNTC_SHADER_HEADER "${ARG_HEADER_NAME}")
  set(OPENNTC_SHADER_NAMESPACE "${namespace}")
  set(OPENNTC_SHADER_COUNT "${number}")
  set(OPENNTC_SHADER_WORDS "${declarations}")
  set(OPENNTC_SHADER_TABLE "constexpr Shader kTable[] = {\n${table}};\nconstexpr std::span<const Shader> kShaders(kTable);")
  if(number EQUAL 0) # all were left out
    set(OPENNTC_SHADER_TABLE "constexpr std::span<const Shader> kShaders;")
  endif()
  set(OPENNTC_SHADER_LEFT_OUT "${left_out}")
  configure_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenNTCShaderIndex.h.in" "${directory}/${ARG_HEADER_NAME}" @ONLY)
  configure_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenNTCShaderIndex.cpp.in" "${directory}/${stem}.cpp" @ONLY)
  target_sources("${ARG_TARGET}" PRIVATE "${directory}/${stem}.cpp")
  target_include_directories("${ARG_TARGET}" PRIVATE "${directory}")
  target_link_libraries("${ARG_TARGET}" PRIVATE openntc::openntc)
endfunction()
