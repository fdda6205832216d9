#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/session/audience.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

/// All that is known of one session; plain data. The functions below are its only rules: they take
/// the time as an argument, lock nothing and send nothing, but say what is to be done.
struct SessionState {
  std::string id;
  std::string volume_id;
  std::uint64_t placement = 0;
  std::vector<diaphane::v1::Codec> codecs{diaphane::v1::JPEG};  ///< that can be made here

  Wanted wanted;            ///< the newest accepted
  Wanted shown;             ///< the newest that the renderer took; what a refusal goes back to
  std::uint64_t epoch = 0;  ///< of what is rendered now

  Audience audience;
  TimePoint detached_since{};  ///< when nobody is connected

  // An input whose picture was not sent yet: the oldest, for the latency that a person feels.
  std::uint64_t measured_input = 0;
  std::optional<TimePoint> measured_since;

  /// One follower's own: of his scenes the camera alone counts, the rest is the presenter's.
  bool camera_only = false;
  bool unsaved = false;  ///< what Redis has is older than scene and presenter here
};

/// What one event asks for. `problem`, `configure` and `own_camera` concern the connection that
/// caused it.
struct Outcome {
  std::optional<diaphane::v1::Problem> problem;  ///< to be sent; a fatal one closes the connection
  bool configure = false;                        ///< Config is due
  bool audience = false;                         ///< everybody is to be told who is here
  bool presenter = false;                        ///< the presenter is to be told the scene (Look)
  std::optional<bool> own_camera;  ///< a camera of its own is asked for, or given back
  bool wake = false;               ///< the runner has something new to look at
  bool room = false;               ///< the encoders may take the next picture
};

inline constexpr std::uint32_t kSmallestSide = 16;
inline constexpr std::uint32_t kLargestSide = 4096;

diaphane::v1::Problem problem_of(const Error& error, std::uint64_t input_seq, bool fatal);
/// kInvalid or kTooLarge, naming the side.
Result<Canvas> check_viewport(const diaphane::v1::Viewport& viewport);

/// Who connects.
struct Arrival {
  std::string participant{kOwner};
  std::string name;  ///< as typed
  std::string link;
};
struct Attached {
  std::uint64_t connection = 0;
  std::optional<std::uint64_t> replaced;  ///< the same participant's connection before
};
/// kTooMany: kMostReceivers are here.
Result<Attached> attach(SessionState& state, const Arrival& arrival, TimePoint now);
/// What was under way to it counts no more. Nobody by that number: nothing happens.
void detach(SessionState& state, std::uint64_t connection, TimePoint now);

/// A follower goes to a camera of his own, or comes back and is sent everything anew.
void use_own_camera(SessionState& state, Receiver& receiver, bool on, TimePoint now);
/// Of a session with `camera_only`: the presenter's settings have changed.
void follow(SessionState& state, const diaphane::v1::Scene& presenters, TimePoint now);

/// Anything that a browser says. Nothing it says is trusted.
Outcome receive(SessionState& state, std::uint64_t connection,
                const diaphane::v1::ClientMessage& message, TimePoint now);

/// The renderer took or refused what was wanted. The Problem is the presenter's.
void began(SessionState& state, std::uint64_t epoch, const Wanted& wanted);
Outcome refused(SessionState& state, const Wanted& wanted, const Error& why);

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

/// Connections that were silent for too long.
std::vector<std::uint64_t> overdue_greetings(const SessionState& state, TimePoint now);

/// Whether a quantum for it would be of use to anybody.
bool watched(const SessionState& state, TimePoint now);

}  // namespace diaphane::render
