# SPDX-License-Identifier: MIT
openntc_add_test(HOT NAME conformance LABEL conformance DIRECTORY conformance LIBRARIES openntc::decode)
# The back ends of the command line: the specification's vectors, recorded texels, whole mips.
if(TARGET ntc_tool)
  openntc_add_test(HOT NAME conformance_backends LABEL conformance DIRECTORY conformance/backends LIBRARIES ntc_tool)
endif()
