#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/config.h"
#include "common/result.h"

namespace diaphane::postgres {

/// A connection as libpq would make it: `url` (either form), filled up from the service file and
/// the environment (PGHOST, PGSSLMODE, PGSERVICE, ...). kInvalid: libpq cannot read it. Call it
/// before threads start: it sets an environment variable for a moment.
Result<std::map<std::string, std::string>> resolved(const std::string& url);

/// kInvalid, and in words what to do, where `url` leads to another machine without TLS that checks
/// the server's certificate. A Unix socket and the loopback addresses are this machine.
Result<void> may_be_used(const std::string& url, bool plain_allowed);

/// Setting `postgres`, with a mistake where it must not be used.
std::string read_url(ConfigReader& in, bool plain_allowed);

}  // namespace diaphane::postgres
