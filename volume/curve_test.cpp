#include "volume/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace diaphane::volume {
namespace {

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double distance(const Vector& a, const Vector& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void expect_near(const Vector& got, const Vector& expected, double tolerance) {
  EXPECT_LE(distance(got, expected), tolerance)
      << got[0] << " " << got[1] << " " << got[2] << " instead of " << expected[0] << " "
      << expected[1] << " " << expected[2];
}

constexpr double kRadius = 20, kRise = 5;  // mm, rise per radian
constexpr int kTurns = 3, kPoints = 60;
/// The angle between two points of the helix.
constexpr double kStep = 2 * std::numbers::pi * kTurns / (kPoints - 1);

std::vector<Vector> helix() {
  std::vector<Vector> points;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = kStep * i;
    points.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), kRise * angle});
  }
  return points;
}

TEST(Curve, LengthOfAHelixIsThatOfItsFormula) {
  const auto curve = Curve::through(helix());
  ASSERT_TRUE(curve);
  const double exact = kStep * (kPoints - 1) * std::hypot(kRadius, kRise);
  // Inside, a cubic through points of a circle leaves it by at most (1/48 + 1/384) h^4 of the
  // radius, and its length changes by that part. The first and last segments begin along their
  // chord, which turns the tangent by h / 2 and changes their length by at most 0.2 h^2.
  const double inside = std::pow(kStep, 4) * (1.0 / 48 + 1.0 / 384);
  const double ends = 2.0 / (kPoints - 1) * 0.2 * kStep * kStep;
  EXPECT_NEAR(curve->length(), exact, (inside + ends) * exact);
}

TEST(Curve, IsMeasuredByItsArcLength) {
  const auto curve = Curve::through(helix());
  ASSERT_TRUE(curve);
  constexpr double kApart = 0.5;
  for (double arc = 0; arc + kApart < curve->length(); arc += kApart) {
    // A chord is shorter than its arc by a part of (arc / radius)^2 / 24, and the smallest radius
    // of curvature, at the ends, is above kRadius / 2. The chords of the table are as exact.
    const double part = kApart * kApart / (kRadius * kRadius / 4) / 24;
    EXPECT_NEAR(distance(curve->at(arc).place, curve->at(arc + kApart).place), kApart,
                2 * part * kApart)
        << arc;
  }
}

TEST(Curve, PassesThroughItsPoints) {
  const std::vector<Vector> points{{0, 0, 0}, {10, 3, 0}, {11, 30, 4}, {-5, 31, 8}};
  const auto curve = Curve::through(points);
  ASSERT_TRUE(curve);
  for (const Vector& point : points) {
    double nearest = 1e9;
    for (double arc = 0; arc <= curve->length(); arc += 0.01) {
      nearest = std::min(nearest, distance(curve->at(arc).place, point));
    }
    EXPECT_LE(nearest, 0.01);
  }
}

// Computed by the recursion of Barry and Goldman with 4,000 steps per segment, with frames that
// are projected from step to step.
TEST(Curve, EqualsAnIndependentComputation) {
  const std::vector<Vector> points{
      {-30, 5, -20}, {-10, 25, -5}, {15, 10, 0}, {20, -20, 25}, {40, -25, 60}};
  const auto curve = Curve::through(points);
  ASSERT_TRUE(curve);
  // Chords of a 64th of a segment, which is 0.7 mm, around a radius above 5 mm.
  const double part = 0.7 * 0.7 / 25 / 24;
  const double tolerance = part * curve->length();
  EXPECT_NEAR(curve->length(), 144.1595204, tolerance);
  const auto first = curve->at(0), second = curve->at(29.9991214), third = curve->at(74.9972816),
             last = curve->at(144.16);
  // The first and last tangents of that computation are those of a chord.
  expect_near(first.along, {0.624614, 0.624779, 0.468517}, 1e-3);
  expect_near(first.across, {0.780934, -0.499717, -0.374734}, 1e-3);
  // A shift along the curve turns its frame by at most a radian per 5 mm.
  expect_near(second.place, {-12.253648, 24.468386, -6.098287}, tolerance);
  expect_near(second.along, {0.83177, 0.325385, 0.449758}, tolerance / 5);
  expect_near(second.across, {0.541101, -0.656163, -0.525984}, tolerance / 5);
  expect_near(third.place, {17.98739, 0.480519, 6.189514}, tolerance);
  expect_near(third.across, {-0.274635, -0.55783, -0.783199}, tolerance / 5);
  expect_near(last.place, {40, -25, 60}, 1e-9);
  expect_near(last.across, {-0.051596, -0.992347, -0.112183}, 1e-3);
}

TEST(Curve, FramesOfAHelixTurnWithoutTwist) {
  const auto curve = Curve::through(helix());
  ASSERT_TRUE(curve);
  // Against the normal of the helix, a frame without twist turns back by the torsion. The first
  // segment and the last one are not helical.
  const double torsion = kRise / (kRadius * kRadius + kRise * kRise);
  const auto turned = [&](double arc) {
    const Curve::Frame frame = curve->at(arc);
    const double angle = arc / std::hypot(kRadius, kRise);
    const Vector inwards{-std::cos(angle), -std::sin(angle), 0};
    const Vector third{frame.along[1] * inwards[2] - frame.along[2] * inwards[1],
                       frame.along[2] * inwards[0] - frame.along[0] * inwards[2],
                       frame.along[0] * inwards[1] - frame.along[1] * inwards[0]};
    return std::atan2(dot(frame.across, third), dot(frame.across, inwards));
  };
  const double begin = 2 * kStep * std::hypot(kRadius, kRise);
  for (double arc = begin; arc < curve->length() - begin; arc += 10) {
    const double twist =
        std::remainder(turned(arc) - turned(begin) + torsion * (arc - begin), 2 * std::numbers::pi);
    // Tangents of the spline deviate by h^3 / 12 from those of the helix, and so does the frame.
    // Arc lengths deviate by the ends.
    EXPECT_NEAR(twist, 0, std::pow(kStep, 3) / 12 + 0.01) << arc;
  }
}

TEST(Curve, FramesAreOrthonormalAndContinuous) {
  const std::vector<Vector> doubled{{0, 0, 0}, {20, 0, 0}, {0, 0, 0}};
  const std::vector<Vector> sharp{{0, 0, 0}, {20, 0, 0}, {0.5, 0.01, 0}, {3, 30, 1}};
  for (const auto& points : {helix(), doubled, sharp}) {
    const auto curve = Curve::through(points);
    ASSERT_TRUE(curve);
    Vector before = curve->at(0).across;
    for (double arc = 0; arc < curve->length() + 1; arc += 0.05) {
      const Curve::Frame frame = curve->at(arc);
      EXPECT_NEAR(dot(frame.along, frame.along), 1, 1e-12);
      EXPECT_NEAR(dot(frame.across, frame.across), 1, 1e-12);
      EXPECT_NEAR(dot(frame.along, frame.across), 0, 1e-12);
      EXPECT_GT(dot(frame.across, before), 0.5) << arc;
      before = frame.across;
    }
  }
}

TEST(Curve, IsStraightThroughCollinearPoints) {
  const std::vector<Vector> two{{-10, 0, 0}, {20, 0, 0}};
  const std::vector<Vector> many{{-10, 0, 0}, {-9, 0, 0}, {-9, 0, 0}, {5, 0, 0}, {20, 0, 0}};
  for (const auto& points : {two, many}) {
    const auto curve = Curve::through(points);
    ASSERT_TRUE(curve);
    EXPECT_NEAR(curve->length(), 30, 1e-9);
    for (double arc = 0; arc <= 30; arc += 1.5) {
      const Curve::Frame frame = curve->at(arc);
      // Between nodes, the parameter is interpolated.
      expect_near(frame.place, {arc - 10, 0, 0}, 0.01);
      expect_near(frame.along, {1, 0, 0}, 1e-9);
      expect_near(frame.across, {0, 0, -1}, 1e-9);
    }
  }
}

TEST(Curve, TurnsBackOnItself) {
  const std::vector<Vector> points{{0, 0, 0}, {20, 0, 0}, {0, 0, 0}};
  const auto curve = Curve::through(points);
  ASSERT_TRUE(curve);
  EXPECT_NEAR(curve->length(), 40, 1e-9);
  expect_near(curve->at(30).along, {-1, 0, 0}, 1e-9);
  expect_near(curve->at(10).across, {0, 0, -1}, 1e-9);
  expect_near(curve->at(30).across, {0, 0, -1}, 1e-9);
}

TEST(Curve, BeginsAcrossTheAxisThatIsLeastParallel) {
  const auto across = [](const std::vector<Vector>& points) {
    return Curve::through(points)->at(0).across;
  };
  expect_near(across({{-40, 20, 3}, {0, -20, 3}, {40, 20, 3}}), {0, 0, -1}, 1e-9);  // a jaw
  expect_near(across({{1, -5, 90}, {1, 15, 0}, {1, -5, -90}}), {1, 0, 0}, 1e-9);    // a spine
  expect_near(across({{0, 0, 0}, {0, 0, 10}}), {1, 0, 0}, 1e-9);
  // The curve begins along the axis that is least parallel to all of it.
  expect_near(across({{0, 0, 0}, {0, 0, 1}, {90, 60, 1}, {0, 100, 1}}), {0, 1, 0}, 1e-9);
}

TEST(Curve, RefusesPointsWithoutACurve) {
  const auto refused = [](const std::vector<Vector>& points) {
    const auto curve = Curve::through(points);
    return curve ? std::string("nothing") : curve.error().field + ": " + curve.error().message;
  };
  const std::string lacking = "points: A curve needs two different points.";
  EXPECT_EQ(refused({}), lacking);
  EXPECT_EQ(refused({{1, 2, 3}}), lacking);
  EXPECT_EQ(refused({{1, 2, 3}, {1, 2, 3}, {1, 2, 3.0001}}), lacking);
  const std::string invalid = "points: A point of this curve is not valid.";
  EXPECT_EQ(refused({{0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}}), invalid);
  EXPECT_EQ(refused({{0, 0, 0}, {0, 1e7, 0}}), invalid);
  std::vector<Vector> many(kMostCurvePoints);
  for (std::size_t i = 0; i < many.size(); ++i) many[i][0] = double(i);
  EXPECT_EQ(refused(many), "nothing");
  many.push_back({99, 0, 0});
  EXPECT_EQ(refused(many), "points: This curve has too many points.");
}

}  // namespace
}  // namespace diaphane::volume
