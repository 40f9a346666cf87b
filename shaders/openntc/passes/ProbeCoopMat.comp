// SPDX-License-Identifier: MIT
// Compute pass: which elements of a 16 x 16 accumulator of int each of 32 lanes holds. Set 0, binding 0: nine
// int a lane, 16 row + column of its elements 0 ... 7, then how many it has (ReadCoopMatLayout in
// inference/CooperativeMatrices.h). One workgroup; Vulkan 1.3.
#version 460
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_cooperative_matrix : require

layout(local_size_x = 32) in;

layout(set = 0, binding = 0, std430) writeonly buffer Results {
    int values[];
} gResults;
shared int sElements[256];

void main() {
    uint lane = gl_SubgroupInvocationID;
    for (uint i = lane; i < 256u; i += 32u) sElements[i] = int(i);
    barrier();
    coopmat<int, gl_ScopeSubgroup, 16, 16, gl_MatrixUseAccumulator> c;
    coopMatLoad(c, sElements, 0, 16, gl_CooperativeMatrixLayoutRowMajor);
    int count = int(c.length());
    for (int i = 0; i < 8; i++) gResults.values[9u * lane + uint(i)] = i < count ? c[i] : -1;
    gResults.values[9u * lane + 8u] = count;
}
