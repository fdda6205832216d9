#pragma once

#include "directory/workers.h"

namespace diaphane::api {

using directory::WorkerInfo;
using directory::Workers;

}  // namespace diaphane::api
