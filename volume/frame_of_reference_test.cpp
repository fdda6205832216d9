#include "volume/frame_of_reference.h"

#include <gtest/gtest.h>

namespace diaphane::volume {
namespace {

TEST(FrameOfReference, IsStoredAsASaltedHashThatOnlyItsUidFits) {
  const auto one = hidden_frame_of_reference("1.2.3"), other = hidden_frame_of_reference("1.2.3");
  if (!one) GTEST_SKIP() << one.error().message;
  EXPECT_TRUE(is_hidden_frame_of_reference(*one));
  EXPECT_NE(*one, *other) << "two scans of one examination cannot be linked";
  EXPECT_TRUE(is_frame_of_reference(*one, "1.2.3"));
  EXPECT_TRUE(is_frame_of_reference(*one, disguised_uid("1.2.3"))) << "as the page sends it";
  EXPECT_FALSE(is_frame_of_reference(*one, "1.2.4"));
  EXPECT_FALSE(is_frame_of_reference("1.2.3", "1.2.4"));
}

TEST(FrameOfReference, FitsEverythingWhileItIsUnknown) {
  EXPECT_EQ(hidden_frame_of_reference("").value_or("?"), "");
  EXPECT_TRUE(is_frame_of_reference("", "1.2.3"));
  EXPECT_TRUE(is_frame_of_reference("blake2b:", ""));
}

TEST(FrameOfReference, IsDisguisedAsByThePage) {
  // As in frontend/src/scan/label_file.test.ts.
  if (!hidden_frame_of_reference("1")) GTEST_SKIP() << "without libsodium";
  EXPECT_EQ(disguised_uid("1.2.3"), "2.25.261189956532771003411213951354307305753");
  EXPECT_EQ(disguised_uid(disguised_uid("1.2.3")), disguised_uid("1.2.3"));
}

}  // namespace
}  // namespace diaphane::volume
