// SPDX-License-Identifier: MIT
// The encoder's passes on a device of the harness.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/encode/TrainingDevice.h"

#include <memory>

namespace openntc::harness {

enum class TrainingForm {
    Best,     ///< on matrices where the device has those of binary16
    Plain,    ///< for any device
    Matrices, ///< an error where the device or SPIR-V lacks them
};

/// `context` outlives it. Errors: Unsupported, ShaderUnavailable for TrainingForm::Matrices.
Expected<std::unique_ptr<encode::TrainingDevice>> MakeTrainingQueue(Context& context,
                                                                    TrainingForm form = TrainingForm::Best);

} // namespace openntc::harness
