// SPDX-License-Identifier: MIT
// Sixteen lanes - a row of a tile's texels, or sixteen channels of one texel - over the vectors of one
// instruction set, which including sources define (Avx2.h, Avx512.h, Neon.h) with `kLanes` lanes each. What
// is one operation here is rounded once, in the same order on every instruction set: kernels that multiply in
// binary32 agree bit for bit.

inline constexpr int kParts = 16 / kLanes;

struct Float {
    NativeFloat part[kParts];
};
struct Bits {
    NativeBits part[kParts];
};
struct Mask {
    NativeMask part[kParts];
};

#define OPENNTC_BLOCKED_LIFT(Result, expression)                                                             \
    Result result;                                                                                           \
    OPENNTC_FAST_UNROLL                                                                                      \
    for (int k = 0; k < kParts; ++k)                                                                         \
        result.part[k] = expression;                                                                         \
    return result

OPENNTC_FAST_INLINE Float Load(const float* from) {
    OPENNTC_BLOCKED_LIFT(Float, LoadNative(from + k * kLanes));
}
OPENNTC_FAST_INLINE void Store(float* to, const Float& v) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < kParts; ++k)
        StoreNative(to + k * kLanes, v.part[k]);
}
/// The first `count` of 16 floats; zeros after them.
OPENNTC_FAST_INLINE Float LoadPartial(const float* from, int count) {
    OPENNTC_BLOCKED_LIFT(Float, LoadNativePartial(from + k * kLanes, count - k * kLanes));
}
OPENNTC_FAST_INLINE void StorePartial(float* to, const Float& v, int count) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < kParts; ++k)
        StoreNativePartial(to + k * kLanes, v.part[k], count - k * kLanes);
}
/// Sixteen unsigned integers of 16 bits.
OPENNTC_FAST_INLINE Float LoadShorts(const std::uint16_t* from) {
    OPENNTC_BLOCKED_LIFT(Float, LoadNativeShorts(from + k * kLanes));
}
OPENNTC_FAST_INLINE Float Set(float v) {
    OPENNTC_BLOCKED_LIFT(Float, SetNative(v));
}
OPENNTC_FAST_INLINE Float Add(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Add(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float Subtract(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Subtract(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float Multiply(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Multiply(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float Divide(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Divide(a.part[k], b.part[k]));
}
/// a b + c, rounded once.
OPENNTC_FAST_INLINE Float MultiplyAdd(const Float& a, const Float& b, const Float& c) {
    OPENNTC_BLOCKED_LIFT(Float, MultiplyAdd(a.part[k], b.part[k], c.part[k]));
}
OPENNTC_FAST_INLINE Float SquareRoot(const Float& v) {
    OPENNTC_BLOCKED_LIFT(Float, SquareRoot(v.part[k]));
}
OPENNTC_FAST_INLINE Float Min(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Min(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float Max(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Max(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float Floor(const Float& v) {
    OPENNTC_BLOCKED_LIFT(Float, Floor(v.part[k]));
}
OPENNTC_FAST_INLINE Float Truncate(const Float& v) {
    OPENNTC_BLOCKED_LIFT(Float, Truncate(v.part[k]));
}
OPENNTC_FAST_INLINE Mask Less(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Mask, Less(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Mask Equal(const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Mask, Equal(a.part[k], b.part[k]));
}
/// a where the mask is set, b elsewhere.
OPENNTC_FAST_INLINE Float Select(const Mask& mask, const Float& a, const Float& b) {
    OPENNTC_BLOCKED_LIFT(Float, Select(mask.part[k], a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Bits LoadBits(const std::int32_t* from) {
    OPENNTC_BLOCKED_LIFT(Bits, LoadNativeBits(from + k * kLanes));
}
OPENNTC_FAST_INLINE Bits SetBits(std::uint32_t v) {
    OPENNTC_BLOCKED_LIFT(Bits, SetNativeBits(v));
}
OPENNTC_FAST_INLINE Bits Add(const Bits& a, const Bits& b) {
    OPENNTC_BLOCKED_LIFT(Bits, Add(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Bits Multiply(const Bits& a, const Bits& b) {
    OPENNTC_BLOCKED_LIFT(Bits, Multiply(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Bits Xor(const Bits& a, const Bits& b) {
    OPENNTC_BLOCKED_LIFT(Bits, Xor(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float And(const Float& a, const Bits& b) {
    OPENNTC_BLOCKED_LIFT(Float, And(a.part[k], b.part[k]));
}
OPENNTC_FAST_INLINE Float AddToBits(const Float& a, const Bits& b) {
    OPENNTC_BLOCKED_LIFT(Float, AddToBits(a.part[k], b.part[k]));
}
template <int kBits>
OPENNTC_FAST_INLINE Bits ShiftRight(const Bits& v) {
    OPENNTC_BLOCKED_LIFT(Bits, ShiftRight<kBits>(v.part[k]));
}
OPENNTC_FAST_INLINE Bits ShiftRight(const Bits& v, const Bits& count) {
    OPENNTC_BLOCKED_LIFT(Bits, ShiftRight(v.part[k], count.part[k]));
}
/// Of integers below 2^31.
OPENNTC_FAST_INLINE Float ToFloat(const Bits& v) {
    OPENNTC_BLOCKED_LIFT(Float, ToFloat(v.part[k]));
}
/// row[index], `index` below 16 when `pitch` is.
OPENNTC_FAST_INLINE Float Pick(const float* row, int pitch, const Bits& index) {
    OPENNTC_BLOCKED_LIFT(Float, PickNative(row, pitch, index.part[k]));
}

#undef OPENNTC_BLOCKED_LIFT

/// 16 x 16 floats, rows of both `pitch`es apart.
OPENNTC_FAST_INLINE void Transpose(const float* from, int fromPitch, float* to, int toPitch) {
    for (int i = 0; i < 16; i += kLanes) {
        for (int j = 0; j < 16; j += kLanes)
            TransposeNative(from + i * fromPitch + j, fromPitch, to + j * toPitch + i, toPitch);
    }
}

/// The power of two in a number.
OPENNTC_FAST_INLINE Float GetPower(const Float& v) {
    return And(v, SetBits(0x7f800000u));
}
/// Rounds to the nearest number of kBits bits behind the bit of `power`, which numbers stay below twice of;
/// ties to even; zeros lose their sign. Adds and takes away 1.5 x 2^(23 - kBits) `power`, whose last bit is
/// the one that stays.
template <int kBits>
OPENNTC_FAST_INLINE Float RoundToBits(const Float& v, const Float& power) {
    const Float raise = AddToBits(power, SetBits(((23u - kBits) << 23) + 0x400000u));
    return Subtract(Add(v, raise), raise);
}
/// To binary16 (RoundToHalf); beside 0, below 2^-14, with more bits than that has.
OPENNTC_FAST_INLINE Float RoundToNormalHalf(const Float& v) {
    return RoundToBits<10>(v, GetPower(v));
}
OPENNTC_FAST_INLINE Float RoundToHalf(const Float& v) {
    return RoundToBits<10>(v, Max(GetPower(v), Set(0x1p-14f)));
}
/// Of magnitudes up to 448.
OPENNTC_FAST_INLINE Float RoundToSmallE4M3(const Float& v) {
    return RoundToBits<3>(v, Max(GetPower(v), Set(0x1p-6f)));
}
OPENNTC_FAST_INLINE Float RoundToE4M3(const Float& v) {
    return Min(Max(RoundToSmallE4M3(v), Set(-448.0f)), Set(448.0f));
}
/// The scalar function of this name.
OPENNTC_FAST_INLINE Float RoundToInput(const Float& v) {
    return RoundToE4M3(RoundToHalf(v));
}

/// Hash of seed, seed + 1 ... seed + 15.
OPENNTC_FAST_INLINE Bits HashLanes(std::uint32_t seed) {
    alignas(64) static constexpr std::int32_t kCount[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                            8, 9, 10, 11, 12, 13, 14, 15};
    Bits v = Add(LoadBits(kCount), SetBits(seed));
    v = Add(Multiply(v, SetBits(747796405u)), SetBits(2891336453u));
    v = Multiply(Xor(ShiftRight(v, Add(ShiftRight<28>(v), SetBits(4u))), v), SetBits(277803737u));
    return Xor(ShiftRight<22>(v), v);
}
