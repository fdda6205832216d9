#pragma once

#include <chrono>

namespace diaphane::api {

using Time = std::chrono::system_clock::time_point;

}  // namespace diaphane::api
