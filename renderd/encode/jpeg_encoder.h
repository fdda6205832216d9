#pragma once

#include "renderd/encode/encoder.h"

namespace diaphane::render {

/// JPEG by libjpeg-turbo, baseline. Moving: 4:2:0, quality 80. Settled: 4:4:4, quality 95.
Result<std::unique_ptr<Encoder>> make_jpeg_encoder();

}  // namespace diaphane::render
