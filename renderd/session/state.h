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
#include "renderd/session/view_request.h"

namespace diaphane::render {

/// The complete state of one session as plain data. Its rules are the functions below and those of
/// pictures.h. They take the time as an argument, lock nothing and send nothing, but return what is
/// to be done.
struct SessionState {
  std::string id;
  std::string volume_id;
  std::uint64_t placement = 0;
  std::vector<diaphane::v1::Codec> codecs{diaphane::v1::JPEG};  ///< codecs of this worker

  ViewRequest requested;  ///< the newest accepted request
  /// The newest request that the renderer accepted, which is restored after a refusal.
  ViewRequest shown;
  std::uint64_t epoch = 0;  ///< epoch of the current picture

  Audience audience;
  TimePoint detached_since{};  ///< valid while no viewer is connected

  // The oldest input whose picture was not sent yet, for measuring the latency that users
  // experience.
  std::uint64_t measured_input = 0;
  std::optional<TimePoint> measured_since;

  /// Whether this is the session of a follower's free camera. The follower's scenes then set only
  /// the camera, and the rest is the presenter's.
  bool camera_only = false;
  bool unsaved = false;  ///< Redis has an older scene or presenter
};

/// The actions that an event requires. `problem`, `configure` and `free_camera` concern the
/// connection that caused it.
struct Outcome {
  std::optional<diaphane::v1::Problem> problem;  ///< to be sent; a fatal one closes the connection
  bool configure = false;                        ///< send Config
  bool audience = false;                         ///< send the list of participants to everyone
  bool presenter = false;                        ///< send the scene to the presenter (Look)
  std::optional<bool> free_camera;  ///< a free camera was requested (true) or given up (false)
  std::optional<diaphane::v1::DepthQuery> depth;  ///< to be answered
  bool error_curve = false;                       ///< send the error curve
  bool good_views = false;                        ///< send good views of the scene
  bool wake = false;                              ///< wake the runner
  bool room = false;                              ///< the encoders may take the next picture
};

inline constexpr std::uint32_t kSmallestSide = 16;
inline constexpr std::uint32_t kLargestSide = 4096;
inline constexpr double kSmallestMovingScale = 0.1;

diaphane::v1::Problem problem_of(const Error& error, std::uint64_t input_seq, bool fatal);
/// Converts a viewer's limits. Fails with kInvalid, naming the field.
Result<Effort> check_effort(const diaphane::v1::Effort& effort);
/// Converts the size of a page's picture. Fails with kInvalid or kTooLarge, naming the side.
Result<Canvas> check_viewport(const diaphane::v1::Viewport& viewport);
/// Maximum pixels of a visitor's picture: those of 2560 x 1440.
inline constexpr double kMostVisitorPixels = 2560.0 * 1440.0;
/// Returns the size of a visitor's picture in this viewport: the same shape, reduced if the
/// viewport has more than kMostVisitorPixels. The page scales it up.
Canvas visitor_canvas(Canvas viewport);

/// The viewer of a new connection.
struct JoinRequest {
  std::string participant{kOwner};
  std::string name;  ///< the name as entered
  std::string link;
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;
  bool may_download = false;
};
struct Attached {
  std::uint64_t connection = 0;
  std::optional<std::uint64_t> replaced;  ///< the participant's previous connection
};
/// Adds a connection. Fails with kTooMany if there are kMostReceivers already.
Result<Attached> attach(SessionState& state, const JoinRequest& join, TimePoint now);
/// Removes a connection and its messages in transit. Ignores unknown numbers.
void detach(SessionState& state, std::uint64_t connection, TimePoint now);

/// Switches a follower to their free camera, or back to the group, in which case everything is sent
/// again.
void use_free_camera(SessionState& state, Receiver& receiver, bool on, TimePoint now);
/// Applies the presenter's new settings to a session with `camera_only`.
void follow(SessionState& state, const diaphane::v1::Scene& presenters, TimePoint now);

/// Checks a request against the table of rights (rights.h) before anything else reads the message.
/// Returns the Problem that refuses it, or nullopt.
std::optional<diaphane::v1::Problem> refused_request(const SessionState& state,
                                                     std::uint64_t connection,
                                                     const diaphane::v1::ClientMessage& message);

/// Handles any message of a browser. Messages are untrusted.
Outcome receive(SessionState& state, std::uint64_t connection,
                const diaphane::v1::ClientMessage& message, TimePoint now);

/// Records that the renderer accepted or refused the requested scene. The Problem of a refusal is
/// sent to the presenter.
void began(SessionState& state, std::uint64_t epoch, const ViewRequest& requested);
Outcome refused(SessionState& state, const ViewRequest& requested, const Error& why);

/// Returns connections that have not sent a greeting in time.
std::vector<std::uint64_t> overdue_greetings(const SessionState& state, TimePoint now);

/// Returns whether any viewer would benefit from further rendering.
bool watched(const SessionState& state, TimePoint now);

}  // namespace diaphane::render
