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
  kMoving,   ///< small and quick: it is on the screen for a moment
  kSettled,  ///< full chroma, no visible loss
};

struct EncodeRequest {
  Quality quality = Quality::kMoving;
  bool key = false;              ///< it must be decodable without any before it
  std::uint32_t most_bytes = 0;  ///< about so many, however it looks; 0: as many as it needs
};

struct CodedFrame {
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  bool key = true;
  Canvas size;  ///< to be shown: the picture's, or smaller where the codec has a largest side
  std::string data;
  std::string decoder;  ///< H264, of a key frame: what its decoder is configured with (RFC 6381)
};

/// Codes the pictures of one session, in order. It may keep state between pictures (a video codec's
/// references); sizes may change from one to the next. Used by one thread at a time.
class Encoder {
 public:
  virtual ~Encoder() = default;
  virtual Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) = 0;
};

/// kInternal when the pixels are not those of its size.
Result<void> check_picture(const PictureRgb8& picture);

/// Whether this process has it. Of H.264 the first call tries the encoders out, for some
/// milliseconds.
bool can_encode(diaphane::v1::Codec codec);

/// kUnsupported for a codec that this program does not have.
Result<std::unique_ptr<Encoder>> make_encoder(diaphane::v1::Codec codec);

}  // namespace diaphane::render
