# SPDX-License-Identifier: MIT
# Finds the header-only libraries that OpenNTC's headers include. Used by the source tree and by the installed package.
# OPENNTC_MISSING_DEPENDENCIES: what openntc::openntc lacks; OPENNTC_MISSING_FOR_DECODE: what openntc::decode lacks besides.
# Each can be pointed at by hand: OPENNTC_RAPIDJSON_INCLUDE_DIR, OPENNTC_EXPECTED_INCLUDE_DIR, OPENNTC_GLM_INCLUDE_DIR.

set(OPENNTC_MISSING_DEPENDENCIES "")
set(OPENNTC_MISSING_FOR_DECODE "")

# openntc_find_headers(OPENNTC_MISSING_FOR_DECODE glm OPENNTC_GLM_INCLUDE_DIR glm/vec4.hpp "GLM (Debian: libglm-dev)")
# makes the target openntc::glm, or adds a line to OPENNTC_MISSING_FOR_DECODE.
macro(openntc_find_headers missing name variable header description)
  find_path(${variable} ${header} DOC "Folder that holds ${header}")
  if(NOT ${variable})
    string(APPEND ${missing}
      "  ${header} of ${description}; install it or set ${variable}\n")
  elseif(NOT TARGET openntc::${name})
    # Global, so that projects that use us with add_subdirectory can see it.
    add_library(openntc::${name} INTERFACE IMPORTED GLOBAL)
    target_include_directories(openntc::${name} SYSTEM INTERFACE "${${variable}}")
  endif()
endmacro()

openntc_find_headers(OPENNTC_MISSING_DEPENDENCIES
  rapidjson OPENNTC_RAPIDJSON_INCLUDE_DIR rapidjson/reader.h "RapidJSON (Debian: rapidjson-dev)")
openntc_find_headers(OPENNTC_MISSING_DEPENDENCIES
  expected OPENNTC_EXPECTED_INCLUDE_DIR tl/expected.hpp "tl::expected (Debian: libexpected-dev)")
openntc_find_headers(OPENNTC_MISSING_FOR_DECODE
  glm OPENNTC_GLM_INCLUDE_DIR glm/vec4.hpp "GLM (Debian: libglm-dev)")
