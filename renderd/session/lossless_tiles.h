#pragma once

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "renderd/session/effects.h"
#include "renderd/session/events.h"
#include "renderd/session/pictures.h"

namespace diaphane::render {

/// A picture that is not refined further.
struct PictureFinished {
  const FrameInfo& info;
  const PictureRgb8& picture;
  std::uint32_t tiles = 0;
};
struct EpochBegan {};
struct TileCoded {
  std::uint64_t picture = 0;
  std::uint32_t tile = 0;
  /// The tile's place, format and data; nullopt: it could not be encoded.
  std::optional<diaphane::v1::Still> coded;
};
/// A viewer may have room for another tile.
struct RoomForTiles {};

/// The lossless tiles of a session's converged picture. Each is encoded once for all receivers,
/// when the first of them is about to need it.
class LosslessTiles {
 public:
  Effects handle(const PictureFinished& event, const SessionState& state);
  Effects handle(EpochBegan event);
  Effects handle(TileCoded event, SessionState& state, TimePoint now);
  Effects handle(RoomForTiles event, SessionState& state, TimePoint now);

 private:
  using Key = std::pair<diaphane::v1::StillFormat, std::uint32_t>;
  /// The converged picture of the current epoch.
  struct Last {
    std::uint64_t id = 0;
    FrameInfo info;
    std::shared_ptr<const PictureRgb8> picture;
    std::uint32_t tiles = 0;
    std::map<Key, std::optional<diaphane::v1::Still>> coded;  // nullopt: being encoded
    bool failed = false;  // a tile could not be encoded, so there will be no lossless picture
  };
  /// Returns an encoded tile, or null while it is being encoded.
  const diaphane::v1::Still* get(const Key& key, Effects& effects);

  std::optional<Last> last_;
  std::uint64_t pictures_ = 0;  // number of pictures so far, from which ids are made
};

}  // namespace diaphane::render
