# SPDX-License-Identifier: MIT
openntc_add_test(WARM NAME conformance LABEL conformance DIRECTORY conformance LIBRARIES openntc::decode openntc_models)
# The back ends of the command line: the specification's vectors, recorded texels, whole mips.
if(TARGET ntc_tool)
  openntc_add_test(WARM SECONDS 35 NAME conformance_backends LABEL conformance DIRECTORY conformance/backends LIBRARIES ntc_tool)
  # As in numerics: without a device.
  if(OPENNTC_SANITIZE)
    target_compile_definitions(conformance_backends PRIVATE OPENNTC_TEST_SANITIZED)
    set_tests_properties(conformance_backends PROPERTIES
      ENVIRONMENT "VK_ICD_FILENAMES=/dev/null;VK_DRIVER_FILES=/dev/null")
  endif()
endif()
# Runs programs that crash on purpose.
if(OPENNTC_SANITIZE)
  openntc_say_skipped(conformance conformance_suite_left_out
    "conformance_suite: its adapters crash on purpose, which sanitizers report")
  return()
endif()
# The exported suite, its adapters and planted mistakes.
if(TARGET wrong_decoder)
  openntc_add_test(WARM SECONDS 50 NAME conformance_suite LABEL conformance DIRECTORY conformance/suite LIBRARIES ntc_tool openntc_models
    DEFINITIONS "NTC_PROGRAM=\"$<TARGET_FILE:ntc>\"" "NTC_SCHEMA_DIR=\"${PROJECT_SOURCE_DIR}/schemas\""
      "WRONG_DECODER=\"$<TARGET_FILE:wrong_decoder>\""
      "EXAMPLE_ADAPTER=\"$<TARGET_FILE:openntc_example_adapter>\"")
  add_dependencies(conformance_suite ntc wrong_decoder openntc_example_adapter)
endif()
