#pragma once

#include "renderd/encode/encoder.h"
#include "renderd/encode/h264_device.h"

namespace diaphane::render {

/// H.264 by FFmpeg, for one viewer who waits for each picture: Annex B, 4:2:0, BT.709 limited range
/// said in the stream, no B frames, no look-ahead; sequence and picture parameter sets before each
/// key frame. Key frames come on request and when the size changes, never else.
///
/// Each quality aims at an even look (x264: constant rate factor 25 moving, 17 settled) and keeps
/// within EncodeRequest::most_bytes by a buffer (VBV) of one frame; a new bound needs no key frame
/// with x264, with NVENC one that differs by a quarter does. A picture with an odd side has one
/// column or row more in the stream, which its receiver cuts off.
Result<std::unique_ptr<Encoder>> make_h264_encoder(H264Device device);

}  // namespace diaphane::render
