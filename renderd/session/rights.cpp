#include "renderd/session/rights.h"

#include <utility>

namespace diaphane::render {
namespace {

enum class Rule {
  kNever,
  kAlways,
  kPresenting,     ///< allowed while this viewer presents
  kSteering,       ///< allowed while this viewer presents or has a camera of their own
  kWithSlices,     ///< allowed if the owner or host allows slices for this viewer
  kWithDownloads,  ///< allowed if the owner allows downloads for this viewer
  kShowing,        ///< allowed while this viewer presents, and if slices are allowed
  kPointing,       ///< allowed while this viewer presents, or if the presenter allows pointers
  kLocating,       ///< allowed while this viewer points or steers, because marks are on surfaces
};

struct Row {
  RequestKind request;
  std::array<Rule, kViewers.size()> rules;  // in the order of kViewers
};

constexpr std::array<Rule, kViewers.size()> all(Rule rule) {
  return {rule, rule, rule, rule, rule, rule};
}

// Conditions beyond the kind of viewer are checked after this table. For example, a presenter
// cannot have a separate camera, a role can only be handed to a connected participant, and requests
// have rate limits.
constexpr Rule kNo = Rule::kNever, kYes = Rule::kAlways, kSlices = Rule::kWithSlices;
constexpr Rule kPresents = Rule::kPresenting, kShows = Rule::kShowing;
constexpr Rule kFiles = Rule::kWithDownloads;
constexpr std::array kTable{
    // clang-format off
    //                            owner  shared   public   link visitor  sample visitor  guest
    Row{RequestKind::kHello,       all(kYes)},
    Row{RequestKind::kResize,      all(kYes)},
    Row{RequestKind::kScene,       all(Rule::kSteering)},
    Row{RequestKind::kAck,         all(kYes)},
    Row{RequestKind::kNeedKey,     all(kYes)},
    Row{RequestKind::kVisibility,  all(kYes)},
    Row{RequestKind::kHandover,    {kYes,  kYes,    kYes,    kYes,         kYes,           Rule::kPresenting}},
    Row{RequestKind::kFreeCamera,   all(kYes)},
    Row{RequestKind::kDepthQuery,  {kYes,  kYes,    kYes,    kYes,         kYes,           Rule::kLocating}},
    Row{RequestKind::kSlices,      {kYes,  kSlices, kSlices, kSlices,      kSlices,        kSlices}},
    Row{RequestKind::kKeyView,     {kYes,  kFiles,  kFiles,  kFiles,        kNo,            kNo}},
    Row{RequestKind::kFile,        {kYes,  kFiles,  kFiles,  kFiles,       kNo,            kNo}},
    Row{RequestKind::kFileTaken,   {kYes,  kFiles,  kFiles,  kFiles,       kNo,            kNo}},
    Row{RequestKind::kKernel,      all(kYes)},
    Row{RequestKind::kGuestSlices, {kYes,  kNo,     kSlices, kNo,          kNo,            kNo}},
    Row{RequestKind::kErrorCurve,  all(kYes)},
    Row{RequestKind::kSliceView,   {kPresents, kShows, kShows, kShows,     kShows,         kShows}},
    Row{RequestKind::kMeasurements, {kPresents, kShows, kShows, kShows,    kShows,         kShows}},
    Row{RequestKind::kPointer,     {kYes,  kYes,    kYes,    kYes,         kYes,           Rule::kPointing}},
    Row{RequestKind::kGuestPointers, all(kPresents)},
    Row{RequestKind::kSharedTaken, all(kYes)},
    Row{RequestKind::kMarks,       {kYes,  kYes,    kYes,    kYes,         kYes,           Rule::kPointing}},
    Row{RequestKind::kMarkSight,   all(kYes)},
    Row{RequestKind::kRaiseHand,   all(kYes)},
    Row{RequestKind::kFileMark,    {kYes,  kFiles,  kFiles,  kFiles,       kNo,            kNo}},
    Row{RequestKind::kGoodViews,   all(kPresents)},
    // clang-format on
};

constexpr bool covers_every_message() {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    if (kTable[i].request != kRequests[i]) return false;
  }
  for (std::size_t i = 0; i < kViewers.size(); ++i) {
    if (kViewers[i] != static_cast<ViewerKind>(i)) return false;
  }
  return kTable.size() == kRequests.size();
}
static_assert(covers_every_message());

}  // namespace

ViewerKind viewer_of(v1::Viewer viewer) {
  switch (viewer) {
    case v1::VIEWER_OWNER:
      return ViewerKind::kOwner;
    case v1::VIEWER_SHARED:
      return ViewerKind::kShared;
    case v1::VIEWER_PUBLIC:
      return ViewerKind::kPublic;
    case v1::VIEWER_LINK_VISITOR:
      return ViewerKind::kLinkVisitor;
    case v1::VIEWER_SAMPLE_VISITOR:
      return ViewerKind::kSampleVisitor;
    default:
      return ViewerKind::kGuest;
  }
}

bool may_know_labels(ViewerKind viewer) {
  return viewer == ViewerKind::kOwner || viewer == ViewerKind::kShared;
}

std::optional<RequestKind> request_of(const v1::ClientMessage& message) {
  switch (message.body_case()) {
    case v1::ClientMessage::kHello:
      return RequestKind::kHello;
    case v1::ClientMessage::kScene:
      return message.scene().has_scene() ? RequestKind::kScene : RequestKind::kResize;
    case v1::ClientMessage::kAck:
      return RequestKind::kAck;
    case v1::ClientMessage::kNeedKey:
      return RequestKind::kNeedKey;
    case v1::ClientMessage::kVisibility:
      return RequestKind::kVisibility;
    case v1::ClientMessage::kHandover:
      return RequestKind::kHandover;
    case v1::ClientMessage::kFreeCamera:
      return RequestKind::kFreeCamera;
    case v1::ClientMessage::kDepthQuery:
      return RequestKind::kDepthQuery;
    case v1::ClientMessage::kSlices:
      return RequestKind::kSlices;
    case v1::ClientMessage::kKeyView:
      return RequestKind::kKeyView;
    case v1::ClientMessage::kFile:
      return RequestKind::kFile;
    case v1::ClientMessage::kFileTaken:
      return RequestKind::kFileTaken;
    case v1::ClientMessage::kKernel:
      return RequestKind::kKernel;
    case v1::ClientMessage::kGuestSlices:
      return RequestKind::kGuestSlices;
    case v1::ClientMessage::kErrorCurve:
      return RequestKind::kErrorCurve;
    case v1::ClientMessage::kSliceView:
      return RequestKind::kSliceView;
    case v1::ClientMessage::kMeasurements:
      return RequestKind::kMeasurements;
    case v1::ClientMessage::kPointer:
      return RequestKind::kPointer;
    case v1::ClientMessage::kGuestPointers:
      return RequestKind::kGuestPointers;
    case v1::ClientMessage::kSharedTaken:
      return RequestKind::kSharedTaken;
    case v1::ClientMessage::kMarks:
      return RequestKind::kMarks;
    case v1::ClientMessage::kMarkSight:
      return RequestKind::kMarkSight;
    case v1::ClientMessage::kRaiseHand:
      return RequestKind::kRaiseHand;
    case v1::ClientMessage::kFileMark:
      return RequestKind::kFileMark;
    case v1::ClientMessage::kGoodViews:
      return RequestKind::kGoodViews;
    case v1::ClientMessage::BODY_NOT_SET:
      break;
  }
  return std::nullopt;
}

bool may(const ViewerRights& rights, RequestKind request) {
  const Row& row = kTable[static_cast<std::size_t>(request)];
  switch (row.rules[static_cast<std::size_t>(rights.viewer)]) {
    case Rule::kAlways:
      return true;
    case Rule::kPresenting:
      return rights.presents;
    case Rule::kSteering:
      return rights.presents || rights.free_camera;
    case Rule::kWithSlices:
      return rights.slices;
    case Rule::kWithDownloads:
      return rights.downloads;
    case Rule::kShowing:
      return rights.presents && rights.slices;
    case Rule::kPointing:
      return rights.presents || rights.pointers;
    case Rule::kLocating:
      return rights.presents || rights.free_camera || rights.pointers;
    case Rule::kNever:
      break;
  }
  return false;
}

SliceAccess slice_access(const ViewerRights& rights) {
  if (!may(rights, RequestKind::kSlices)) return SliceAccess::kNone;
  switch (rights.viewer) {
    case ViewerKind::kOwner:
    case ViewerKind::kShared:
    case ViewerKind::kPublic:
      return SliceAccess::kWhole;
    case ViewerKind::kGuest:
      if (rights.presents || rights.any_slice) break;
      return SliceAccess::kShown;
    case ViewerKind::kLinkVisitor:
    case ViewerKind::kSampleVisitor:
      break;
  }
  return SliceAccess::kClipped;
}

v1::SliceAccess to_proto(SliceAccess access) {
  switch (access) {
    case SliceAccess::kClipped:
      return v1::SLICE_ACCESS_CLIPPED;
    case SliceAccess::kShown:
      return v1::SLICE_ACCESS_SHOWN;
    case SliceAccess::kWhole:
      return v1::SLICE_ACCESS_WHOLE;
    case SliceAccess::kNone:
      break;
  }
  return v1::SLICE_ACCESS_NONE;
}

std::optional<v1::Scene> allowed_scene(const ViewerRights& rights, const v1::Scene* now,
                                       v1::Scene requested) {
  if (rights.viewer == ViewerKind::kGuest) {
    if (!now) return std::nullopt;
    requested.clear_clip();
    if (now->has_clip()) *requested.mutable_clip() = now->clip();
  }
  if (slice_access(rights) == SliceAccess::kNone) {
    requested.clear_slices();
    if (now && now->has_slices()) *requested.mutable_slices() = now->slices();
  }
  return requested;
}

}  // namespace diaphane::render
