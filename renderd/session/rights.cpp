#include "renderd/session/rights.h"

#include <utility>

namespace diaphane::render {
namespace {

enum class Rule {
  kNever,
  kAlways,
  kPresenting,  ///< while this viewer presents
  kSteering,    ///< while this viewer presents or has a camera of their own
  kWithSlices,  ///< if the owner or host allows slices for this viewer
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
    Row{RequestKind::kDepthQuery,  {kYes,  kYes,    kYes,    kYes,         kYes,           Rule::kSteering}},
    Row{RequestKind::kSlices,      {kYes,  kYes,    kSlices, kSlices,      kSlices,        kSlices}},
    Row{RequestKind::kKeyView,     {kYes,  kYes,    kYes,    kNo,          kNo,            kNo}},
    Row{RequestKind::kFile,        {kYes,  kYes,    kYes,    kNo,          kNo,            kNo}},
    Row{RequestKind::kFileTaken,   {kYes,  kYes,    kYes,    kNo,          kNo,            kNo}},
    Row{RequestKind::kKernel,      all(kYes)},
    Row{RequestKind::kGuestSlices, {kYes,  kNo,     kSlices, kNo,          kNo,            kNo}},
    // clang-format on
};

constexpr bool is_whole() {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    if (kTable[i].request != kRequests[i]) return false;
  }
  for (std::size_t i = 0; i < kViewers.size(); ++i) {
    if (kViewers[i] != static_cast<ViewerKind>(i)) return false;
  }
  return kTable.size() == kRequests.size();
}
static_assert(is_whole());

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
    case v1::ClientMessage::BODY_NOT_SET:
      break;
  }
  return std::nullopt;
}

bool may(const Standing& standing, RequestKind request) {
  const Row& row = kTable[static_cast<std::size_t>(request)];
  switch (row.rules[static_cast<std::size_t>(standing.viewer)]) {
    case Rule::kAlways:
      return true;
    case Rule::kPresenting:
      return standing.presents;
    case Rule::kSteering:
      return standing.presents || standing.free_camera;
    case Rule::kWithSlices:
      return standing.slices;
    case Rule::kNever:
      break;
  }
  return false;
}

SliceAccess slice_access(const Standing& standing) {
  if (!may(standing, RequestKind::kSlices)) return SliceAccess::kNone;
  switch (standing.viewer) {
    case ViewerKind::kOwner:
    case ViewerKind::kShared:
    case ViewerKind::kPublic:
      return SliceAccess::kWhole;
    case ViewerKind::kLinkVisitor:
    case ViewerKind::kSampleVisitor:
    case ViewerKind::kGuest:
      break;
  }
  return SliceAccess::kClipped;
}

v1::SliceAccess to_proto(SliceAccess access) {
  switch (access) {
    case SliceAccess::kClipped:
      return v1::SLICE_ACCESS_CLIPPED;
    case SliceAccess::kWhole:
      return v1::SLICE_ACCESS_WHOLE;
    case SliceAccess::kNone:
      break;
  }
  return v1::SLICE_ACCESS_NONE;
}

std::optional<v1::Scene> allowed_scene(const Standing& standing, const v1::Scene* now,
                                       v1::Scene wanted) {
  if (standing.viewer == ViewerKind::kGuest) {
    if (!now) return std::nullopt;
    wanted.clear_clip();
    if (now->has_clip()) *wanted.mutable_clip() = now->clip();
  }
  if (slice_access(standing) == SliceAccess::kNone) {
    wanted.clear_slices();
    if (now && now->has_slices()) *wanted.mutable_slices() = now->slices();
  }
  return wanted;
}

}  // namespace diaphane::render
