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

// What the rules of a session ask for. Most are functions of one shape: `handle(event, state, now)`
// changes plain data and returns effects. Those in state.h return an Outcome instead. They lock
// nothing and call nobody. LiveSession carries the effects out.

namespace diaphane::render {

/// A slice that is being made, and the clip in effect. nullopt: the whole slice.
struct SliceOrder {
  SliceDue due;
  std::optional<diaphane::v1::Clip> clip;
};

namespace effect {

/// To be sent before any other event is handled, so that a viewer receives messages in the order in
/// which they were decided.
struct Send {
  std::uint64_t connection = 0;
  diaphane::v1::ServerMessage message;
};
struct Warn {
  std::string event;  ///< of the log
};
/// The connection receives the state of the whole session (Config).
struct Configure {
  std::uint64_t connection = 0;
};
struct BroadcastParticipants {};

struct WakeRunner {};
struct LeaveRunner {
  std::uint64_t handle = 0;
};
/// A DepthQuery of this connection is to be answered.
struct FindDepth {
  std::uint64_t connection = 0;
  diaphane::v1::DepthQuery query;
};
/// A participant points at this place of the picture that they see (0 to 1 from the upper left). To
/// be answered with PointerFound.
struct FindPointer {
  std::uint64_t connection = 0;
  std::uint64_t number = 0;
  double x = 0, y = 0;
};
/// A MarkSightQuery of this connection is to be answered.
struct FindMarkSight {
  std::uint64_t connection = 0;
};
/// The encoders may take the next picture.
struct PokeEncoders {};

/// To be answered with VoxelsLoaded.
struct LoadVoxels {};
/// To be answered with SliceCoded.
struct CodeSlice {
  std::uint64_t connection = 0;
  SliceOrder order;
  volume::SliceStack stack;
  std::shared_ptr<const HostVolume> voxels;
  bool for_guest = false;
};

/// To be answered with TileCoded, unless the picture is no longer needed.
struct CodeTile {
  std::uint64_t picture = 0;
  std::weak_ptr<const PictureRgb8> pixels;
  std::uint32_t tile = 0;
  diaphane::v1::StillFormat format = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
};

/// To be answered with FileSaid, or with FileRefused if the file cannot be begun.
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

/// A session of its own for a follower, to be answered with CameraOpened.
struct OpenCamera {
  std::uint64_t connection = 0;
  std::string participant;
  std::string name;
  std::string link;  ///< by which they joined; empty: the owner
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas viewport;
};
/// Greets the follower's own session, and then tells everyone in the group.
struct EnterCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in that session
  diaphane::v1::ClientMessage hello;
};
/// A message of a follower to their own session.
struct ForwardToCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in that session
  diaphane::v1::ClientMessage message;
};
/// The presenter's settings for a follower's own session. A later one has a higher number.
struct FollowPresenter {
  std::string session;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  std::uint64_t number = 0;
};
/// The follower's own session is to send nothing more, to be answered with CameraSilenced.
struct SilenceCamera {
  std::string session;
  std::uint64_t connection = 0;  ///< its number in the group's session
  std::optional<Error> why;      ///< for the follower; nullopt: it was their wish
};
struct DismissCamera {
  std::string session;
};

}  // namespace effect

using Effect =
    std::variant<effect::Send, effect::Configure, effect::BroadcastParticipants, effect::Warn,
                 effect::WakeRunner, effect::LeaveRunner, effect::FindDepth, effect::FindPointer,
                 effect::FindMarkSight, effect::PokeEncoders, effect::LoadVoxels, effect::CodeSlice,
                 effect::CodeTile, effect::StartFile, effect::AcknowledgeFile, effect::StopFile,
                 effect::OpenCamera, effect::EnterCamera, effect::ForwardToCamera,
                 effect::FollowPresenter, effect::SilenceCamera, effect::DismissCamera>;
using Effects = std::vector<Effect>;

/// Tells a viewer about an error that does not end the connection.
effect::Send problem_to(std::uint64_t connection, const Error& why);

}  // namespace diaphane::render
