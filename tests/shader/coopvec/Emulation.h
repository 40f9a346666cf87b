// SPDX-License-Identifier: MIT
// GL_NV_cooperative_vector in C++, as far as InferenceCoopVec.h uses it: vectors are arrays, matrices are row-major and of the
// generic weights, E4M3 sums are those of the FP8 reference (NetworkFP8.h). What the driver would convert is
// rounded to nearest even and saturated.
#pragma once

#include "openntc/Inference.h"
#include "openntc/core/E4M3.h"
#include "openntc/core/Half.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>

namespace openntc::shader {

/// A binary16 number; each operation is rounded once.
struct float16_t {
    float value = 0;

    float16_t() = default;
    explicit float16_t(float x) : value(NtcRoundToHalf(x)) {}
    explicit operator float() const { return value; }
    friend float16_t operator+(float16_t a, float16_t b) { return float16_t(a.value + b.value); }
    friend float16_t operator-(float16_t a, float16_t b) { return float16_t(a.value - b.value); }
    friend float16_t operator*(float16_t a, float16_t b) { return float16_t(a.value * b.value); }
    friend bool operator<(float16_t a, float16_t b) { return a.value < b.value; }
};

template <typename T, int N>
class coopvecNV {
public:
    coopvecNV() = default;
    explicit coopvecNV(T value) { std::fill(std::begin(elements_), std::end(elements_), value); }
    template <typename U>
    explicit coopvecNV(const coopvecNV<U, N>& other) {
        for (int i = 0; i < N; ++i)
            elements_[i] = static_cast<T>(other[i]);
    }
    template <typename Index>
    T& operator[](Index i) {
        return elements_[i];
    }
    template <typename Index>
    const T& operator[](Index i) const {
        return elements_[i];
    }

    friend coopvecNV operator+(const coopvecNV& a, const coopvecNV& b) {
        return Combine(a, b, [](T x, T y) { return x + y; });
    }
    friend coopvecNV operator-(const coopvecNV& a, const coopvecNV& b) {
        return Combine(a, b, [](T x, T y) { return x - y; });
    }
    friend coopvecNV operator*(const coopvecNV& a, const coopvecNV& b) {
        return Combine(a, b, [](T x, T y) { return x * y; });
    }
    friend coopvecNV(min)(const coopvecNV& a, const coopvecNV& b) {
        return Combine(a, b, [](T x, T y) { return y < x ? y : x; });
    }
    friend coopvecNV(max)(const coopvecNV& a, const coopvecNV& b) {
        return Combine(a, b, [](T x, T y) { return x < y ? y : x; });
    }
    friend coopvecNV clamp(const coopvecNV& x, const coopvecNV& low, const coopvecNV& high) {
        return min(max(x, low), high);
    }

private:
    template <typename Operation>
    static coopvecNV Combine(const coopvecNV& a, const coopvecNV& b, Operation operation) {
        coopvecNV result;
        for (int i = 0; i < N; ++i)
            result.elements_[i] = operation(a.elements_[i], b.elements_[i]);
        return result;
    }

    T elements_[N] = {};
};

enum CoopVecType {
    gl_ComponentTypeFloat16NV,
    gl_ComponentTypeFloatE4M3NV,
    gl_ComponentTypeSignedInt8NV,
    gl_ComponentTypeSignedInt8PackedNV,
    gl_ComponentTypeSignedInt32NV,
};
enum CoopVecLayout { gl_CooperativeVectorMatrixLayoutRowMajorNV };

using CoopVecBuffer = std::span<const std::byte>;

template <typename T>
T LoadElement(CoopVecBuffer buffer, std::size_t offset) {
    if (offset + sizeof(T) > buffer.size())
        throw std::out_of_range("cooperative vector: beyond the weights");
    T value{};
    std::memcpy(&value, buffer.data() + offset, sizeof value);
    return value;
}

template <int N>
void coopVecLoadNV(coopvecNV<float, N>& vector, CoopVecBuffer buffer, uint offset) {
    for (int i = 0; i < N; ++i)
        vector[i] = LoadElement<float>(buffer, offset + 4u * static_cast<uint>(i));
}

/// Input `column` as the signed byte that the multiplication reads.
template <int N>
int GetByte(const coopvecNV<std::uint32_t, N>& x, CoopVecType interpretation, int column) {
    if (interpretation != gl_ComponentTypeSignedInt8PackedNV)
        throw std::invalid_argument("cooperative vector: words are packed bytes");
    return NtcSignedByte(x[column / 4], static_cast<uint>(column % 4));
}
template <int N>
int GetByte(const coopvecNV<float, N>& x, CoopVecType interpretation, int column) {
    if (interpretation != gl_ComponentTypeSignedInt8NV)
        throw std::invalid_argument("cooperative vector: floats become bytes");
    return static_cast<int>(std::clamp(std::nearbyint(x[column]), -128.0f, 127.0f));
}

inline void CheckOperands(bool fits, CoopVecType matrixType, CoopVecType matrix, CoopVecType biasType,
                          CoopVecType bias, bool transpose, int columns, int stride) {
    if (!fits || matrixType != matrix || biasType != bias || transpose || stride != columns)
        throw std::invalid_argument("cooperative vector: operands that do not fit one another");
}

/// Signed bytes: wrapping sums of 32 bits.
template <int M, typename X, int N>
void coopVecMatMulAddNV(coopvecNV<std::int32_t, M>& result, const coopvecNV<X, N>& x,
                        CoopVecType interpretation, CoopVecBuffer matrices, uint matrix,
                        CoopVecType matrixType, CoopVecBuffer biases, uint bias, CoopVecType biasType,
                        int rows, int columns, CoopVecLayout, bool transpose, int stride) {
    CheckOperands(
        rows == M &&
            columns == (sizeof(X) == 4 && interpretation == gl_ComponentTypeSignedInt8PackedNV ? 4 * N : N),
        matrixType, gl_ComponentTypeSignedInt8NV, biasType, gl_ComponentTypeSignedInt32NV, transpose, columns,
        stride);
    for (int row = 0; row < M; ++row) {
        uint sum = LoadElement<uint>(biases, bias + 4u * static_cast<uint>(row));
        for (int column = 0; column < columns; ++column)
            sum += static_cast<uint>(
                LoadElement<std::int8_t>(matrices, matrix + static_cast<uint>(row * stride + column)) *
                GetByte(x, interpretation, column));
        result[row] = static_cast<std::int32_t>(sum);
    }
}

/// E4M3: sums as in NtcEvaluateE4M3Row.
template <int M, int N>
void coopVecMatMulAddNV(coopvecNV<float16_t, M>& result, const coopvecNV<float16_t, N>& x,
                        CoopVecType interpretation, CoopVecBuffer matrices, uint matrix,
                        CoopVecType matrixType, CoopVecBuffer biases, uint bias, CoopVecType biasType,
                        int rows, int columns, CoopVecLayout, bool transpose, int stride) {
    CheckOperands(rows == M && columns == N && interpretation == gl_ComponentTypeFloatE4M3NV, matrixType,
                  gl_ComponentTypeFloatE4M3NV, biasType, gl_ComponentTypeFloat16NV, transpose, columns,
                  stride);
    for (int row = 0; row < M; ++row) {
        float sum = HalfToFloat(LoadElement<std::uint16_t>(biases, bias + 2u * static_cast<uint>(row)));
        for (int column = 0; column < columns; ++column) {
            const auto weight =
                LoadElement<std::uint8_t>(matrices, matrix + static_cast<uint>(row * stride + column));
            sum += NtcMultiply(E4M3ToFloat(weight), NtcRoundToE4M3(x[column].value));
        }
        result[row] = float16_t(sum);
    }
}

} // namespace openntc::shader
