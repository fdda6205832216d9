#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/config.h"
#include "common/result.h"

namespace diaphane::postgres {

/// Returns the connection settings that libpq would use: `url` (in either form), completed from the
/// service file and the environment (PGHOST, PGSSLMODE, PGSERVICE, ...), or kInvalid if libpq
/// cannot parse it. Call it before threads start, because it temporarily sets an environment
/// variable.
Result<std::map<std::string, std::string>> resolved(const std::string& url);

/// Returns kInvalid, with advice, if `url` leads to a remote host without TLS that verifies the
/// server's certificate. Unix sockets and loopback addresses count as local.
Result<void> may_be_used(const std::string& url, bool plain_allowed);

/// Reads the setting `postgres` and reports a mistake if the URL must not be used.
std::string read_url(ConfigReader& in, bool plain_allowed);

}  // namespace diaphane::postgres
