# SPDX-License-Identifier: MIT
openntc_add_test(NAME conformance LABEL conformance DIRECTORY conformance LIBRARIES openntc::decode)
