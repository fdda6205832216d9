#pragma once

#include "common/config.h"

namespace diaphane::api {

/// `diaphane-api admin grant|revoke EMAIL`, `admin list`: who is an administrator. Whoever may run
/// it on the machine decides; it is in the audit log. The exit code.
int run_admin(ConfigReader& in);

}  // namespace diaphane::api
