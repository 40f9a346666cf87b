// SPDX-License-Identifier: MIT
// Waves in C++: lanes run one after the other, each until it comes to an operation whose result is not known
// yet; when all have come there, the result is made and all start again. Says so if lanes come to different
// operations: control flow was not uniform. Included before the headers that need waves.
#pragma once

#include "openntc/Portability.h"

#include <array>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace openntc_filtering {

class WaveEmulator {
public:
    /// The emulator whose lane is running.
    static WaveEmulator*& GetCurrent() {
        static thread_local WaveEmulator* current = nullptr;
        return current;
    }

    /// Calls run(lane) as all lanes of a wave below `lanes` for which isActive(lane), which end at different
    /// operations only if that is what makes `findings`.
    template <typename IsActive, typename Run>
    void Execute(std::uint32_t lanes, IsActive isActive, Run run) {
        lanes_ = lanes;
        operations_.clear();
        std::vector<bool> isDone(lanes);
        for (std::uint32_t lane = 0; lane < lanes; ++lane)
            isDone[lane] = !isActive(lane);
        GetCurrent() = this;
        for (bool isAnyLeft = true; isAnyLeft;) {
            isAnyLeft = false;
            open_ = {};
            for (lane_ = 0; lane_ < lanes; ++lane_) {
                if (isDone[lane_])
                    continue;
                next_ = 0;
                try {
                    run(lane_);
                    isDone[lane_] = true;
                } catch (const Suspended&) {
                    isAnyLeft = true;
                }
            }
            if (isAnyLeft)
                operations_.push_back(open_);
        }
        GetCurrent() = nullptr;
        if (operations_.size() > most_)
            most_ = operations_.size();
    }

    std::uint32_t GetLane() const { return lane_; }
    std::uint32_t GetSize() const { return lanes_; }
    /// Empty as long as control flow was uniform and lanes read active lanes only.
    const std::string& GetFindings() const { return findings_; }
    std::size_t GetMostOperations() const { return most_; }

    openntc::shader::uint4 Ballot(bool vote) {
        const Operation& operation = Take('b', vote);
        std::uint32_t words[4] = {};
        for (std::uint32_t lane = 0; lane < lanes_; ++lane) {
            if (operation.isActive[lane] && operation.values[lane][0] != 0)
                words[lane / 32] |= 1u << (lane % 32);
        }
        return {words[0], words[1], words[2], words[3]};
    }
    int Min(int value) {
        const Operation& operation = Take('<', value);
        return Fold<int>(operation, [](int a, int b) { return a < b ? a : b; });
    }
    int Max(int value) {
        const Operation& operation = Take('>', value);
        return Fold<int>(operation, [](int a, int b) { return a > b ? a : b; });
    }
    std::uint32_t Or(std::uint32_t value) {
        const Operation& operation = Take('|', value);
        return Fold<std::uint32_t>(operation, [](std::uint32_t a, std::uint32_t b) { return a | b; });
    }
    template <typename T>
    T Read(T value, std::uint32_t from) {
        const Operation& operation = Take('r', value);
        if (from >= lanes_ || !operation.isActive[from]) {
            findings_ = "a lane that is not active is read";
            return value;
        }
        return Get<T>(operation, from);
    }

private:
    struct Suspended {};
    struct Operation {
        char kind = 0;
        std::array<bool, 128> isActive{};
        std::array<std::array<std::uint32_t, 4>, 128> values{};
    };

    template <typename T>
    static T Get(const Operation& operation, std::uint32_t lane) {
        T value;
        std::memcpy(&value, operation.values[lane].data(), sizeof(T));
        return value;
    }

    template <typename T, typename F>
    T Fold(const Operation& operation, F fold) const {
        T all = Get<T>(operation, lane_);
        for (std::uint32_t lane = 0; lane < lanes_; ++lane) {
            if (operation.isActive[lane])
                all = fold(all, Get<T>(operation, lane));
        }
        return all;
    }

    /// The operation that this lane has come to, if all others have been there.
    template <typename T>
    const Operation& Take(char kind, T value) {
        static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= 16);
        Operation& operation = next_ < operations_.size() ? operations_[next_] : open_;
        if (operation.kind != 0 && operation.kind != kind)
            findings_ =
                std::string("control flow is not uniform: ") + kind + " where others have " + operation.kind;
        if (next_++ < operations_.size())
            return operation;
        operation.kind = kind;
        operation.isActive[lane_] = true;
        std::memcpy(operation.values[lane_].data(), &value, sizeof(T));
        throw Suspended{};
    }

    std::uint32_t lanes_ = 0, lane_ = 0;
    std::size_t next_ = 0, most_ = 0;
    std::vector<Operation> operations_;
    Operation open_;
    std::string findings_;
};

} // namespace openntc_filtering

#define NtcWaveLane() ::openntc_filtering::WaveEmulator::GetCurrent()->GetLane()
#define NtcWaveSize() ::openntc_filtering::WaveEmulator::GetCurrent()->GetSize()
#define NtcWaveBallot(x) ::openntc_filtering::WaveEmulator::GetCurrent()->Ballot(x)
#define NtcWaveMin(x) ::openntc_filtering::WaveEmulator::GetCurrent()->Min(x)
#define NtcWaveMax(x) ::openntc_filtering::WaveEmulator::GetCurrent()->Max(x)
#define NtcWaveOr(x) ::openntc_filtering::WaveEmulator::GetCurrent()->Or(x)
#define NtcWaveRead(x, lane) ::openntc_filtering::WaveEmulator::GetCurrent()->Read(x, lane)
