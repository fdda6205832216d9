#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <span>
#include <vector>

// Statistics that the renderer's tests share. Every test states its significance: the probability
// that a correct renderer would fail it with fresh random numbers. The seeds are fixed, so a test
// that passes once always passes.

namespace diaphane::render::test {

/// Returns how much a test does in this lane. The nightly lane sets DIAPHANE_NIGHTLY. The gate
/// takes fewer samples at the same significance, so it detects only larger errors.
template <typename Number>
Number gate_or_nightly(Number gate, Number nightly) {
  return std::getenv("DIAPHANE_NIGHTLY") != nullptr ? nightly : gate;
}

/// Returns the z that a normal variable exceeds with probability `upper_tail`.
inline double normal_quantile(double upper_tail) {
  double low = -40, high = 40;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(middle / std::numbers::sqrt2) > upper_tail ? low : high) = middle;
  }
  return low;
}

/// Returns the |z| that a normal variable exceeds with probability `alpha` (two-sided).
inline double critical_z(double alpha) { return normal_quantile(alpha / 2); }

/// Returns the |t| that a Student variable of `dof` >= 10 degrees of freedom exceeds with
/// probability `alpha` (two-sided). It uses the Cornish-Fisher expansion of the normal quantile
/// (Abramowitz and Stegun 26.7.5), whose relative error is below 1% for alpha >= 1e-9.
inline double critical_t(double alpha, double dof) {
  const double z = critical_z(alpha);
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * dof) + (5 * z5 + 16 * z3 + 3 * z) / (96 * dof * dof) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * dof * dof * dof);
}

/// Returns the significance that each of `tests` independent tests may have for a total of `alpha`
/// (Sidak).
inline double sidak(double alpha, std::size_t tests) {
  return -std::expm1(std::log1p(-alpha) / static_cast<double>(tests));
}

/// Returns the chi-square that `dof` degrees of freedom exceed with probability `alpha` (Wilson and
/// Hilferty; within 1% for dof >= 10).
inline double critical_chi_square(double alpha, double dof) {
  const double a = 2 / (9 * dof);
  const double root = 1 - a + normal_quantile(alpha) * std::sqrt(a);
  return dof * root * root * root;
}

/// Returns the chi-square of counts that should all be equal.
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

  /// Whether the value is below the one that a correct sampler exceeds with probability `alpha`.
  bool fits(double alpha) const { return dof < 1 || value < critical_chi_square(alpha, dof); }
};

/// Compares counts with the probabilities of their bins. If these add up to less than 1, the rest
/// is the probability of falling into none of them. A bin that expects fewer than 20 counts is
/// joined with the next, and a last one with the bin before it, because the statistic has its
/// distribution only if every bin expects some. A count in a bin of probability 0 fits no
/// distribution.
inline ChiSquare chi_square(std::span<const std::uint64_t> counts,
                            std::span<const double> probabilities, double samples) {
  constexpr double kFewest = 20;
  struct Bin {
    double observed = 0, expected = 0;
  };
  ChiSquare chi;
  std::vector<Bin> bins;
  Bin open;
  double all_observed = 0, all_expected = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto n = static_cast<double>(counts[i]);
    if (!(probabilities[i] > 0) && n > 0) chi.value += 1e9;
    open.observed += n;
    open.expected += probabilities[i] * samples;
    all_observed += n;
    all_expected += probabilities[i] * samples;
    if (open.expected < kFewest) continue;
    bins.push_back(open);
    open = {};
  }
  const auto join = [&bins](Bin last) {
    if (last.expected >= kFewest || bins.empty()) {
      bins.push_back(last);
    } else {
      bins.back().observed += last.observed;
      bins.back().expected += last.expected;
    }
  };
  join(open);
  if (samples - all_expected > 1) join({samples - all_observed, samples - all_expected});
  for (const Bin& bin : bins) {
    if (bin.expected > 0) {
      chi.value += (bin.observed - bin.expected) * (bin.observed - bin.expected) / bin.expected;
    }
  }
  chi.dof = static_cast<double>(bins.size()) - 1;
  return chi;
}

/// The mean and variance of a stream (Welford's algorithm).
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

/// Returns Welch's t of two means, which is a normal variable for the sample sizes used here
/// (hundreds and more). It is 0 if both are constant and equal.
inline double welch(const Moments& a, const Moments& b) {
  const double variance = a.variance() / a.n + b.variance() / b.n;
  if (variance == 0) return a.mean == b.mean ? 0 : 1e9;
  return (a.mean - b.mean) / std::sqrt(variance);
}

}  // namespace diaphane::render::test
