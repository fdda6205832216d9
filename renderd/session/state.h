#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/session/flight.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

using TimePoint = std::chrono::steady_clock::time_point;

/// All that is known of one session; plain data. The functions below are its only rules: they take
/// the time as an argument, lock nothing and send nothing, but say what is to be done.
struct SessionState {
  std::string id;
  std::string volume_id;
  std::uint64_t placement = 0;

  Wanted wanted;  ///< the newest accepted
  Wanted shown;   ///< the newest that the renderer took; what a refusal goes back to

  // Pictures.
  std::uint64_t epoch = 0;       ///< of what is rendered now
  std::uint64_t sent_epoch = 0;  ///< of the newest frame sent on this connection
  bool converged_told = false;

  // The connection, if any.
  bool attached = false;
  bool greeted = false;  ///< its Hello was accepted
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  std::uint64_t newest_input = 0;  ///< of this connection
  FlightWindow flight;
  TimePoint detached_since{};  ///< when not attached
  TimePoint heard_at{};        ///< last acknowledgement, or frame sent with none outstanding

  // An input whose picture was not sent yet: the oldest, for the latency that a person feels.
  std::uint64_t measured_input = 0;
  std::optional<TimePoint> measured_since;

  bool unsaved = false;  ///< the scene in Redis is older than `wanted`
};

/// What one event asks for.
struct Outcome {
  std::optional<diaphane::v1::Problem> problem;  ///< to be sent; a fatal one closes the connection
  bool configure = false;                        ///< Config is due
  bool wake = false;                             ///< the runner has something new to look at
  bool room = false;                             ///< the encoder may take the next picture
};

inline constexpr std::uint32_t kSmallestSide = 16;
inline constexpr std::uint32_t kLargestSide = 4096;
/// A viewer that acknowledges nothing for so long gets no more device time until it does.
inline constexpr std::chrono::seconds kStalledAfter{15};

/// A connection that says no Hello within this time is ended: it holds a slot for nothing.
inline constexpr std::chrono::seconds kGreetingWithin{10};

diaphane::v1::Problem problem_of(const Error& error, std::uint64_t input_seq, bool fatal);
/// kInvalid or kTooLarge, naming the side.
Result<Canvas> check_viewport(const diaphane::v1::Viewport& viewport);

/// A new connection takes the session; whatever the old one had under way counts no more.
void attach(SessionState& state, TimePoint now);
void detach(SessionState& state, TimePoint now);

/// Anything that a browser says. Nothing it says is trusted.
Outcome receive(SessionState& state, const diaphane::v1::ClientMessage& message, TimePoint now);

/// The renderer took or refused what was wanted.
void began(SessionState& state, std::uint64_t epoch, const Wanted& wanted);
Outcome refused(SessionState& state, const Wanted& wanted, const Error& why);

enum class Admission { kGo, kWait, kDrop };
/// Before encoding: goes, waits for room in its slot, or is of no use any more. kGo has taken a
/// place of the flight window, which `depart` or `FlightWindow::release` must give back.
Admission admit(SessionState& state, const FrameInfo& frame);
/// Before sending: false when the frame is of no use any more, or of another connection's codec.
bool still_useful(const SessionState& state, const FrameInfo& frame);

/// What leaves with a frame.
struct Departure {
  std::uint64_t seq = 0;
  std::optional<diaphane::v1::State> state;  ///< sent after the frame
  std::optional<double> input_to_frame;      ///< seconds, when this frame answers an input first
};
Departure depart(SessionState& state, const FrameInfo& frame, TimePoint now);

/// Attached, and silent for too long.
bool greeting_overdue(const SessionState& state, TimePoint now);

/// Whether a quantum for it would be of use to anybody.
bool watched(const SessionState& state, TimePoint now);

}  // namespace diaphane::render
