#include "operator/kube/leader.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/support/operator/fake_transport.h"

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;

std::string lease(const std::string& holder, const std::string& version) {
  LeaseRecord record;
  record.holder = holder;
  record.version = version;
  record.acquired = record.renewed = "2026-01-01T00:00:00.000000Z";
  return lease_object("l", record).dump();
}

class LeaderTest : public testing::Test {
 protected:
  void start() {
    Leader::Options options;
    options.path = "/leases";
    options.name = "l";
    options.lease.identity = "me";
    options.lease.duration = 3s;
    options.lease.renew_deadline = 2s;
    options.lease.retry = 0s;
    options.won = [this] { ++won_; };
    options.lost = [this] { ++lost_; };
    leader_ = std::make_unique<Leader>(options, api_);
  }
  bool wait_until(const std::function<bool()>& condition) {
    for (int i = 0; i < 2000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }
  FakeTransport transport_;
  Api api_{transport_, "test"};
  std::atomic<int> won_{0}, lost_{0};
  std::unique_ptr<Leader> leader_;
};

TEST_F(LeaderTest, LosesLeadershipWithoutAnAnswerInTime) {
  transport_.put({404, "{}"});
  transport_.put({201, lease("me", "1")});
  // Repeatedly broken: neither renewed nor read.
  std::atomic<bool> ended{false};
  start();
  ASSERT_TRUE(wait_until([&] { return won_ == 1; }));
  EXPECT_TRUE(leader_->leads());
  std::thread breaks([&] {
    while (!ended) {
      transport_.put({0, ""});
      std::this_thread::sleep_for(20ms);
    }
  });
  EXPECT_TRUE(wait_until([&] { return lost_ == 1; }));
  EXPECT_FALSE(leader_->leads());
  ended = true;
  breaks.join();
  transport_.stop();
  leader_.reset();
}

TEST_F(LeaderTest, LosesLeadershipWhenAConflictShowsAnotherHolder) {
  transport_.put({404, "{}"});
  transport_.put({201, lease("me", "1")});
  transport_.put({409, R"({"reason":"Conflict"})"});
  transport_.put({200, lease("other", "2")});
  start();
  EXPECT_TRUE(wait_until([&] { return lost_ == 1; }));
  EXPECT_EQ(won_, 1);
  transport_.stop();
  leader_.reset();
}

}  // namespace
}  // namespace diaphane::kube
