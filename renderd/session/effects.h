#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/session/audience.h"
#include "renderd/session/host_volume.h"
#include "renderd/session/slice_request_queue.h"
#include "renderd/session/view_request.h"

// Effects that the rules of a session return. Most rules have the form `handle(event, state, now)`:
// they change plain data, lock nothing and send nothing. Those in state.h return an Outcome
// instead. LiveSession carries the effects out.

namespace diaphane::render {

/// A slice that is being made, and the clip in effect. nullopt: the whole slice.
struct SliceOrder {
  SliceDue due;
  std::optional<diaphane::v1::Clip> clip;
};

namespace effect {

/// A message to be sent before any other event is handled, so that a viewer receives messages in
/// the order in which they were decided.
struct Send {
  std::uint64_t connection = 0;
  diaphane::v1::ServerMessage message;
};
struct Warn {
  std::string event;  ///< name of the event in the log
};
/// Sends the state of the whole session (Config) to a connection.
struct Configure {
  std::uint64_t connection = 0;
};
struct BroadcastParticipants {};

struct WakeRunner {};
struct LeaveRunner {
  std::uint64_t handle = 0;
};
/// Answers a DepthQuery of this connection.
struct FindDepth {
  std::uint64_t connection = 0;
  diaphane::v1::DepthQuery query;
};
/// Finds the surface at this place of the picture that a participant sees (0 to 1 from the upper
/// left), because they point at it. The answer is PointerFound.
struct FindPointer {
  std::uint64_t connection = 0;
  std::uint64_t number = 0;
  double x = 0, y = 0;
};
/// Answers a MarkSightQuery of this connection.
struct FindMarkSight {
  std::uint64_t connection = 0;
};
/// Answers a GoodViewsQuery of this connection.
struct FindGoodViews {
  std::uint64_t connection = 0;
};
/// Tells the encoders that they may take the next picture.
struct PokeEncoders {};

/// Loads the voxels for slices. The answer is VoxelsLoaded.
struct LoadVoxels {
  std::uint32_t phase = 0;  ///< of the scan
};
/// Reads and encodes a slice. The answer is SliceCoded.
struct CodeSlice {
  std::uint64_t connection = 0;
  SliceOrder order;
  volume::SliceStack stack;
  std::shared_ptr<const HostVolume> voxels;
  bool for_guest = false;
  bool with_labels = false;  ///< the viewer may know them
};

/// Encodes a lossless tile. The answer is TileCoded, unless the picture is no longer needed.
struct CodeTile {
  std::uint64_t picture = 0;
  std::weak_ptr<const PictureRgb8> pixels;
  std::uint32_t tile = 0;
  diaphane::v1::StillFormat format = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
};

/// Begins a file. The answers are FileMessage, or FileRefused if the file cannot be begun.
struct StartFile {
  std::uint64_t file = 0;
  diaphane::v1::FileRequest request;
  std::vector<diaphane::v1::Scene> keys;
  std::vector<diaphane::v1::FileMark> marks;
  std::shared_ptr<const DeviceVolume> volume;
};
struct AcknowledgeFile {
  std::uint64_t file = 0;
  std::uint64_t seq = 0;
};
/// Ends the work on a file and frees its reservation.
struct StopFile {
  std::uint64_t file = 0;
};

/// Opens a session of their own for a follower. The answer is CameraOpened.
struct OpenCamera {
  std::uint64_t connection = 0;
  std::string participant;
  std::string name;
  std::string link;  ///< link by which they joined; empty: the owner
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas viewport;
};
/// Greets the follower's own session, and then sends the list of participants to the group.
struct EnterCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in that session
  diaphane::v1::ClientMessage hello;
};
/// Forwards a message of a follower to their own session.
struct ForwardToCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in that session
  diaphane::v1::ClientMessage message;
};
/// Applies the presenter's settings to a follower's own session. Later ones have a higher number.
struct FollowPresenter {
  std::string session;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  std::uint64_t number = 0;
};
/// Stops the messages of a follower's own session. The answer is CameraSilenced.
struct SilenceCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in the group's session
  std::optional<Error> why;      ///< error to show to the follower; nullopt: the follower wished it
};
struct DismissCamera {
  std::string session;
};

}  // namespace effect

using Effect =
    std::variant<effect::Send, effect::Configure, effect::BroadcastParticipants, effect::Warn,
                 effect::WakeRunner, effect::LeaveRunner, effect::FindDepth, effect::FindPointer,
                 effect::FindMarkSight, effect::FindGoodViews, effect::PokeEncoders,
                 effect::LoadVoxels, effect::CodeSlice, effect::CodeTile, effect::StartFile,
                 effect::AcknowledgeFile, effect::StopFile, effect::OpenCamera, effect::EnterCamera,
                 effect::ForwardToCamera, effect::FollowPresenter, effect::SilenceCamera,
                 effect::DismissCamera>;
using Effects = std::vector<Effect>;

/// Returns the message that tells a viewer about an error that does not end the connection.
effect::Send problem_to(std::uint64_t connection, const Error& why);

}  // namespace diaphane::render
