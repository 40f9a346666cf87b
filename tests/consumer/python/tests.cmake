# SPDX-License-Identifier: MIT
# The Python package, where it is built.
if(NOT TARGET openntc_python)
  openntc_say_skipped(consumer consumer_python "no pybind11, or no Python with its headers and NumPy")
  return()
endif()
add_dependencies(tests_consumer openntc_python ntc)
add_test(NAME consumer_python COMMAND "${OPENNTC_PYTHON}" "${consumer_source}/python/test_openntc.py" "${consumer_v1}"
  "$<TARGET_FILE:ntc>")
add_test(NAME consumer_python_script COMMAND "${OPENNTC_PYTHON}" "${consumer_source}/python/test_convert_materials.py"
  "${PROJECT_SOURCE_DIR}/examples/python/convert_materials.py")
foreach(name consumer_python consumer_python_script)
  set_tests_properties(${name} PROPERTIES LABELS consumer FIXTURES_REQUIRED consumer_v1 TIMEOUT 600
    ENVIRONMENT "PYTHONPATH=${PROJECT_BINARY_DIR}/python;PYTHONDONTWRITEBYTECODE=1")
endforeach()
