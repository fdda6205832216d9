#pragma once

#include "renderd/session/view_request.h"

namespace diaphane::render {

/// The old name, which the runner still uses.
using Wanted = ViewRequest;

}  // namespace diaphane::render
