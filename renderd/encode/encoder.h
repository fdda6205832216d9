#pragma once

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
  bool key = false;  ///< the next frame must be decodable without any before it
};

struct CodedFrame {
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  bool key = true;
  std::string data;
};

/// Codes the pictures of one session, in order. It may keep state between pictures (a video codec's
/// references); sizes may change from one to the next. Used by one thread at a time.
class Encoder {
 public:
  virtual ~Encoder() = default;
  virtual Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) = 0;
};

/// kUnsupported for a codec that this program does not have.
Result<std::unique_ptr<Encoder>> make_encoder(diaphane::v1::Codec codec);

}  // namespace diaphane::render
