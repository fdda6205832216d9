// Invariants of all policies in random worlds: sessions of any cost and noise, with inputs, viewers
// that hide and show the picture, and viewers that accept no frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "renderd/schedule/policy.h"

namespace diaphane::render {
namespace {

constexpr double kTarget = 0.01;
constexpr double kNever = -1;

struct Person {
  double noise = 0.5;  // error after one sample
  double cost = 0.001;
  double first = 0.0005;
  double fill = 1;
  std::uint64_t samples = 0;
  bool visible = true;
  bool room = true;
  double input_at = 0;
  double unanswered_since = kNever;
  double frame_at = -10;
  double begun_at = -10;
  double answered_after = 0;  // time from the last input to its frame, seconds
  double served_at = 1;

  bool converged() const { return samples >= 16 && noise <= kTarget * std::sqrt(double(samples)); }
};

/// A device that renders one session at a time, so a round takes as long as its quanta together.
class World {
 public:
  /// `viewer_changes`: rate per second at which a viewer hides or shows the picture, and at which
  /// it starts or stops accepting frames.
  World(std::uint64_t seed, std::size_t people, double inputs_a_second, double viewer_changes = 0.3)
      : random_(seed), input_rate_(inputs_a_second), viewer_rate_(viewer_changes) {
    for (std::size_t i = 0; i < people; ++i) {
      Person person;
      person.noise = std::exp(uniform(std::log(0.05), std::log(2.0)));
      person.cost = std::exp(uniform(std::log(5e-5), std::log(5e-3)));
      person.first = uniform(0, 0.001);
      person.fill = uniform(0, 1) < 0.3 ? 0.05 : 1;
      people_.push_back(person);
    }
  }

  std::vector<SessionView> views() const {
    std::vector<SessionView> views;
    for (std::size_t i = 0; i < people_.size(); ++i) {
      const Person& p = people_[i];
      SessionView view;
      view.session = 10 + 7 * i;
      view.samples = p.samples;
      view.error = p.samples < 2   ? std::numeric_limits<double>::infinity()
                   : p.converged() ? 0
                                   : std::max(p.noise / std::sqrt(double(p.samples)), 2 * kTarget);
      view.target_error = kTarget;
      view.seconds_per_sample = p.cost;
      view.seconds_first = p.first;
      view.fill = p.fill;
      view.seconds_since_input = now_ - p.input_at;
      if (p.unanswered_since != kNever)
        view.seconds_unanswered = std::max(now_ - p.unanswered_since, 1e-9);
      view.seconds_since_frame = now_ - p.frame_at;
      view.seconds_since_begun = now_ - p.begun_at;
      view.seconds_waiting = now_ - p.served_at;
      view.visible = p.visible;
      view.wants_frame = p.room;
      views.push_back(view);
    }
    return views;
  }

  void input(std::size_t i) {
    Person& p = people_[i];
    p.samples = 0;
    p.input_at = now_;
    if (p.unanswered_since == kNever) p.unanswered_since = now_;
  }

  /// Renders the round, and then applies the inputs and viewer changes of that time.
  void carry_out(const std::vector<Quantum>& round) {
    const double start = now_;
    for (const Quantum& quantum : round) {
      Person& p = of(quantum.session);
      now_ += quantum.samples * p.cost + (p.samples == 0 ? p.first : 0);
    }
    for (const Quantum& quantum : round) {
      Person& p = of(quantum.session);
      if (p.samples == 0) p.begun_at = start;
      p.samples += quantum.samples;
      p.served_at = now_;
      if (p.room) {
        p.frame_at = now_;
        if (p.unanswered_since != kNever) p.answered_after = now_ - p.unanswered_since;
        p.unanswered_since = kNever;
      }
    }
    if (round.empty()) now_ += 0.01;
    for (std::size_t i = 0; i < people_.size(); ++i) {
      Person& p = people_[i];
      if (uniform(0, 1) < input_rate_ * (now_ - start) && i % still_one_in != 0) input(i);
      if (uniform(0, 1) < viewer_rate_ * (now_ - start)) p.visible = !p.visible;
      if (uniform(0, 1) < viewer_rate_ * (now_ - start)) p.room = !p.room;
      if (!p.visible || p.converged()) p.served_at = now_;
    }
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Person& of(std::uint64_t handle) { return people_.at((handle - 10) / 7); }
  std::vector<Person>& people() { return people_; }
  double now() const { return now_; }

  std::size_t still_one_in = 1'000'000;  ///< one person in this many gives no input
  std::mt19937_64& random() { return random_; }

 private:
  std::mt19937_64 random_;
  double input_rate_;
  double viewer_rate_;
  double now_ = 1;
  std::vector<Person> people_;
};

bool same(const std::vector<Quantum>& one, const std::vector<Quantum>& other) {
  return std::equal(one.begin(), one.end(), other.begin(), other.end(),
                    [](const Quantum& a, const Quantum& b) {
                      return a.session == b.session && a.samples == b.samples;
                    });
}

class Worlds : public testing::TestWithParam<PolicyKind> {
 protected:
  /// Calls `check` for each of 400 rounds in each of 12 worlds.
  template <typename Check>
  void each(Check check) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      World world(seed, 1 + seed * seed % 37, seed % 3 == 0 ? 20 : 0.5);
      const auto policy = make_policy(GetParam(), {}, seed);
      for (int i = 0; i < 400; ++i) {
        const std::vector<SessionView> views = world.views();
        const std::vector<Quantum> round = policy->next(views);
        ASSERT_NO_FATAL_FAILURE(check(world, views, round)) << "world " << seed << ", round " << i;
        world.carry_out(round);
      }
    }
  }
};

TEST_P(Worlds, ServesExactlyWhileAVisibleSessionGains) {
  each([](World&, const std::vector<SessionView>& views, const std::vector<Quantum>& round) {
    std::set<std::uint64_t> gaining;
    for (const SessionView& view : views) {
      if (view.visible && view.error > kTarget) gaining.insert(view.session);
    }
    ASSERT_EQ(round.empty(), gaining.empty());
    for (const Quantum& quantum : round) {
      ASSERT_EQ(gaining.erase(quantum.session), 1U)
          << "session does not gain, or was scheduled twice";
      ASSERT_GE(quantum.samples, 1U);
    }
  });
}

TEST_P(Worlds, QuantumIsShortUnlessOneSampleIsLong) {
  each([](World& world, const std::vector<SessionView>& views, const std::vector<Quantum>& round) {
    const QuantumLimits limits = limits_for(views, {});
    for (const Quantum& quantum : round) {
      if (quantum.samples == 1) continue;
      ASSERT_LE(quantum.samples * world.of(quantum.session).cost,
                std::max(limits.quantum_seconds, limits.first_seconds) + 1e-9);
    }
  });
}

TEST_P(Worlds, ResultDoesNotDependOnTheSessionOrder) {
  const auto other = make_policy(GetParam(), {}, 1);
  World world(5, 24, 5);
  const auto policy = make_policy(GetParam(), {}, 1);
  for (int i = 0; i < 500; ++i) {
    const std::vector<SessionView> views = world.views();
    std::vector<SessionView> shuffled = views;
    std::shuffle(shuffled.begin(), shuffled.end(), world.random());
    const std::vector<Quantum> round = policy->next(views);
    ASSERT_TRUE(same(round, other->next(shuffled))) << i;
    world.carry_out(round);
  }
}

TEST_P(Worlds, SameSeedGivesTheSameSchedule) {
  World world(6, 24, 5);
  World twin(6, 24, 5);
  const auto policy = make_policy(GetParam(), {}, 9);
  const auto other = make_policy(GetParam(), {}, 9);
  for (int i = 0; i < 500; ++i) {
    const std::vector<Quantum> round = policy->next(world.views());
    ASSERT_TRUE(same(round, other->next(twin.views()))) << i;
    world.carry_out(round);
    twin.carry_out(round);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Worlds, testing::ValuesIn(kPolicyKinds), [](const auto& info) {
  std::string name(policy_name(info.param));
  std::erase(name, '-');
  return name;
});

/// Every session that gains gets a quantum within the patience plus the time for sessions whose
/// patience ended earlier: one quantum of each of them, and the one in flight.
TEST(MarginalGainWorlds, NoSessionStarvesUnderAnyLoad) {
  double longest_wait = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    World world(seed, 40, 60);  // all sessions drag, which far exceeds the device's capacity
    world.still_one_in = 4;
    const auto policy = make_policy(PolicyKind::kMarginalGain);
    double bound = 2;
    for (const Person& p : world.people())
      bound += std::max(QuantumLimits{}.quantum_seconds, p.cost) + p.first;
    bound += 0.011;
    for (int i = 0; i < 6000; ++i) {
      const std::vector<SessionView> views = world.views();
      for (const SessionView& view : views) {
        if (!gains(view)) continue;
        ASSERT_LE(view.seconds_waiting, bound) << "world " << seed << ", round " << i;
        longest_wait = std::max(longest_wait, view.seconds_waiting);
      }
      world.carry_out(policy->next(views));
    }
  }
  EXPECT_GT(longest_wait, 1.5) << "there was no load";
}

/// Several sessions get input at once after a rest, while others converge. If their first samples
/// and the quantum in flight fit the deadline, all of them get their first frame in time.
TEST(MarginalGainWorlds, FirstFrameMeetsTheDeadlineIfFeasible) {
  constexpr double kDeadline = 1.0 / 30;
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    World world(seed, 30, 0, 0);
    for (Person& p : world.people()) p.samples = 20 + seed;
    const auto policy = make_policy(PolicyKind::kMarginalGain);
    for (int i = 0; i < 20; ++i) world.carry_out(policy->next(world.views()));
    const double asked = world.now();
    // The round in flight was chosen before the inputs.
    const std::vector<Quantum> under_way = policy->next(world.views());
    double needed = QuantumLimits{}.first_seconds;
    for (const Quantum& q : under_way) needed += q.samples * world.of(q.session).cost;
    std::vector<std::size_t> askers;
    for (std::size_t i = 0; i < world.people().size(); ++i) {
      Person& p = world.people()[i];
      if (world.uniform(0, 1) < 0.5) continue;
      if (needed + p.cost + p.first > kDeadline) continue;
      const std::uint64_t handle = 10 + 7 * i;
      if (std::any_of(under_way.begin(), under_way.end(),
                      [&](const Quantum& q) { return q.session == handle; }))
        continue;
      needed += p.cost + p.first;
      askers.push_back(i);
      world.input(i);
    }
    world.carry_out(under_way);
    for (int i = 0; i < 60 && world.now() < asked + 1; ++i)
      world.carry_out(policy->next(world.views()));
    for (const std::size_t i : askers) {
      const Person& p = world.people()[i];
      ++tried;
      EXPECT_EQ(p.unanswered_since, kNever);
      EXPECT_LE(p.answered_after, kDeadline + 1e-9) << "world " << seed;
    }
  }
  EXPECT_GT(tried, 500);
}

}  // namespace
}  // namespace diaphane::render
