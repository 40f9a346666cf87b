// SPDX-License-Identifier: MIT
// A function with a buffer as a parameter: glslang 12 crashes on it when it writes SPIR-V later than 1.3.
[[vk::binding(0)]] ByteAddressBuffer source;
[[vk::binding(1)]] RWByteAddressBuffer target;

uint Load(ByteAddressBuffer buffer, uint at) {
    return buffer.Load(at);
}

[numthreads(1, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    target.Store(0u, Load(source, 4u));
}
