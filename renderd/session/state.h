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
  std::optional<diaphane::v1::DepthQuery> depth;  ///< to be answered
  bool wake = false;                              ///< the runner has something new to look at
  bool room = false;                              ///< the encoders may take the next picture
};

inline constexpr std::uint32_t kSmallestSide = 16;
inline constexpr std::uint32_t kLargestSide = 4096;
inline constexpr double kSmallestMovingScale = 0.1;

diaphane::v1::Problem problem_of(const Error& error, std::uint64_t input_seq, bool fatal);
/// kInvalid, naming the field.
Result<Effort> check_effort(const diaphane::v1::Effort& effort);
/// kInvalid or kTooLarge, naming the side.
Result<Canvas> check_viewport(const diaphane::v1::Viewport& viewport);

/// Who connects.
struct Arrival {
  std::string participant{kOwner};
  std::string name;  ///< as typed
  std::string link;
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;
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

/// Whether the connection may say this at all, as the table of rights has it (rights.h): asked
/// before anything else looks at a message. The Problem that refuses it, or nothing.
std::optional<diaphane::v1::Problem> refused_request(const SessionState& state,
                                                     std::uint64_t connection,
                                                     const diaphane::v1::ClientMessage& message);

/// Anything that a browser says. Nothing it says is trusted.
Outcome receive(SessionState& state, std::uint64_t connection,
                const diaphane::v1::ClientMessage& message, TimePoint now);

/// The renderer took or refused what was wanted. The Problem is the presenter's.
void began(SessionState& state, std::uint64_t epoch, const Wanted& wanted);
Outcome refused(SessionState& state, const Wanted& wanted, const Error& why);

/// Connections that were silent for too long.
std::vector<std::uint64_t> overdue_greetings(const SessionState& state, TimePoint now);

/// Whether a quantum for it would be of use to anybody.
bool watched(const SessionState& state, TimePoint now);

}  // namespace diaphane::render
