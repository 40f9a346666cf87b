# SPDX-License-Identifier: MIT
# The viewer in the browser, where its tools are installed (tests/install.sh web). Label web: a stage of tests/run.sh.
if(NOT OPENNTC_NODE)
  openntc_say_skipped(web consumer_webgl "no node")
  return()
endif()
set(webgl_source "${consumer_source}/webgl")
add_test(NAME consumer_webgl_units COMMAND "${OPENNTC_NODE}" "${webgl_source}/units_test.mjs" "${PROJECT_SOURCE_DIR}/examples/webgl")
set_tests_properties(consumer_webgl_units PROPERTIES LABELS consumer TIMEOUT 120)
if(NOT TARGET webgl_viewer OR NOT TARGET ntc)
  openntc_say_skipped(web consumer_webgl "no emscripten or npm for examples/webgl and webgpu")
  return()
endif()
find_program(OPENNTC_CHROMIUM NAMES chromium chromium-browser google-chrome)
find_program(OPENNTC_XVFB_RUN xvfb-run)
if(NOT OPENNTC_CHROMIUM)
  openntc_say_skipped(web consumer_webgl "no Chromium")
  return()
endif()
add_dependencies(tests_consumer ntc synthesize)
# Those that are not there yet the test makes.
set(webgl_sets "${PROJECT_SOURCE_DIR}/examples/materials/data/bricks.ntc;${consumer_v1};${consumer_build}/v2.ntc")
foreach(name xlarge gen2 gen3)
  list(APPEND webgl_sets "${consumer_build}/webgl/${name}.ntc")
endforeach()
add_test(NAME consumer_webgl COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}" "-DSOURCE=${webgl_source}"
  "-DNODE=${OPENNTC_NODE}" "-DNTC=$<TARGET_FILE:ntc>" "-DSYNTHESIZE=$<TARGET_FILE:synthesize>" "-DCHROMIUM=${OPENNTC_CHROMIUM}" "-DXVFB=${OPENNTC_XVFB_RUN}"
  "-DDIRECTORY=${consumer_build}/webgl" "-DPAGES=${PROJECT_SOURCE_DIR}/docs/engines"
  "-DSETS=${webgl_sets}"
  -P "${webgl_source}/check.cmake")
set_tests_properties(consumer_webgl PROPERTIES LABELS web FIXTURES_REQUIRED "consumer_v1;consumer_v2" TIMEOUT 1200 COST 60)
add_test(NAME consumer_webgl_material COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}" "-DSOURCE=${webgl_source}"
  "-DNODE=${OPENNTC_NODE}" "-DNTC=$<TARGET_FILE:ntc>" "-DCHROMIUM=${OPENNTC_CHROMIUM}" "-DXVFB=${OPENNTC_XVFB_RUN}"
  "-DDIRECTORY=${consumer_build}/webgl" "-DSET=${PROJECT_SOURCE_DIR}/examples/materials/data/grille.ntc"
  -P "${webgl_source}/check_material.cmake")
set_tests_properties(consumer_webgl_material PROPERTIES LABELS web DEPENDS consumer_webgl TIMEOUT 600)
add_test(NAME consumer_webgpu_dawn COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}" "-DSOURCE=${consumer_source}/webgpu"
  "-DNODE=${OPENNTC_NODE}" "-DNPM=${OPENNTC_NPM}" "-DNTC=$<TARGET_FILE:ntc>" "-DDIRECTORY=${consumer_build}/webgpu" "-DSETS=${webgl_sets}"
  -P "${consumer_source}/webgpu/check_dawn.cmake")
set_tests_properties(consumer_webgpu_dawn PROPERTIES LABELS web DEPENDS consumer_webgl TIMEOUT 600)
