# SPDX-License-Identifier: MIT
# The catalogue of hard cases, on every decoder; OPENNTC_TEST_DEVICE names a GPU in lavapipe's place.
if(TARGET ntc_tool)
  set(numerics_filter "")
  if(OPENNTC_SANITIZE)
    openntc_leave_out(numerics numerics_filter NAME numerics WHY "tries the tests, not the product: minutes under sanitizers"
      CASES "hard cases notice the mistakes*")
  endif()
  openntc_add_test(WARM SECONDS 25 NAME numerics LABEL numerics DIRECTORY numerics LIBRARIES ntc_tool openntc_models
    ARGUMENTS ${numerics_filter} DEFINITIONS "OPENNTC_DOCS_DIR=\"${PROJECT_SOURCE_DIR}/docs\"")
  # Sanitizers are for our code: on the CPU device alone it would be the driver's compiler that takes the minutes.
  if(OPENNTC_SANITIZE)
    # Trainings would take minutes; unit_encode has short ones.
    set_tests_properties(numerics PROPERTIES ENVIRONMENT
      "VK_ICD_FILENAMES=/dev/null;VK_DRIVER_FILES=/dev/null;OPENNTC_HARD_CASES_WITHOUT_TRAINING=1")
  endif()
  # Block encoders against the exact optimum.
  if(OPENNTC_SANITIZE)
    openntc_say_skipped(numerics numerics_blocks "numerics_blocks: searches for optima take minutes under sanitizers")
  else()
    openntc_add_test(WARM SECONDS 18 NAME numerics_blocks LABEL numerics DIRECTORY numerics/blocks LIBRARIES ntc_tool)
  endif()
endif()
