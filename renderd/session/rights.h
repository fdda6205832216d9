#pragma once

#include <array>
#include <optional>

#include "api/proto/stream.pb.h"
#include "api/proto/worker.pb.h"

namespace diaphane::render {

/// The kind of viewer, which the gateway determines for each connection (worker.proto).
enum class ViewerKind {
  kOwner,          ///< the owner of the scan
  kShared,         ///< an account with which the scan is shared
  kPublic,         ///< an account that views a public scan of another user
  kLinkVisitor,    ///< a visitor without an account who opened a link to the scan
  kSampleVisitor,  ///< a visitor without an account who views a sample
  kGuest,          ///< anyone who opened a link to a session, with or without an account
};
inline constexpr std::array kViewers{ViewerKind::kOwner,         ViewerKind::kShared,
                                     ViewerKind::kPublic,        ViewerKind::kLinkVisitor,
                                     ViewerKind::kSampleVisitor, ViewerKind::kGuest};
/// Converts from the protocol. Unknown values become kGuest, which has the fewest rights.
ViewerKind viewer_of(diaphane::v1::Viewer viewer);

/// Returns whether a viewer may learn the names of structures, and where they lie in slices. They
/// may reveal more than a picture does, so only the owner and the accounts with which the scan is
/// shared receive them.
bool may_know_labels(ViewerKind viewer);

/// The requests of a page. A SceneUpdate without a scene only reports the size of the page's
/// picture.
enum class RequestKind {
  kHello,
  kResize,
  kScene,
  kAck,
  kNeedKey,
  kVisibility,
  kHandover,
  kFreeCamera,
  kDepthQuery,
  kSlices,
  kKeyView,
  kFile,
  kFileTaken,
  kKernel,
  kGuestSlices,
  kErrorCurve,
  kSliceView,
  kMeasurements,
  kPointer,
  kGuestPointers,
  kSharedTaken,
  kMarks,
  kMarkSight,
  kRaiseHand,
  kFileMark,
  kGoodViews,
};
inline constexpr std::array kRequests{
    RequestKind::kHello,      RequestKind::kResize,        RequestKind::kScene,
    RequestKind::kAck,        RequestKind::kNeedKey,       RequestKind::kVisibility,
    RequestKind::kHandover,   RequestKind::kFreeCamera,    RequestKind::kDepthQuery,
    RequestKind::kSlices,     RequestKind::kKeyView,       RequestKind::kFile,
    RequestKind::kFileTaken,  RequestKind::kKernel,        RequestKind::kGuestSlices,
    RequestKind::kErrorCurve, RequestKind::kSliceView,     RequestKind::kMeasurements,
    RequestKind::kPointer,    RequestKind::kGuestPointers, RequestKind::kSharedTaken,
    RequestKind::kMarks,      RequestKind::kMarkSight,     RequestKind::kRaiseHand,
    RequestKind::kFileMark,   RequestKind::kGoodViews};
/// Returns the kind of a message, or nullopt if it is empty or of a newer page.
std::optional<RequestKind> request_of(const diaphane::v1::ClientMessage& message);

/// The current state of a viewer.
struct ViewerRights {
  ViewerKind viewer = ViewerKind::kGuest;
  bool presents = false;
  bool free_camera = false;
  bool slices = false;     ///< the owner of the scan, or the host of the session, allows them
  bool pointers = true;    ///< the presenter allows pointers and marks of guests
  bool downloads = false;  ///< the owner of the scan allows them
  bool any_slice =
      false;  ///< for a guest: their link allows slices that the presenter does not show
};

/// Returns whether a viewer may send a request. Its table is the only one with a session's access
/// rights.
bool may(const ViewerRights& rights, RequestKind request);

enum class SliceAccess {
  kNone,
  kShown,    ///< like kClipped, but only the slices that the presenter shows now
  kClipped,  ///< voxels inside the session's clip; the others are blank
  kWhole,
};
SliceAccess slice_access(const ViewerRights& rights);
diaphane::v1::SliceAccess to_proto(SliceAccess access);

/// Returns the part of a scene from this viewer that is allowed. A viewer without slices cannot
/// place any in the picture either, and the clip of a guest's scene is ignored. Returns nullopt if
/// there is no scene yet whose clip could be kept. `now`: the session's scene, or null.
std::optional<diaphane::v1::Scene> allowed_scene(const ViewerRights& rights,
                                                 const diaphane::v1::Scene* now,
                                                 diaphane::v1::Scene requested);

}  // namespace diaphane::render
