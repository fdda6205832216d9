#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/session/state.h"

// Which picture goes to whom, when, and of what size; rules as those of state.h.

namespace diaphane::render {

/// What a receiver's connection carries, and what follows from it; the presenter's decides for the
/// renderer.
void update_quality(SessionState& state, Receiver& receiver, TimePoint now);

enum class Admission { kGo, kWait, kDrop };
struct Admitted {
  Admission admission = Admission::kDrop;
  bool key = false;  ///< the frame must be decodable without any before it
  // That the frame may have, 0: any number. Of a moving and of a settled one: a newer picture may
  // take the place of the one that was asked for.
  std::uint32_t moving_bytes = 0;
  std::uint32_t settled_bytes = 0;
};
/// Before a picture is coded for all who receive `codec`. It goes when the presenter has room, or,
/// where the presenter does not receive this codec, is away or has stalled, when anybody has. Who
/// has none skips it: of JPEG just so, of an inter-coded stream until a key frame. kGo has taken
/// places of the takers' flight windows, which `depart` or `release` must give back.
Admitted admit(SessionState& state, diaphane::v1::Codec codec, const FrameInfo& frame,
               TimePoint now);

/// A frame leaves for one receiver.
struct Departure {
  std::uint64_t connection = 0;
  std::uint64_t seq = 0;
  std::optional<diaphane::v1::State> state;  ///< sent after the frame
  bool look = false;                         ///< the scene is due too: Look, sent before the frame
};
struct Departures {
  std::vector<Departure> frames;
  std::optional<double> input_to_frame;  ///< seconds, when this frame answers an input first
};
/// A coded frame.
struct CodedSize {
  bool key = true;
  std::size_t bytes = 0;
};
/// After coding: for whom of the takers it is still of use.
Departures depart(SessionState& state, diaphane::v1::Codec codec, const FrameInfo& frame,
                  CodedSize coded, TimePoint now);
/// The frame was not made after all.
void release(SessionState& state, diaphane::v1::Codec codec);

/// Whether a picture for this codec would be admitted.
bool has_room(const SessionState& state, diaphane::v1::Codec codec, TimePoint now);

/// A tile of the lossless end that may leave for one receiver now.
struct TileDue {
  std::uint64_t connection = 0;
  std::uint32_t tile = 0;
  diaphane::v1::StillFormat format = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
};
/// Of the converged picture `last`, which has `tiles`: for those who have seen its frame, have room
/// and lack tiles. Nothing once a newer epoch has begun.
std::vector<TileDue> tiles_due(const SessionState& state, const FrameInfo& last,
                               std::uint32_t tiles, TimePoint now);
/// A tile leaves. `state`: it was the last, and the viewer has the lossless picture.
Departure depart_tile(SessionState& state, const TileDue& due, std::uint32_t tiles,
                      std::size_t bytes, TimePoint now);

}  // namespace diaphane::render
