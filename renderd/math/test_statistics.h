#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

// What the statistical tests of the renderer share. Every test states its significance: the
// probability that a correct renderer fails it with fresh random numbers (they are fixed by their
// seeds, so a pass stays a pass).

namespace diaphane::render::test {

/// z that a normal variable exceeds with probability `upper_tail`.
inline double normal_quantile(double upper_tail) {
  double low = -40, high = 40;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(middle / std::numbers::sqrt2) > upper_tail ? low : high) = middle;
  }
  return low;
}

/// |z| that a normal variable exceeds with probability `alpha`, both sides.
inline double critical_z(double alpha) { return normal_quantile(alpha / 2); }

/// |t| that a Student variable of `dof` >= 10 degrees of freedom exceeds with probability `alpha`,
/// both sides. Cornish-Fisher expansion of the normal quantile (Abramowitz and Stegun 26.7.5);
/// relative error below 1% for alpha >= 1e-9.
inline double critical_t(double alpha, double dof) {
  const double z = critical_z(alpha);
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * dof) + (5 * z5 + 16 * z3 + 3 * z) / (96 * dof * dof) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * dof * dof * dof);
}

/// The significance each of `tests` independent tests may have for `alpha` in all (Sidak).
inline double sidak(double alpha, std::size_t tests) {
  return -std::expm1(std::log1p(-alpha) / static_cast<double>(tests));
}

/// Chi-square that `dof` degrees of freedom exceed with probability `alpha` (Wilson and Hilferty;
/// within 1% for dof >= 10).
inline double critical_chi_square(double alpha, double dof) {
  const double a = 2 / (9 * dof);
  const double root = 1 - a + normal_quantile(alpha) * std::sqrt(a);
  return dof * root * root * root;
}

/// Of counts that should all be equal.
inline double chi_square_uniform(std::span<const std::uint64_t> counts) {
  double total = 0;
  for (std::uint64_t n : counts) total += static_cast<double>(n);
  const double expected = total / static_cast<double>(counts.size());
  double chi = 0;
  for (std::uint64_t n : counts) {
    const double d = static_cast<double>(n) - expected;
    chi += d * d / expected;
  }
  return chi;
}

/// A chi-square statistic and its degrees of freedom.
struct ChiSquare {
  double value = 0, dof = 0;

  /// Whether a correct sampler gives less with probability 1 - `alpha`.
  bool fits(double alpha) const { return dof < 1 || value < critical_chi_square(alpha, dof); }
};

/// Of counts against the probabilities of their bins, which add up to 1 together with that of
/// falling into none. Bins that expect fewer than 20 are joined with the next, the last ones with
/// the one before: the statistic has its distribution only where all expect some. A count where the
/// probability is 0 fits nothing.
inline ChiSquare chi_square(std::span<const std::uint64_t> counts,
                            std::span<const double> probabilities, double samples) {
  constexpr double kFewest = 20;
  struct Bin {
    double seen = 0, expected = 0;
  };
  ChiSquare chi;
  std::vector<Bin> bins;
  Bin open;
  double all_seen = 0, all_expected = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto n = static_cast<double>(counts[i]);
    if (!(probabilities[i] > 0) && n > 0) chi.value += 1e9;
    open.seen += n;
    open.expected += probabilities[i] * samples;
    all_seen += n;
    all_expected += probabilities[i] * samples;
    if (open.expected < kFewest) continue;
    bins.push_back(open);
    open = {};
  }
  const auto join = [&bins](Bin last) {
    if (last.expected >= kFewest || bins.empty()) {
      bins.push_back(last);
    } else {
      bins.back().seen += last.seen;
      bins.back().expected += last.expected;
    }
  };
  join(open);
  if (samples - all_expected > 1) join({samples - all_seen, samples - all_expected});
  for (const Bin& bin : bins) {
    if (bin.expected > 0) {
      chi.value += (bin.seen - bin.expected) * (bin.seen - bin.expected) / bin.expected;
    }
  }
  chi.dof = static_cast<double>(bins.size()) - 1;
  return chi;
}

/// Mean and variance of a stream (Welford).
struct Moments {
  double n = 0, mean = 0, m2 = 0;

  void add(double x) {
    n += 1;
    const double d = x - mean;
    mean += d / n;
    m2 += d * (x - mean);
  }
  double variance() const { return n > 1 ? m2 / (n - 1) : 0; }
  double error_of_mean() const { return std::sqrt(variance() / n); }
};

/// Welch's t of two means; a normal variable for the sample sizes used here (hundreds and more). 0
/// when both are constant and equal.
inline double welch(const Moments& a, const Moments& b) {
  const double variance = a.variance() / a.n + b.variance() / b.n;
  if (variance == 0) return a.mean == b.mean ? 0 : 1e9;
  return (a.mean - b.mean) / std::sqrt(variance);
}

}  // namespace diaphane::render::test
