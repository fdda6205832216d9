#pragma once

#include "common/config.h"

namespace diaphane::api {

/// Runs `diaphane-api admin grant|revoke EMAIL`, `admin list` or `admin reset-2fa EMAIL`. Anyone
/// who can run it on the server is authorised. Changes are recorded in the audit log. Returns the
/// exit code.
int run_admin(ConfigReader& in);

}  // namespace diaphane::api
