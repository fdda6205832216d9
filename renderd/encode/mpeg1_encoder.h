#pragma once

#include "renderd/encode/encoder.h"

namespace diaphane::render {

/// MPEG-1 video by FFmpeg as an elementary stream, for jsmpeg: 30 frames a second by name, no B
/// frames, a sequence header with the size before each key frame. Key frames come on request, when
/// the size changes, and each 600 frames. MPEG-1 can say neither matrix nor range: they are those
/// that jsmpeg assumes, BT.601 limited. Sides are at most 4094 pixels: a larger
/// picture is scaled down, and CodedFrame says so. Odd sides as with H.264.
Result<std::unique_ptr<Encoder>> make_mpeg1_encoder();

/// The quantiser (1 to 31) for the next frame, after one with quantiser `before` took `bytes`,
/// where it may take `most` (0: as many as it likes) and would look as it should with `best`. Pure.
int next_quantiser(int before, std::size_t bytes, std::size_t most, int best);

}  // namespace diaphane::render
