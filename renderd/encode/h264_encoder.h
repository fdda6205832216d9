#pragma once

#include "renderd/encode/encoder.h"
#include "renderd/encode/h264_device.h"

namespace diaphane::render {

/// Creates an H.264 encoder (FFmpeg) for a viewer who waits for each picture: Annex B, 4:2:0,
/// BT.709 limited range signalled in the stream, without B frames or look-ahead, and with sequence
/// and picture parameter sets before each key frame. Key frames are sent only on request and when
/// the size changes.
///
/// Each quality aims at a constant look (x264: constant rate factor 25 moving, 17 settled) and
/// keeps within EncodeRequest::most_bytes by a buffer (VBV) of one frame. With NVENC, a limit that
/// differs by a quarter needs a key frame. With x264, none does. A picture with an odd side has one
/// more column or row in the stream, which the receiver crops. Returns kUnsupported if FFmpeg has
/// no encoder for `device`, and kOutOfMemory.
Result<std::unique_ptr<Encoder>> make_h264_encoder(H264Device device);

}  // namespace diaphane::render
