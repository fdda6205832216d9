#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

enum class Quality {
  kMoving,   ///< small and quick, because it is shown only briefly
  kSettled,  ///< full chroma, no visible loss
};

struct EncodeRequest {
  Quality quality = Quality::kMoving;
  bool key = false;              ///< decodable without any earlier frame
  std::uint32_t most_bytes = 0;  ///< approximate maximum, whatever the quality; 0: no limit
};

struct CodedFrame {
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  bool key = true;
  Canvas size;  ///< size to show: the picture's, or smaller if the codec limits sides
  std::string data;
  std::string decoder;  ///< configuration for the decoder (RFC 6381), with each key frame of H264
};

/// Encodes the pictures of one session in order. It may keep state between pictures, such as a
/// video codec's references. Sizes may change between pictures. Not thread-safe.
class Encoder {
 public:
  virtual ~Encoder() = default;
  /// Returns kInternal if the picture is malformed or the codec fails, kUnsupported if the codec
  /// cannot be opened for this size, and kOutOfMemory.
  virtual Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) = 0;
};

/// Fails with kInternal if the number of pixels does not match the size.
Result<void> check_picture(const PictureRgb8& picture);

/// Returns whether this process supports the codec. For H.264, the first call tests the encoders,
/// which takes some milliseconds.
bool can_encode(diaphane::v1::Codec codec);

/// Creates an encoder. Fails with kUnsupported for a codec that this program does not support.
Result<std::unique_ptr<Encoder>> make_encoder(diaphane::v1::Codec codec);

}  // namespace diaphane::render
