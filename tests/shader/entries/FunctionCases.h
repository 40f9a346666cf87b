// SPDX-License-Identifier: MIT
// One case per public shader function, in the common subset: four words in, four words out. Functions.comp runs it on
// the device, functions_test.cpp runs the C++ build of the same source. Case numbers are the order below.
#ifndef OPENNTC_TESTS_FUNCTION_CASES_H
#define OPENNTC_TESTS_FUNCTION_CASES_H

#include "openntc/Inference.h"

#if defined(__cplusplus)
#define CASE_RESOURCES                                                                                       \
    const openntc::NtcTextureSetConstants &desc, NtcBuffer latentBuffer, NtcBuffer weightBuffer,
#define CASE_LATENTS latentBuffer
#define CASE_WEIGHTS weightBuffer
#define CASE_NETWORK 3,
#define CASE_MODE 3, NTC_MATH_INT8,
#else
#define CASE_RESOURCES
#define CASE_LATENTS NTC_LATENTS
#define CASE_WEIGHTS NTC_WEIGHTS
#define CASE_NETWORK
#define CASE_MODE
#endif

NTC_NAMESPACE_BEGIN

NTC_FUNCTION void RunCase(CASE_RESOURCES uint number, uint a, uint b, uint c, uint d,
                          NTC_OUT_ARRAY(uint, r, 4)) {
    r[0] = 0u;
    r[1] = 0u;
    r[2] = 0u;
    r[3] = 0u;
    if (number == 0u) {
        r[0] = asuint(NtcMultiply(asfloat(a), asfloat(b)));
    } else if (number == 1u) {
        r[0] = uint(NtcSignedByte(a, b & 3u));
        r[1] = NtcIsNan(asfloat(a)) ? 1u : 0u;
        r[2] = uint(NtcDot4Emulated(a, b));
        r[3] = uint(NtcDot4(a, b));
    } else if (number == 2u) {
        r[0] = NtcBufferLoad(CASE_LATENTS, (a & 255u) * 4u);
        r[1] = NtcBufferLoad(CASE_WEIGHTS, (b & 255u) * 4u);
        r[2] = NtcGetHighResWords(int(a & 3u) + 1);
        r[3] = NtcGetInputWords(int(a & 3u) + 1);
    } else if (number == 3u) {
        r[0] = asuint(NtcTriangleWave(asfloat(a)));
        r[1] = uint(NtcQuantizeInput(asfloat(a)));
        r[2] = NtcEncodePosition(asfloat(a), asfloat(b), 0.125f);
    } else if (number == 4u) {
        r[0] = asuint(NtcRoundToHalf(asfloat(a)));
        r[1] = NtcActivateFloat(asfloat(a));
        r[2] = NtcActivateHalf(asfloat(a));
        r[3] = (NtcIsActivationZero(asfloat(a)) ? 1u : 0u) | (NtcIsActivationMaximal(asfloat(a)) ? 2u : 0u);
    } else if (number == 5u) {
        r[0] = NtcRoundToByte(float(int(a & 1023u) - 512) * 0.25f);
        r[1] = uint(NtcGetChannelColorSpace(a, int(b & 15u)));
        r[2] = NtcGetChannelMask(int(a), int(b));
        r[3] = uint(NtcGetMipSize(int(a & 0xFFFFFu) + 1, int(b)));
    } else if (number == 6u) {
        r[0] = asuint(NtcTexelCenter(int(a), int(b & 0xFFFFFu) + 1));
    } else if (number == 7u) {
        uint divisor = (b & 0x7FFFFFu) | 0x800000u;
        uint dividend = divisor + a % divisor;
        NTC_PRECISE float estimate = float(dividend) / float(divisor);
        r[0] = NtcRoundQuotient(dividend, divisor, estimate);
    } else if (number == 8u) {
        uint size = (b & 0xFFFu) + 1u;
        NtcAxisTaps taps = NtcGetAxisTaps(asfloat(a), size, c % size, size - c % size);
        r[0] = uint(taps.first);
        r[1] = uint(taps.second);
        r[2] = asuint(taps.fraction);
        r[3] = uint(NtcQuantizeBilinearWeight(float(a >> 8) * (1.0f / 16777216.0f),
                                              float(b >> 8) * (1.0f / 16777216.0f)));
    } else if (number == 9u) {
        NtcNeuralMipConstants grid;
        grid.dataOffset = 0u;
        grid.imageWidthHeight = 0x03000400u;
        grid.sliceLeftTop = 0u;
        grid.sliceWidthHeight = c;
        r[0] = NtcIsGridPresent(grid) ? 1u : 0u;
        grid.sliceWidthHeight = 0x03000400u;
        NtcGridTaps taps = NtcGetGridTaps(grid, asfloat(a), asfloat(b));
        r[1] = taps.pixel0 ^ (taps.pixel1 << 3) ^ (taps.pixel2 << 6) ^ (taps.pixel3 << 9);
        r[2] = uint(taps.weight0) | (uint(taps.weight1) << 16);
        r[3] = uint(taps.weight2) | (uint(taps.weight3) << 16);
    } else if (number == 10u) {
        NtcLatentEncodingConstants encoding = desc.highResEncoding;
        r[0] = NtcLoadLatentCodes(CASE_LATENTS, 0u, encoding, a % 600u, 4u * (b % 3u));
        r[1] = uint(NtcMapLatent(a, b & 3u, encoding));
        r[2] = NtcWeightLatents(a, int(c % 257u), encoding);
        NtcGridTaps taps;
        taps.pixel0 = 0u;
        taps.pixel1 = 0u;
        taps.pixel2 = 0u;
        taps.pixel3 = 0u;
        taps.weight0 = int(d & 63u);
        taps.weight1 = int((d >> 6) & 63u);
        taps.weight2 = int((d >> 12) & 63u);
        taps.weight3 = int((d >> 18) & 63u);
        r[3] = NtcBlendLatents(a, b, c, d, taps, desc.lowResEncoding);
    } else if (number == 11u) {
        r[0] = uint(NtcGetTextureMipLevels(desc));
        int2 size = NtcGetTextureDimensions(desc, int(a % 40u) - 10);
        r[1] = uint(size.x) | (uint(size.y) << 16);
        r[2] = NtcGetValidChannelMask(desc);
        r[3] = NtcTextureSetHasChannels(desc, b >> 24) ? 1u : 0u;
    } else if (number == 12u) {
        uint inputs[NTC_MAX_INPUT_WORDS];
        for (uint i = 0u; i < uint(NTC_MAX_INPUT_WORDS); i++)
            inputs[i] = 7u;
        r[0] = NtcPrepareNetworkInputs(CASE_NETWORK desc, CASE_LATENTS, 0u,
                                       int2(int(a % 80u) - 20, int(b % 100u) - 20), int(c % 9u) - 2, inputs)
                   ? 1u
                   : 0u;
        r[1] = inputs[d % 20u];
        r[2] = inputs[(d >> 8) % 20u];
        r[3] = inputs[(d >> 16) % 20u];
    } else if (number == 13u) {
        float outputs[NTC_MAX_CHANNELS];
        for (uint k = 0u; k < uint(NTC_MAX_CHANNELS); k++)
            outputs[k] = 5.0f;
        r[0] =
            NtcSampleTextureSet(CASE_MODE desc, CASE_LATENTS, 0u, CASE_WEIGHTS, 0u,
                                int2(int(a % 80u) - 20, int(b % 100u) - 20), int(c % 9u) - 2, false, outputs)
                ? 1u
                : 0u;
        r[1] = asuint(outputs[d & 15u]);
        r[2] = asuint(outputs[(d >> 8) & 15u]);
        r[3] = asuint(outputs[(d >> 16) & 15u]);
    } else if (number == 14u) {
        uint x[NTC_MAX_INPUT_WORDS];
        for (uint w = 0u; w < uint(NTC_MAX_INPUT_WORDS); w++)
            x[w] = a * (2u * w + 1u) ^ b;
        NtcLayerOffsets offsets = NtcGetLayerOffsets(desc);
        NtcLayer layer = NtcGetLayer(NTC_NETWORK_SMALL, 0u, offsets, 1u);
        uint y[NTC_MAX_INPUT_WORDS];
        NtcEvaluateHiddenLayer(NTC_NETWORK_SMALL, NTC_MATH_INT8, CASE_WEIGHTS, layer, x, y);
        r[0] = y[c & 15u];
        NtcEvaluateHiddenLayer(NTC_NETWORK_SMALL, NTC_MATH_INT8_HALF, CASE_WEIGHTS, layer, x, y);
        r[1] = y[c & 15u];
        r[2] = asuint(NtcEvaluateRow(CASE_WEIGHTS, layer, d & 63u, x));
        layer = NtcGetLayer(NTC_NETWORK_SMALL, 0u, offsets, 3u);
        float outputs[NTC_MAX_CHANNELS];
        NtcEvaluateOutputLayer(NTC_NETWORK_SMALL, NTC_MATH_INT8_HALF, CASE_WEIGHTS, layer, x, outputs);
        r[3] = asuint(outputs[d & 15u]);
    } else if (number == 15u) { // colour maths: close, not equal
        r[0] = asuint(NtcDecodeSrgb(asfloat(a)));
        r[1] = asuint(NtcEncodeSrgb(asfloat(a)));
        r[2] = asuint(NtcDecodeHlg(asfloat(a)));
        r[3] = asuint(NtcEncodeHlg(asfloat(a)));
    } else if (number == 16u) {
        r[0] = asuint(NtcConvertToLinear(asfloat(a), int(b & 3u)));
        r[1] = asuint(NtcConvertFromLinear(asfloat(a), int(b & 3u)));
        r[2] = asuint(NtcConvertColorSpace(asfloat(a), int(b & 3u), int(b & 3u)));
        r[3] = asuint(
            NtcConvertChannelToLinearColorSpace(asfloat(a), int(c & 15u), (b & 3u) << (2u * (c & 15u))));
    }
}

NTC_NAMESPACE_END

#endif
