#pragma once

#include "renderd/encode/encoder.h"

namespace diaphane::render {

/// Creates a baseline JPEG encoder (libjpeg-turbo). Moving: 4:2:0, quality 80. Settled: 4:4:4,
/// quality 95. A picture larger than EncodeRequest::most_bytes is encoded again at a lower quality,
/// down to 25. Returns kOutOfMemory.
Result<std::unique_ptr<Encoder>> make_jpeg_encoder();

}  // namespace diaphane::render
