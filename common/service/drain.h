#pragma once

#include <functional>

namespace diaphane::service {

class AdminServer;
class StopSignal;

/// Waits for `stop`, makes /readyz return 503, calls `drain` and exits with code 0. `drain` must
/// finish or end everything that runs, because no destructor is called: closing the admin server
/// takes up to two more seconds, which the process manager may not allow.
[[noreturn]] void drain_on_stop(StopSignal& stop, AdminServer& admin,
                                const std::function<void()>& drain);

}  // namespace diaphane::service
