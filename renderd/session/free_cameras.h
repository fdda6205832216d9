#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "renderd/session/effects.h"
#include "renderd/session/events.h"
#include "renderd/session/state.h"

namespace diaphane::render {

struct CameraRequested {
  std::uint64_t connection = 0;
  bool on = false;
};
/// The answer to OpenCamera: the follower's own session, or the reason why none was opened.
struct CameraOpened {
  std::uint64_t connection = 0;
  std::string session;
  Result<std::uint64_t> there;  ///< number of the follower's connection in that session
  bool withdrawn = false;       ///< whether that session has ended already
  bool gone = false;            ///< the follower has left
};
/// A follower's own session sends nothing more.
struct CameraSilenced {
  std::uint64_t connection = 0;
  std::optional<Error> why;
};
/// A follower's own session gave up its slot.
struct CameraWithdrawn {
  std::string session;
  Error why;
};

/// The followers of a session who use a free camera in a session of their own (docs/adr/0013).
class FreeCameras {
 public:
  Effects handle(const CameraRequested& event, const SessionState& state);
  Effects handle(const CameraOpened& event, SessionState& state, TimePoint now);
  Effects handle(const CameraSilenced& event, SessionState& state, TimePoint now);
  Effects handle(const CameraWithdrawn& event);
  Effects handle(const ViewerLeft& event);
  Effects handle(SessionEnded event);
  Effects handle(SceneChanged event, const SessionState& state);

  struct Camera {
    std::string session;
    std::uint64_t connection = 0;  ///< its number in that session
  };
  /// Returns the camera of a viewer, or null if they see the group's picture.
  const Camera* of(std::uint64_t connection) const;

 private:
  std::map<std::uint64_t, Camera> cameras_;         // by connection to the group's session
  std::shared_ptr<const diaphane::v1::Scene> led_;  // the scene that they follow
  std::uint64_t number_ = 0;                        // of that scene
};

/// Returns whether a message of a follower with a free camera concerns the picture that they see,
/// and not the group.
bool concerns_picture(const diaphane::v1::ClientMessage& message);

}  // namespace diaphane::render
