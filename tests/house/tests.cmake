# SPDX-License-Identifier: MIT
# The contracts of docs/architecture.md, read from the sources themselves.
openntc_add_test(WARM NAME house LABEL house DIRECTORY house
  DEFINITIONS "OPENNTC_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\"")

# The documentation site: links between pages lead somewhere, and Doxygen can read the headers' comments.
add_test(NAME house_site COMMAND "${CMAKE_COMMAND}" "-DSCRIPT=${PROJECT_SOURCE_DIR}/cmake/site/make_site.py"
  "-DOUTPUT=${PROJECT_BINARY_DIR}/site" -P "${CMAKE_CURRENT_SOURCE_DIR}/house/site.cmake")
set_tests_properties(house_site PROPERTIES LABELS house TIMEOUT 300)

# The start of programs under Wine, with a stand-in that loses its server as Wine does.
add_test(NAME house_wine_starts
  COMMAND sh "${CMAKE_CURRENT_SOURCE_DIR}/house/wine_starts.sh" "${PROJECT_SOURCE_DIR}/cmake/toolchains/wine.sh"
  "${CMAKE_CURRENT_BINARY_DIR}/wine_starts")
set_tests_properties(house_wine_starts PROPERTIES LABELS house)
