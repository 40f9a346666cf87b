// SPDX-License-Identifier: MIT
// Compute pass: a frame's feedback words to bytes (the finest mip wanted, 255: none), and a list of those
// that differ from the last ones. Clears the words that it finds touched.
//
// Bindings of set 0: 0 feedback words, 1 last bytes (four a word, the lowest first; 255 at first), 2 changes:
// NtcFeedbackChangesHead, then NtcFeedbackChange[capacity]. Write { 0, 0, capacity, 0 } to the head before.
// What does not fit keeps its last byte, and so comes again. Push constants: NtcResolveFeedbackConstants.
// Dispatch ceil(regionCount / (4 * NTC_RESOLVE_FEEDBACK_GROUP)) groups along x.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/streaming/StreamingConstants.h"
#include "openntc/streaming/TileMaths.h"

layout(local_size_x = NTC_RESOLVE_FEEDBACK_GROUP) in;

layout(set = 0, binding = 0, std430) buffer Feedback {
    uint words[];
} gFeedback;
layout(set = 0, binding = 1, std430) buffer LastBytes {
    uint words[];
} gLast;
layout(set = 0, binding = 2, std430) buffer Changes {
    NtcFeedbackChangesHead head;
    NtcFeedbackChange entries[];
} gChanges;
layout(push_constant) uniform ResolveFeedbackPush {
    NtcResolveFeedbackConstants gPush;
};

void main() {
    uint first = 4u * gl_GlobalInvocationID.x;
    if (first >= gPush.regionCount)
        return;
    uint place = (gPush.firstRegion + first) >> 2;
    uint before = gLast.words[place];
    uint after = before;
    NTC_LOOP for (uint k = 0u; k < 4u && first + k < gPush.regionCount; k++) {
        uint region = gPush.firstRegion + first + k;
        uint bits = gFeedback.words[gPush.feedbackWord + region];
        if (bits != 0u)
            gFeedback.words[gPush.feedbackWord + region] = 0u;
        uint mip = NtcGetFinestMip(bits);
        uint shift = 8u * k;
        if (mip != ((before >> shift) & 255u)) {
            uint entry = atomicAdd(gChanges.head.count, 1u);
            if (entry < gChanges.head.capacity) {
                gChanges.entries[entry].region = region;
                gChanges.entries[entry].mip = mip;
                after = (after & ~(255u << shift)) | (mip << shift);
            } else {
                atomicAdd(gChanges.head.dropped, 1u);
            }
        }
    }
    if (after != before)
        gLast.words[place] = after;
}
