#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/session/state.h"

// Decides which picture is sent to which viewer, when and in what size. The functions take the time
// as an argument, lock nothing and send nothing, like those of state.h.

namespace diaphane::render {

/// Updates the estimate of a receiver's connection and its quality. The presenter's plan also
/// limits the size at which moving pictures are rendered.
void update_quality(SessionState& state, Receiver& receiver, TimePoint now);

enum class Admission { kGo, kWait, kDrop };
struct Admitted {
  Admission admission = Admission::kDrop;
  bool key = false;  ///< the frame must be decodable without earlier ones
  // Maximum bytes of a moving and of a settled frame; 0: unlimited. Both are set, because a newer
  // picture of the other kind may replace the requested one before it is encoded.
  std::uint32_t moving_bytes = 0;
  std::uint32_t settled_bytes = 0;
};
/// Decides whether a picture is encoded now for all receivers of `codec`: as soon as the presenter
/// has room or, if the presenter uses another codec, is disconnected or has stalled, as soon as any
/// receiver has room. Receivers without room skip the picture. In an inter-coded stream, they then
/// wait for a key frame. kGo has reserved places in the takers' flight windows, which `depart` or
/// `release` must give back.
Admitted admit(SessionState& state, diaphane::v1::Codec codec, const FrameInfo& frame,
               TimePoint now);

/// A frame that is sent to one receiver.
struct OutgoingFrame {
  std::uint64_t connection = 0;
  std::uint64_t seq = 0;
  std::optional<diaphane::v1::State> state;  ///< to be sent after the frame
  bool look = false;  ///< whether the scene is to be sent before the frame (Look)
};
struct OutgoingFrames {
  std::vector<OutgoingFrame> frames;
  /// Latency in seconds, set if this frame is the first to answer an input.
  std::optional<double> input_to_frame;
};
/// Size and type of an encoded frame.
struct CodedSize {
  bool key = true;
  std::size_t bytes = 0;
};
/// Records that an encoded frame is sent. Returns the takers for whom it is still useful.
OutgoingFrames depart(SessionState& state, diaphane::v1::Codec codec, const FrameInfo& frame,
                      CodedSize coded, TimePoint now);
/// Gives back the reserved places of a frame that was not encoded after all.
void release(SessionState& state, diaphane::v1::Codec codec);

/// Returns whether a picture for this codec would be admitted.
bool has_room(const SessionState& state, diaphane::v1::Codec codec, TimePoint now);

/// A lossless tile that may be sent to one receiver now.
struct TileDue {
  std::uint64_t connection = 0;
  std::uint32_t tile = 0;
  diaphane::v1::StillFormat format = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
};
/// Returns due tiles of the converged picture `last`, which has `tiles` tiles, for receivers that
/// have its frame, have room and lack tiles. Returns none once a newer epoch has begun.
std::vector<TileDue> tiles_due(const SessionState& state, const FrameInfo& last,
                               std::uint32_t tiles, TimePoint now);
/// Marks a tile as sent. `state` is set after the last tile, when the viewer has the lossless
/// picture.
OutgoingFrame depart_tile(SessionState& state, const TileDue& due, std::uint32_t tiles,
                          std::size_t bytes, TimePoint now);

}  // namespace diaphane::render
