// SPDX-License-Identifier: MIT
// What the exported suite consists of, part by part.
#include "SuiteBuilder.h"

namespace openntc::conformance {

Suite MakeSuite() {
    SuiteBuilder builder;
    AddVersion2(builder);
    AddShapes(builder);
    AddFileForms(builder);
    AddNumberEnds(builder);
    AddRequests(builder);
    AddSequence(builder);
    AddGenerations(builder);
    return builder.Take();
}

} // namespace openntc::conformance
