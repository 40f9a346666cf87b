// SPDX-License-Identifier: MIT
// Stability: experimental
// What a call of DemandLoader::ProcessRequests began, to be looked at or waited for.
#pragma once

#include "openntc/core/Shared.h"
#include "openntc/streaming/detail/Threads.h"

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {

struct TicketState {
    Mutex mutex;
    Condition done;
    std::uint32_t tasks = 0;
    std::uint32_t remaining = 0;
    std::uint32_t failed = 0;

    void Add() noexcept {
        const Lock lock(mutex);
        ++tasks;
        ++remaining;
    }
    void Finish(bool isFailure) noexcept {
        const Lock lock(mutex);
        failed += isFailure ? 1 : 0;
        if (--remaining == 0)
            done.NotifyAll();
    }
};

} // namespace detail

/// The reads that one call began. May be copied, waited for by several threads, and dropped at any time; it
/// stays valid when its loader is gone, and then has ended. An empty ticket has ended.
class DemandTicket {
public:
    DemandTicket() noexcept = default;

    /// Tiles and pages whose reading began with the call, those coarser ones included that were not asked
    /// for.
    std::uint32_t GetTaskCount() const noexcept { return Look(&detail::TicketState::tasks); }
    /// How many have not ended. A task ends with its data in host memory, with an error, with the answer
    /// "later", or because its texture or loader went away.
    std::uint32_t GetRemainingCount() const noexcept { return Look(&detail::TicketState::remaining); }
    /// How many ended with an error.
    std::uint32_t GetFailedCount() const noexcept { return Look(&detail::TicketState::failed); }
    bool IsDone() const noexcept { return GetRemainingCount() == 0; }

    /// Waits until every task has ended; the next LaunchPrepare then shows the tiles. A source that never
    /// answers makes this wait until the loader is aborted.
    void Wait() const {
        if (!state_)
            return;
        detail::Lock lock(state_->mutex);
        state_->done.Wait(lock, [&] { return state_->remaining == 0; });
    }
    /// The same for at most `milliseconds`; false if tasks remain.
    bool WaitFor(int milliseconds) const {
        if (!state_)
            return true;
        detail::Lock lock(state_->mutex);
        return state_->done.WaitFor(lock, milliseconds, [&] { return state_->remaining == 0; });
    }

private:
    friend class DemandLoader;
    explicit DemandTicket(Shared<detail::TicketState> state) noexcept : state_(std::move(state)) {}

    std::uint32_t Look(std::uint32_t detail::TicketState::*field) const noexcept {
        if (!state_)
            return 0;
        const detail::Lock lock(state_->mutex);
        return state_.Get()->*field;
    }

    Shared<detail::TicketState> state_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
