#pragma once

#include "renderd/encode/encoder.h"

namespace diaphane::render {

/// Creates an MPEG-1 video encoder (FFmpeg) that writes an elementary stream for jsmpeg: nominally
/// 30 frames per second, no B frames, and a sequence header with the size before each key frame.
/// Key frames are sent on request, when the size changes, and every 600 frames. MPEG-1 cannot
/// signal matrix and range, so the stream uses those that jsmpeg assumes: BT.601, limited range.
/// Sides are at most 4094 pixels. A larger picture is scaled down and CodedFrame gives the new
/// size. Odd sides are handled as in H.264. Returns kUnsupported if FFmpeg has no MPEG-1 encoder,
/// and kOutOfMemory.
Result<std::unique_ptr<Encoder>> make_mpeg1_encoder();

/// Returns the quantiser (1 to 31) for the next frame after a frame with quantiser `before` took
/// `bytes`. The limit is `most` (0: none), and `best` is the quantiser of the desired quality.
/// Pure.
int next_quantiser(int before, std::size_t bytes, std::size_t most, int best);

}  // namespace diaphane::render
