#include "renderd/schedule/marginal_gain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace diaphane::render {
namespace {

/// A session at rest with an error of c / sqrt(n).
SessionView resting(std::uint64_t handle, std::uint64_t samples, double c = 0.5,
                    double cost = 0.0005) {
  SessionView session;
  session.session = handle;
  session.samples = samples;
  session.error = c / std::sqrt(double(samples));
  session.target_error = 0.01;
  session.seconds_per_sample = cost;
  session.seconds_since_input = 1;
  session.seconds_since_frame = 0.1;
  session.seconds_since_begun = 1;
  return session;
}

SessionView asking(std::uint64_t handle, double since) {
  SessionView session = resting(handle, 1);
  session.samples = 0;
  session.error = std::numeric_limits<double>::infinity();
  session.seconds_since_input = since;
  session.seconds_unanswered = since;
  session.seconds_since_begun = 1;
  return session;
}

std::uint64_t chosen(const std::vector<SessionView>& sessions) {
  return MarginalGain().next(sessions).at(0).session;
}

TEST(MarginalGain, PrefersTheNoisierImage) {
  EXPECT_EQ(chosen({resting(1, 400), resting(2, 300)}), 2U);
  EXPECT_EQ(chosen({resting(1, 300, 0.2), resting(2, 300, 0.4)}), 2U);
}

TEST(MarginalGain, PrefersTheCheaperOfEqualImages) {
  EXPECT_EQ(chosen({resting(1, 400, 0.5, 0.001), resting(2, 400, 0.5, 0.0004)}), 2U);
}

TEST(MarginalGain, PrefersTheNewImageNearestToUsable) {
  EXPECT_EQ(chosen({resting(1, 90), resting(2, 60)}), 1U) << "5% takes 100 samples";
}

TEST(MarginalGain, AnswersInputFirstAndTheOldestBeforeOthers) {
  EXPECT_EQ(chosen({resting(1, 2), asking(2, 0.004), asking(3, 0.007)}), 3U);
}

TEST(MarginalGain, AnswersInputOfTheLighterUserFirst) {
  SessionView heavy = asking(2, 0.007);
  heavy.seconds_lately = 0.004;
  EXPECT_EQ(chosen({heavy, asking(3, 0.002)}), 2U) << "it has waited for longer than it is behind";
  heavy.seconds_lately = 0.006;
  EXPECT_EQ(chosen({heavy, asking(3, 0.002)}), 3U);
}

TEST(MarginalGain, ServesLongWaitingSessionBeforeNewInput) {
  SessionView waiting = resting(1, 1000);
  waiting.seconds_waiting = 1.99;
  EXPECT_EQ(chosen({waiting, asking(2, 0.004)}), 2U);
  waiting.seconds_waiting = 2.01;
  EXPECT_EQ(chosen({waiting, asking(2, 0.004)}), 1U);
}

TEST(MarginalGain, DragYieldsTheDeviceBetweenItsFrames) {
  SessionView dragging = asking(1, 0.002);
  dragging.seconds_per_sample = 0.008;
  dragging.seconds_since_begun = 0.01;  // 70% of the device allows one frame per 11.4 ms
  EXPECT_EQ(chosen({dragging, resting(2, 400)}), 2U);
  EXPECT_EQ(chosen({dragging}), 1U) << "nobody else gains";
  dragging.seconds_since_begun = 0.012;
  EXPECT_EQ(chosen({dragging, resting(2, 400)}), 1U);
}

TEST(MarginalGain, LimitsInteractiveSessionsToTheirShareUnderOverload) {
  std::vector<SessionView> sessions{resting(1, 400)};
  for (std::uint64_t handle = 2; handle <= 11; ++handle) {
    sessions.push_back(asking(handle, 0.05));
    sessions.back().seconds_per_sample = 0.01;  // 100 ms for one frame of each session
    sessions.back().seconds_since_begun = 0.12;
  }
  EXPECT_EQ(chosen(sessions), 1U);
  sessions[5].seconds_since_begun = 0.13;  // 80% of the device allows one round per 125 ms
  EXPECT_EQ(chosen(sessions), sessions[5].session);
}

TEST(MarginalGain, ExpensiveDragsDoNotDelayCheapOnes) {
  // Two drags of 100 ms per frame could each fill the device. The cheap one needs 0.002 / 0.028 =
  // 7% of it, so the others share the remaining 73% of the 80% for drags, a frame every 274 ms.
  std::vector<SessionView> sessions{resting(1, 400), asking(2, 0.01), asking(3, 0.1),
                                    asking(4, 0.1)};
  sessions[1].seconds_per_sample = 0.002;
  sessions[2].seconds_per_sample = sessions[3].seconds_per_sample = 0.1;
  sessions[1].seconds_since_begun = 0.029;
  sessions[2].seconds_since_begun = sessions[3].seconds_since_begun = 0.27;
  EXPECT_EQ(chosen(sessions), 2U);
  sessions[1].seconds_since_begun = 0.02;
  EXPECT_EQ(chosen(sessions), 1U) << "no drag is due";
  sessions[3].seconds_since_begun = 0.28;
  EXPECT_EQ(chosen(sessions), 4U);
}

TEST(MarginalGain, PatienceGrowsUnderOverload) {
  std::vector<SessionView> sessions;
  for (std::uint64_t handle = 1; handle <= 200; ++handle) {
    sessions.push_back(resting(handle, handle));
    sessions.back().seconds_waiting = 1.9;
  }
  sessions.resize(400, sessions.back());
  for (std::uint64_t handle = 201; handle <= 400; ++handle) {
    sessions[handle - 1].session = handle;
    sessions[handle - 1].seconds_waiting = 2.5;
  }
  sessions.back().seconds_waiting = 3.9;
  EXPECT_NE(chosen(sessions), 400U);
  sessions.back().seconds_waiting = 4.1;
  EXPECT_EQ(chosen(sessions), 400U);
  EXPECT_EQ(MarginalGain().next(sessions).at(0).samples, 2U) << "at most 1 ms";
}

TEST(MarginalGain, ViewerThatTakesNoFrameHasNoDeadline) {
  SessionView slow = asking(1, 0.02);
  slow.wants_frame = false;
  EXPECT_EQ(chosen({slow, asking(2, 0.001)}), 2U);
}

TEST(MarginalGain, RunningSessionIsNotChosenAgainButCountsAsLoad) {
  std::vector<SessionView> sessions{asking(1, 0.02), asking(2, 0.001)};
  sessions[0].under_way = true;
  EXPECT_EQ(chosen(sessions), 2U);
  EXPECT_EQ(MarginalGain().next(sessions).at(0).samples, 2U)
      << "half the samples of a single session";
  sessions[1].under_way = true;
  EXPECT_TRUE(MarginalGain().next(sessions).empty());
}

TEST(MarginalGain, OnlyADueFirstImageOvertakes) {
  MarginalGain policy;
  const auto overtaking = [&](const SessionView& session) {
    return !policy.overtaking(std::vector{resting(1, 10), session}, 0).empty();
  };
  const SessionView drag = asking(2, 0.02);
  EXPECT_TRUE(overtaking(drag));
  EXPECT_EQ(policy.overtaking(std::vector{resting(1, 10), drag}, 0).at(0).session, 2U);
  SessionView rendered = drag;
  rendered.samples = 4;
  EXPECT_FALSE(overtaking(rendered)) << "its first picture is there";
  SessionView just_begun = drag;
  just_begun.seconds_since_begun = 0.0001;
  EXPECT_FALSE(overtaking(just_begun)) << "drags leave part of the device to others";
  SessionView at_rest = asking(2, 1);
  at_rest.seconds_since_input = 1;
  EXPECT_TRUE(overtaking(at_rest));
  at_rest.seconds_lately = 0.9;
  EXPECT_FALSE(overtaking(at_rest)) << "inputs without end leave part of the device to others";
  SessionView unasked = resting(2, 0);
  EXPECT_FALSE(overtaking(unasked)) << "it answers no input";
  SessionView under_way = drag;
  under_way.under_way = true;
  EXPECT_FALSE(overtaking(under_way));
}

TEST(MarginalGain, CheapFirstImageOvertakesExpensiveOne) {
  MarginalGain policy;
  SessionView small = asking(1, 0.02);
  small.seconds_per_sample = 0.002;
  SessionView large = asking(2, 0.02);
  large.seconds_per_sample = 0.032;
  ASSERT_GT(first_picture_precedence(small), first_picture_precedence(large));
  EXPECT_EQ(policy.overtaking(std::vector{small}, first_picture_precedence(large)).size(), 1U);
  EXPECT_TRUE(policy.overtaking(std::vector{large}, first_picture_precedence(small)).empty());
  EXPECT_TRUE(policy.overtaking(std::vector{small}, first_picture_precedence(small)).empty());
}

TEST(MarginalGain, PriorityGrowsByOnePerQuarterOfTheCost) {
  const auto precedence = [](double first, double sample) {
    return first_picture_precedence({.seconds_per_sample = sample, .seconds_first = first});
  };
  EXPECT_EQ(precedence(0, 0), 1U) << "not known yet";
  EXPECT_EQ(precedence(5, 1), 1U);
  EXPECT_EQ(precedence(0.1, 0.1), 2U);
  EXPECT_EQ(precedence(0, 0.05), 3U);
  EXPECT_EQ(precedence(0, 0.05 / 4), 4U);
  EXPECT_EQ(precedence(0, 1e-9), kHighestPrecedence);
  EXPECT_EQ(first_picture_precedence({.seconds_per_sample = 1e-9, .seconds_lately = 0.05}), 3U);
}

TEST(MarginalGain, ShortensTheFirstImagesOfManyDrags) {
  std::vector<SessionView> sessions{asking(1, 0.001)};
  EXPECT_EQ(MarginalGain().next(sessions).at(0).samples, 4U);
  for (std::uint64_t handle = 2; handle <= 4; ++handle) sessions.push_back(asking(handle, 0.001));
  EXPECT_EQ(MarginalGain().next(sessions).at(0).samples, 1U);
}

TEST(MarginalGain, RestingImageGetsItsWholeFirstQuantumDuringDrags) {
  SessionView lifted = asking(1, 0.01);
  lifted.seconds_since_input = 1;
  EXPECT_EQ(
      MarginalGain().next(std::vector{lifted, asking(2, 0.001), asking(3, 0.001)}).at(0).samples,
      4U);
}

TEST(MarginalGain, UnknownErrorFollowsThePreviousImage) {
  SessionView clean = asking(1, 0), noisy = asking(2, 0);
  for (SessionView* each : {&clean, &noisy}) {
    each->seconds_unanswered = 0;
    each->seconds_since_input = 1;
    each->samples = 1;
  }
  clean.noise = 0.05;
  noisy.noise = 0.4;
  EXPECT_GT(MarginalGain().gain(noisy), MarginalGain().gain(clean));
}

}  // namespace
}  // namespace diaphane::render
