#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/session/state.h"

// Decides which picture is sent to whom, when, and in what size. Rules in the style of state.h.

namespace diaphane::render {

/// Updates the estimate of a receiver's connection and its quality. The presenter's plan also
/// applies to the renderer.
void update_quality(SessionState& state, Receiver& receiver, TimePoint now);

enum class Admission { kGo, kWait, kDrop };
struct Admitted {
  Admission admission = Admission::kDrop;
  bool key = false;  ///< the frame must be decodable without earlier ones
  // Size limits for a moving and for a settled frame, 0: none. Both are given, because a newer
  // picture may replace the requested one.
  std::uint32_t moving_bytes = 0;
  std::uint32_t settled_bytes = 0;
};
/// To be called before a picture is encoded for all receivers of `codec`. It is sent when the
/// presenter has room. If the presenter uses another codec, is disconnected or has stalled, it is
/// sent when any receiver has room. Receivers without room skip it. In an inter-coded stream, they
/// then wait for a key frame. kGo has reserved places in the takers' flight windows, which `depart`
/// or `release` must give back.
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
  /// Seconds, set when this frame is the first to answer an input.
  std::optional<double> input_to_frame;
};
/// Size and type of an encoded frame.
struct CodedSize {
  bool key = true;
  std::size_t bytes = 0;
};
/// To be called after encoding. Returns the takers for whom the frame is still useful.
OutgoingFrames depart(SessionState& state, diaphane::v1::Codec codec, const FrameInfo& frame,
                      CodedSize coded, TimePoint now);
/// To be called if the frame was not encoded after all.
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
/// have its frame, have room and lack tiles. Empty once a newer epoch has begun.
std::vector<TileDue> tiles_due(const SessionState& state, const FrameInfo& last,
                               std::uint32_t tiles, TimePoint now);
/// Marks a tile as sent. `state` is set after the last tile, when the viewer has the lossless
/// picture.
OutgoingFrame depart_tile(SessionState& state, const TileDue& due, std::uint32_t tiles,
                          std::size_t bytes, TimePoint now);

}  // namespace diaphane::render
