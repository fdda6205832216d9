// Tests of the statistics that other tests use: a test that relies on a wrong critical value is
// worthless.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "renderd/math/random.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render::test {
namespace {

/// Returns how many of `trials` samplings of the bins' true probabilities do not fit at `alpha`.
int refused(const std::vector<double>& probabilities, int samples, int trials, double alpha) {
  Random random(11, 0, 0);
  int out = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<std::uint64_t> counts(probabilities.size());
    for (int i = 0; i < samples; ++i) {
      double u = random.one();
      for (std::size_t bin = 0; bin < counts.size(); ++bin) {
        if (u < probabilities[bin]) {
          ++counts[bin];
          break;
        }
        u -= probabilities[bin];
      }
    }
    out += !chi_square(counts, probabilities, samples).fits(alpha);
  }
  return out;
}

/// Sixteen bins expect 37.5 counts each, and one expects 0.02. In one of fifty samplings this bin
/// has a count, which alone would add 48 to the statistic. By chance 40 of 4000 samplings are
/// rejected, with a standard deviation of 6.3. A significance of 1e-6 is 4.9 deviations, and
/// another tenth allows for the approximation of the distribution.
TEST(ChiSquareTest, RejectsAtItsSignificanceWithARareLastBin) {
  constexpr double kRare = 0.02 / 600;
  std::vector<double> probabilities(16, (1 - kRare) / 16);
  probabilities.push_back(kRare);
  const int n = refused(probabilities, 600, 4000, 0.01);
  EXPECT_LT(n, 40 + 31 + 4);
  EXPECT_GT(n, 40 - 31 - 4);
}

TEST(ChiSquareTest, MergesBinsThatExpectFewerThanTwenty) {
  const std::vector<std::uint64_t> counts{5, 30, 10, 12, 40, 3};
  const std::vector<double> probabilities{0.05, 0.30, 0.10, 0.12, 0.40, 0.03};
  const ChiSquare same = chi_square(counts, probabilities, 100);
  EXPECT_NEAR(same.value, 0, 1e-9);
  EXPECT_EQ(same.dof, 2) << "35, 22 and 43";
  // The last bin has two counts more, and is counted together with its neighbour.
  std::vector<std::uint64_t> more = counts;
  more[5] += 2;
  more[0] -= 2;
  EXPECT_NEAR(chi_square(more, probabilities, 100).value, 4.0 / 35 + 4.0 / 43, 1e-9);
}

TEST(ChiSquareTest, RejectsACountInAnImpossibleBin) {
  const std::vector<std::uint64_t> counts{500, 499, 1};
  const std::vector<double> probabilities{0.5, 0.5, 0};
  EXPECT_FALSE(chi_square(counts, probabilities, 1000).fits(1e-9));
}

}  // namespace
}  // namespace diaphane::render::test
