# SPDX-License-Identifier: MIT
# The header-only libraries of the host, made visible to cross compilers: /usr/include itself would bring glibc along.
set(openntc_cross_headers "${CMAKE_CURRENT_LIST_DIR}/../../build/cross-headers")
file(MAKE_DIRECTORY "${openntc_cross_headers}")
foreach(library rapidjson tl glm doctest)
  if(EXISTS "/usr/include/${library}" AND NOT EXISTS "${openntc_cross_headers}/${library}")
    file(CREATE_LINK "/usr/include/${library}" "${openntc_cross_headers}/${library}" SYMBOLIC)
  endif()
endforeach()
foreach(name RAPIDJSON EXPECTED GLM DOCTEST)
  set(OPENNTC_${name}_INCLUDE_DIR "${openntc_cross_headers}" CACHE PATH "Header-only libraries of the host")
endforeach()
