#pragma once

#include <array>
#include <optional>

#include "api/proto/stream.pb.h"
#include "api/proto/worker.pb.h"

namespace diaphane::render {

/// Who looks, as the gateway says with each connection (worker.proto).
enum class ViewerKind {
  kOwner,          ///< of the scan
  kShared,         ///< an account that the scan is shared with
  kPublic,         ///< an account that looks at a public scan of somebody else
  kLinkVisitor,    ///< without an account, by a link to the scan
  kSampleVisitor,  ///< without an account, at a sample
  kGuest,          ///< by a link into somebody's session, with or without an account
};
inline constexpr std::array kViewers{ViewerKind::kOwner,         ViewerKind::kShared,
                                     ViewerKind::kPublic,        ViewerKind::kLinkVisitor,
                                     ViewerKind::kSampleVisitor, ViewerKind::kGuest};
/// What is not known has the least rights.
ViewerKind viewer_of(diaphane::v1::Viewer viewer);

/// What a page can say. A SceneUpdate without a scene only tells the size of the page's picture.
enum class RequestKind {
  kHello,
  kResize,
  kScene,
  kAck,
  kNeedKey,
  kVisibility,
  kHandover,
  kOwnCamera,
  kDepthQuery,
  kSlices,
  kKeyView,
  kFile,
  kFileTaken,
  kKernel,
  kGuestSlices,
};
inline constexpr std::array kRequests{
    RequestKind::kHello,     RequestKind::kResize,    RequestKind::kScene,
    RequestKind::kAck,       RequestKind::kNeedKey,   RequestKind::kVisibility,
    RequestKind::kHandover,  RequestKind::kOwnCamera, RequestKind::kDepthQuery,
    RequestKind::kSlices,    RequestKind::kKeyView,   RequestKind::kFile,
    RequestKind::kFileTaken, RequestKind::kKernel,    RequestKind::kGuestSlices};
/// Nothing for a message that is empty or of a newer page.
std::optional<RequestKind> request_of(const diaphane::v1::ClientMessage& message);

/// What a viewer is at this moment.
struct Standing {
  ViewerKind viewer = ViewerKind::kGuest;
  bool presents = false;
  bool own_camera = false;
  bool slices =
      false;  ///< the scan's owner, or the host of the session, lets this viewer have them
};

/// The one table of rights: who may say what to a session.
bool may(const Standing& standing, RequestKind request);

enum class SliceAccess {
  kNone,
  kClipped,  ///< voxels inside the session's clip; the others are blank
  kWhole,
};
SliceAccess slice_access(const Standing& standing);
diaphane::v1::SliceAccess to_proto(SliceAccess access);

/// What becomes of a scene that this viewer sends. Who has no slices cannot place any in the
/// picture either; of a guest's scene the clip never counts. Nothing: there is no scene yet whose
/// clip could be kept. `now`: the session's scene, or null.
std::optional<diaphane::v1::Scene> allowed_scene(const Standing& standing,
                                                 const diaphane::v1::Scene* now,
                                                 diaphane::v1::Scene wanted);

}  // namespace diaphane::render
