# SPDX-License-Identifier: MIT
# The catalogue of hard cases, on every decoder; OPENNTC_TEST_DEVICE names a GPU in lavapipe's place.
if(TARGET ntc_tool)
  openntc_add_test(NAME numerics LABEL numerics DIRECTORY numerics LIBRARIES ntc_tool openntc_models
    DEFINITIONS "OPENNTC_DOCS_DIR=\"${PROJECT_SOURCE_DIR}/docs\"")
endif()
