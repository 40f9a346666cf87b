// SPDX-License-Identifier: MIT
RWByteAddressBuffer results : register(u0);

[numthreads(1, 1, 1)] void Fill(uint3 id : SV_DispatchThreadID) {
    results.Store(4u * id.x, uint(SIZE + COLOUR));
}
