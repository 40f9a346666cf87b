// SPDX-License-Identifier: MIT
// Hostile GDeflate streams, from buffers of exactly their size: an error, or exactly as many bytes as the stream says.
// Whoever reads or writes beyond a buffer is found by AddressSanitizer.
//   OPENNTC_FUZZ_SEED=N, OPENNTC_FUZZ_COUNT=N   as in fuzz_test.cpp
#include "fuzz/JsonMutator.h"
#include "openntc/container/GDeflateEncoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::container;

namespace {

using Bytes = std::vector<std::byte>;

/// Small streams with a stored, a static and a dynamic tile, and one of two tiles.
const std::vector<Bytes>& GetGDeflateBases() {
    static const std::vector<Bytes> bases = [] {
        std::vector<Bytes> made;
        fuzz::Random random(1);
        for (const std::size_t size :
             {std::size_t{40}, std::size_t{41}, std::size_t{600}, std::size_t{66000}}) {
            Bytes data(size);
            for (std::size_t i = 0; i < size; ++i) {
                const std::size_t value = size == 40   ? random.Below(256)
                                          : size == 41 ? i % 3
                                                       : random.Below(9);
                data[i] = static_cast<std::byte>(i % 40 < 20 ? value : 7);
            }
            GDeflateEncoder encoder(4);
            Array<std::byte> stream;
            REQUIRE(encoder.Compress(data, stream));
            made.emplace_back(stream.begin(), stream.end());
        }
        return made;
    }();
    return bases;
}

/// False if a promise was broken.
bool TryDecompress(std::span<const std::byte> stream) {
    const auto input = std::make_unique<std::byte[]>(stream.size());
    std::copy(stream.begin(), stream.end(), input.get());
    const std::span<const std::byte> exact(input.get(), stream.size());
    const Expected<GDeflateHeader> header = DecodeGDeflateHeader(exact);
    constexpr std::uint64_t kRoom = 4 * kGDeflateTileBytes;
    const std::uint64_t room = header ? std::min(header->GetBytes(), kRoom) : 1;
    const auto output = std::make_unique<std::byte[]>(static_cast<std::size_t>(room));
    const Expected<std::size_t> size =
        DecompressGDeflate(exact, {output.get(), static_cast<std::size_t>(room)});
    if (!size)
        return std::string_view(size.error().GetText()).find("GDeflate: ") == 0;
    return header && *size == header->GetBytes();
}

std::uint64_t ReadNumber(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

} // namespace

TEST_CASE("fuzz gdeflate: every prefix, and every value of every byte, of small streams") {
    for (const Bytes& base : GetGDeflateBases()) {
        const std::size_t step = base.size() > 4096 ? 97 : 1;
        CAPTURE(base.size());
        for (std::size_t length = 0; length <= base.size(); length += step)
            REQUIRE(TryDecompress(std::span(base).first(length)));
        if (base.size() > 4096)
            continue;
        Bytes changed = base;
        for (std::size_t at = 0; at < base.size(); ++at) {
            for (unsigned change = 1; change < 256; ++change) {
                changed[at] = base[at] ^ static_cast<std::byte>(change);
                CAPTURE(at);
                REQUIRE(TryDecompress(changed));
            }
            changed[at] = base[at];
        }
    }
}

TEST_CASE("fuzz gdeflate: mutations") {
    const auto now = std::chrono::system_clock::now().time_since_epoch().count();
    const std::uint64_t seed = ReadNumber("OPENNTC_FUZZ_SEED", static_cast<std::uint64_t>(now) % 1000000007u);
    const std::uint64_t count = ReadNumber("OPENNTC_FUZZ_COUNT", 200000) / 10;
    MESSAGE("OPENNTC_FUZZ_SEED=" << seed);
    std::size_t accepted = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        fuzz::Random random(seed + i);
        Bytes stream = GetGDeflateBases()[random.Below(GetGDeflateBases().size())];
        for (std::size_t n = random.Below(6); n > 0; --n)
            stream[random.Below(4) == 0 ? random.Below(24) : random.Below(stream.size())] =
                static_cast<std::byte>(random.Below(256));
        if (random.Below(8) == 0)
            stream.resize(random.Below(stream.size()));
        CAPTURE(seed + i);
        REQUIRE(TryDecompress(stream));
        accepted += DecodeGDeflateHeader(stream) ? 1 : 0;
    }
    CHECK(accepted > count / 3); // they must not all die at the door
}
