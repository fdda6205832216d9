#include "common/service/core_files.h"

#include <sys/resource.h>

namespace diaphane::service {

void forbid_core_files() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);  // lowering one's own limit cannot fail
}

}  // namespace diaphane::service
