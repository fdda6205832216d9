#include "common/service/drain.h"

#include <cstdlib>

#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/signals.h"

namespace diaphane::service {

void drain_on_stop(StopSignal& stop, AdminServer& admin, const std::function<void()>& drain) {
  stop.wait();
  log::info("draining");
  admin.set_draining();
  drain();
  log::info("stopped");
  std::quick_exit(0);
}

}  // namespace diaphane::service
