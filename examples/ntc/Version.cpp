// SPDX-License-Identifier: MIT
#include "Version.h"

#include "openntc/decode/FastDecoder.h"
#include "openntc/encode/Kernels.h"

#include "openntc_commit.h"

#if defined(OPENNTC_VERSION_HAS_COMPILER)
#include "shader_compiler/Compiler.h"
#include <glslang/build_info.h>
#endif

namespace openntc::tool {

namespace {

std::string DescribeCompiler() {
#if defined(__clang__)
    return std::string("Clang ") + __clang_version__;
#elif defined(__GNUC__)
    return std::string("GCC ") + __VERSION__;
#elif defined(_MSC_VER)
    return "MSVC " + std::to_string(_MSC_FULL_VER);
#else
    return "unknown";
#endif
}

/// The decoder's; the one that it uses first.
std::string DescribeKernels() {
    std::string text;
    for (const SimdTarget target : {SimdTarget::Amx, SimdTarget::Avx512Vnni, SimdTarget::AvxVnni,
                                    SimdTarget::Avx2, SimdTarget::Portable}) {
        if (IsSimdTargetAvailable(target))
            text += (text.empty() ? "" : ", ") + std::string(SimdTargetToString(target));
    }
    return text;
}

std::string DescribeEncoderKernels() {
    std::string text;
    for (const encode::KernelChoice kernel : encode::kKernels) {
        if (encode::IsKernelAvailable(kernel))
            text += (text.empty() ? "" : ", ") + std::string(encode::KernelToString(kernel));
    }
    return text;
}

std::string DescribeShaderCompiler() {
#if defined(OPENNTC_VERSION_HAS_COMPILER)
    return "glslang " + std::to_string(GLSLANG_VERSION_MAJOR) + "." + std::to_string(GLSLANG_VERSION_MINOR) +
           "." + std::to_string(GLSLANG_VERSION_PATCH) +
           (shader_compiler::KnowsCooperativeVectors() ? ", with cooperative vectors"
                                                       : ", without cooperative vectors");
#else
    return "none in this build";
#endif
}

} // namespace

std::string DescribeVersion() {
    std::string text = "ntc " OPENNTC_TOOL_VERSION;
    text += "\ncommit    " OPENNTC_COMMIT;
    text += "\ncompiler  " + DescribeCompiler();
    text += "\nkernels   " + DescribeKernels() + " (of this machine, the first is used)";
    text += "\nencoder   " + DescribeEncoderKernels() + " (of this machine, the first is used)";
    text += "\nshaders   " + DescribeShaderCompiler();
#if defined(OPENNTC_VERSION_HAS_VULKAN)
    text += "\nVulkan    yes (ntc devices lists what there is)";
#else
    text += "\nVulkan    not in this build";
#endif
    return text;
}

} // namespace openntc::tool
