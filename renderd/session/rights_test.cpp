#include "renderd/session/rights.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

std::string_view name_of(RequestKind request) {
  constexpr std::array<std::string_view, kRequests.size()> kNames{
      "hello",      "resize",         "scene",        "ack",         "need key",   "visibility",
      "handover",   "free camera",    "depth",        "slices",      "key view",   "file",
      "file taken", "kernel",         "guest slices", "error curve", "slice view", "measurements",
      "pointer",    "guest pointers", "shared taken", "marks",       "mark sight", "raise hand",
      "file mark",  "good views"};
  return kNames.at(static_cast<std::size_t>(request));
}

ViewerRights rights(ViewerKind viewer, bool presents, bool free_camera, bool slices,
                    bool pointers = true, bool downloads = true) {
  return {viewer, presents, free_camera, slices, pointers, downloads};
}

/// The rules written independently in plain terms: every viewer, every request, every situation.
bool expected(const ViewerRights& who, std::string_view request) {
  const bool guest = who.viewer == ViewerKind::kGuest;
  const bool steers = who.presents || who.free_camera;
  if (request == "scene") return steers;
  if (request == "handover") return !guest || who.presents;
  if (request == "depth") return !guest || steers || who.pointers;
  if (request == "slices") return who.viewer == ViewerKind::kOwner || who.slices;
  if (request == "key view" || request == "file" || request == "file taken" ||
      request == "file mark") {
    return who.viewer == ViewerKind::kOwner ||
           (who.downloads && !guest && who.viewer != ViewerKind::kSampleVisitor);
  }
  if (request == "guest slices") {
    return who.viewer == ViewerKind::kOwner || (who.viewer == ViewerKind::kPublic && who.slices);
  }
  if (request == "slice view" || request == "measurements") {
    return who.presents && (who.viewer == ViewerKind::kOwner || who.slices);
  }
  if (request == "pointer" || request == "marks") return !guest || who.presents || who.pointers;
  if (request == "guest pointers" || request == "good views") return who.presents;
  return true;
}

TEST(RightsTest, RequestsFollowTheAccessTable) {
  for (const ViewerKind viewer : kViewers) {
    for (const RequestKind request : kRequests) {
      for (int bits = 0; bits < 32; ++bits) {
        const ViewerRights who = rights(viewer, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0,
                                        (bits & 8) != 0, (bits & 16) != 0);
        EXPECT_EQ(may(who, request), expected(who, name_of(request)))
            << name_of(request) << " of viewer " << static_cast<int>(viewer) << " in situation "
            << bits;
      }
    }
  }
}

TEST(RightsTest, TableCoversEveryMessageOfTheProtocol) {
  const auto* const body = v1::ClientMessage::descriptor()->oneof_decl(0);
  for (int i = 0; i < body->field_count(); ++i) {
    v1::ClientMessage message;
    message.GetReflection()->MutableMessage(&message, body->field(i));
    EXPECT_TRUE(request_of(message)) << body->field(i)->name();
  }
  EXPECT_FALSE(request_of(v1::ClientMessage()));
  EXPECT_EQ(request_of(update(1, plain_scene())), RequestKind::kScene);
  v1::ClientMessage resize;
  resize.mutable_scene()->mutable_viewport();
  EXPECT_EQ(request_of(resize), RequestKind::kResize);
}

TEST(RightsTest, UnknownViewerIsAGuest) {
  EXPECT_EQ(viewer_of(v1::VIEWER_UNSPECIFIED), ViewerKind::kGuest);
  EXPECT_EQ(viewer_of(static_cast<v1::Viewer>(99)), ViewerKind::kGuest);
  EXPECT_EQ(viewer_of(v1::VIEWER_LIVE_GUEST), ViewerKind::kGuest);
  EXPECT_EQ(viewer_of(v1::VIEWER_OWNER), ViewerKind::kOwner);
}

TEST(RightsTest, GuestsGetOnlyTheShownSlicesUnlessTheyPresentOrTheirLinkAllowsAll) {
  for (int bits = 0; bits < 8; ++bits) {
    ViewerRights guest = rights(ViewerKind::kGuest, (bits & 1) != 0, (bits & 2) != 0, true);
    guest.any_slice = (bits & 4) != 0;
    EXPECT_EQ(slice_access(guest),
              guest.presents || guest.any_slice ? SliceAccess::kClipped : SliceAccess::kShown);
    guest.slices = false;
    EXPECT_EQ(slice_access(guest), SliceAccess::kNone);
  }
}

TEST(RightsTest, ViewersWithoutAccountGetOnlyClippedSlices) {
  for (const ViewerKind viewer : kViewers) {
    const bool account = viewer == ViewerKind::kOwner || viewer == ViewerKind::kShared ||
                         viewer == ViewerKind::kPublic;
    EXPECT_EQ(slice_access(rights(viewer, true, true, true)),
              account ? SliceAccess::kWhole : SliceAccess::kClipped);
  }
  for (const ViewerKind viewer :
       {ViewerKind::kShared, ViewerKind::kPublic, ViewerKind::kLinkVisitor,
        ViewerKind::kSampleVisitor, ViewerKind::kGuest}) {
    EXPECT_EQ(slice_access(rights(viewer, true, true, false)), SliceAccess::kNone);
  }
}

struct AllowedScene : testing::Test {
  AllowedScene() {
    shown.mutable_clip()->mutable_box_low()->set_x(-3);
    shown.mutable_clip()->mutable_box_high()->set_x(3);
    shown.mutable_slices()->mutable_axial()->set_shown(true);
    requested.mutable_camera()->mutable_eye()->set_x(9);
    requested.mutable_slices()->mutable_axial()->set_position(40);
  }
  v1::Scene shown = plain_scene(), requested = plain_scene();
};

TEST_F(AllowedScene, GuestCannotChangeTheClip) {
  for (const bool slices : {false, true}) {
    const auto scene =
        allowed_scene(rights(ViewerKind::kGuest, true, false, slices), &shown, requested);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->clip().SerializeAsString(), shown.clip().SerializeAsString());
    EXPECT_EQ(scene->camera().eye().x(), 9);
    EXPECT_EQ(scene->slices().axial().position(), slices ? 40 : 0);
  }
  EXPECT_FALSE(allowed_scene(rights(ViewerKind::kGuest, true, false, true), nullptr, requested));
}

TEST_F(AllowedScene, KeepsTheShownSlicesWithoutSliceAccess) {
  const ViewerRights visitor = rights(ViewerKind::kLinkVisitor, true, false, false);
  const auto scene = allowed_scene(visitor, &shown, requested);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->slices().SerializeAsString(), shown.slices().SerializeAsString());
  EXPECT_FALSE(scene->has_clip()) << "it is the visitor's own session";
  const auto first = allowed_scene(visitor, nullptr, requested);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->has_slices());
}

TEST_F(AllowedScene, DoesNotRestrictTheOwner) {
  const auto scene =
      allowed_scene(rights(ViewerKind::kOwner, true, false, true), &shown, requested);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->SerializeAsString(), requested.SerializeAsString());
}

}  // namespace
}  // namespace diaphane::render
