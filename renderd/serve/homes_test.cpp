#include "renderd/serve/homes.h"

#include <gtest/gtest.h>

#include "renderd/composite/composite_engine.h"
#include "renderd/schedule/policy.h"
#include "tests/support/renderd/fake_engine.h"

namespace diaphane::render {
namespace {

TEST(ChooseHome, PrefersFewWaitingSessionsThenFewGuests) {
  EXPECT_EQ(choose_home({{0, 0}}), 0u);
  EXPECT_EQ(choose_home({{0, 1}, {0, 0}, {0, 0}}), 1u);
  EXPECT_EQ(choose_home({{2, 2}, {1, 9}, {1, 8}}), 2u) << "converged sessions need nothing";
}

class HomesTest : public testing::Test {
 protected:
  static std::unique_ptr<Engine> two_devices() {
    std::vector<std::unique_ptr<Engine>> devices;
    for (int i = 0; i < 2; ++i) {
      devices.push_back(std::make_unique<FakeEngine>(std::make_shared<FakeDevice>()));
    }
    return make_composite_engine(std::move(devices), nullptr);
  }
  std::unique_ptr<Homes> homes(Engine& engine) {
    return std::make_unique<Homes>(engine, [this](const Engine&) {
      return std::make_unique<Runner>(make_policy(PolicyKind::kMarginalGain), clock_,
                                      Runner::Options{});
    });
  }

  SystemClock clock_;
};

TEST_F(HomesTest, GuestsAreSpreadOverTheDevices) {
  const auto engine = two_devices();
  const auto homes = this->homes(*engine);
  auto first = homes->take();
  const auto second = homes->take();
  EXPECT_NE(&first->runner, &second->runner);
  EXPECT_NE(&first->engine, &second->engine);
  const Runner* const left = &first->runner;
  first.reset();
  EXPECT_EQ(&homes->take()->runner, left) << "its guest has gone";
  EXPECT_EQ(homes->progress().size(), 2u);
}

TEST_F(HomesTest, EngineOfOneDeviceIsItsOwnHome) {
  FakeEngine engine(std::make_shared<FakeDevice>());
  const auto homes = this->homes(engine);
  EXPECT_EQ(&homes->take()->engine, &engine);
  EXPECT_EQ(homes->progress().size(), 1u);
}

}  // namespace
}  // namespace diaphane::render
