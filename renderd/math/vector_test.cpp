#include "renderd/math/vector.h"

#include <gtest/gtest.h>

#include <limits>

#include "renderd/math/random.h"

namespace diaphane::render {
namespace {

TEST(Vector, BasisIsOrthonormalAndRightHanded) {
  const auto check = [](Float3 n) {
    Float3 s, t;
    basis_around(n, s, t);
    // Each value is a sum of three products of numbers below 1 with rounding errors of 2^-24.
    constexpr float kRounding = 1e-6f;
    EXPECT_NEAR(dot(s, s), 1, kRounding);
    EXPECT_NEAR(dot(t, t), 1, kRounding);
    EXPECT_NEAR(dot(s, t), 0, kRounding);
    EXPECT_NEAR(dot(s, n), 0, kRounding);
    EXPECT_NEAR(dot(t, n), 0, kRounding);
    EXPECT_NEAR(dot(cross(s, t), n), 1, kRounding);
  };
  for (const float sign : {1.0f, -1.0f}) {
    for (const float zero : {0.0f, -0.0f}) {
      check({sign, zero, zero});
      check({zero, sign, zero});
      check({zero, zero, sign});
    }
    check(normalize(Float3{1e-4f, -1e-4f, sign}));
  }
  Random random(1, 2, 3);
  for (int i = 0; i < 10'000; ++i) {
    const Random::Pair u = random.two();
    check(normalize(Float3{u.a - 0.5f, u.b - 0.5f, random.one() - 0.5f}));
  }
}

TEST(Vector, IsFiniteChecksEveryComponent) {
  EXPECT_TRUE(is_finite(Float3{3e38f, -3e38f, 1e-45f}));
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_FALSE(is_finite(Float3{bad, 0, 0}));
    EXPECT_FALSE(is_finite(Float3{0, bad, 0}));
    EXPECT_FALSE(is_finite(Float3{0, 0, bad}));
    EXPECT_FALSE(is_finite(Float3{bad, -bad, bad}));
  }
}

}  // namespace
}  // namespace diaphane::render
