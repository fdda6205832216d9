#pragma once

#include "renderd/encode/encoder.h"

namespace diaphane::render {

/// JPEG by libjpeg-turbo, baseline. Moving: 4:2:0, quality 80. Settled: 4:4:4, quality 95. Over
/// EncodeRequest::most_bytes it is coded again at a lower quality, down to 25.
Result<std::unique_ptr<Encoder>> make_jpeg_encoder();

}  // namespace diaphane::render
