#pragma once

#include "api/redis/script.h"

namespace diaphane::api::redis {

/// observe/fleets.lua, embedded when it was built.
extern const Script kFleets;

}  // namespace diaphane::api::redis
