#include <gtest/gtest.h>

#include "directory/links.h"
#include "directory/worker.h"
#include "tests/support/directory/test_sessions.h"

namespace diaphane::directory {
namespace {

class SecondScanTest : public SessionsTest {
 protected:
  void SetUp() override {
    SessionsTest::SetUp();
    announce({.id = "a", .slots = 10});
    two.over = new_id();
    two.to_first = "1 0 0 5.5";
  }
  PlaceRequest two = request();
};

TEST_F(SecondScanTest, StaysWithItsSession) {
  const auto placed = sessions_.place(two);
  ASSERT_TRUE(placed);
  EXPECT_EQ(sessions_.find(two.session_id)->over, two.over);
  EXPECT_EQ(sessions_.sessions_of(two.user_id)->at(0).over, two.over);
  const auto attached = sessions_.consume(placed->ticket);
  ASSERT_TRUE(attached);
  EXPECT_EQ(attached->session.over, two.over);
  EXPECT_EQ(attached->to_first, two.to_first);
  // A later ticket names no second scan, and another motion changes nothing.
  PlaceRequest again = two;
  again.over.clear();
  again.to_first = "2 0 0";
  const auto next = sessions_.consume(sessions_.place(again)->ticket);
  EXPECT_EQ(next->session.over, two.over);
  EXPECT_EQ(next->to_first, two.to_first);
}

TEST_F(SecondScanTest, EndsItsSessionLikeTheFirst) {
  PlaceRequest one = request();
  one.over = two.over;
  ASSERT_TRUE(sessions_.place(one) && sessions_.place(two));
  EXPECT_EQ(sessions_.sessions_on(two.over)->size(), 2u);
  ASSERT_TRUE(sessions_.end(one.session_id));
  EXPECT_EQ(sessions_.sessions_on(two.over)->size(), 1u);
  ASSERT_TRUE(sessions_.end_all_of(two.over));
  EXPECT_FALSE(sessions_.find(two.session_id));
  EXPECT_TRUE(sessions_.sessions_on(two.data_set_id)->empty());
}

TEST_F(SecondScanTest, IsKnownToALinkSoThatGuestsNeedAccessToBoth) {
  ASSERT_TRUE(sessions_.place(two));
  Links links(*client_);
  const std::string hash(64, 'a');
  ASSERT_TRUE(links.make(two.session_id, two.user_id, hash, false));
  EXPECT_EQ(links.follow(hash)->session.over, two.over);
}

TEST_F(SecondScanTest, IsRestoredByTheWorker) {
  WorkerDirectory worker(*client_, "a", "first");
  LostSession lost{.id = two.session_id,
                   .user_id = two.user_id,
                   .data_set_id = two.data_set_id,
                   .saved = {.placement = 1},
                   .over = two.over,
                   .to_first = two.to_first,
                   .links = {std::string(64, 'b') + " slices"}};
  ASSERT_TRUE(*worker.restore(lost));
  EXPECT_EQ(sessions_.sessions_on(two.over)->at(0).id, two.session_id);
  Links links(*client_);
  EXPECT_TRUE(links.follow(std::string(64, 'b'))->slices);
  LostSession single = lost;
  single.id = new_id();
  single.over.clear();
  ASSERT_TRUE(*worker.restore(single));
  EXPECT_EQ(sessions_.find(single.id)->over, "");
}

}  // namespace
}  // namespace diaphane::directory
