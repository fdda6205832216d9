#include "ingest/body/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace diaphane::ingest {
namespace {

constexpr std::size_t kTerms = 7;
constexpr std::size_t kMostColumns = 2000;
constexpr std::size_t kLeastColumns = 60;
constexpr double kInlierMm = 2;
constexpr double kLeastInliers = 0.15;  // the body may hide most of a surface
constexpr double kMostBefore = 0.15;    // share of samples in front of a surface

struct Sample {
  double u = 0, z = 0, depth = 0;  // mm
};

std::array<double, kTerms> basis(const Surface& s, double u, double z) {
  const double a = (u - s.middle) / s.half, b = (z - s.along_middle) / s.along_half;
  return {1, a, a * a, a * a * a, a * a * a * a, b, a * b};
}

/// Solves the normal equations by Gaussian elimination. Returns false if they are singular.
bool solve(std::array<std::array<double, kTerms + 1>, kTerms>& m,
           std::array<double, kTerms>& result) {
  for (std::size_t i = 0; i < kTerms; ++i) {
    std::size_t pivot = i;
    for (std::size_t r = i + 1; r < kTerms; ++r) {
      if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
    }
    if (std::abs(m[pivot][i]) < 1e-9) return false;
    std::swap(m[i], m[pivot]);
    for (std::size_t r = 0; r < kTerms; ++r) {
      if (r == i) continue;
      const double factor = m[r][i] / m[i][i];
      for (std::size_t c = i; c <= kTerms; ++c) m[r][c] -= factor * m[i][c];
    }
  }
  for (std::size_t i = 0; i < kTerms; ++i) result[i] = m[i][kTerms] / m[i][i];
  return true;
}

enum class Shape { kTrough, kAny };  // polynomial of degree 2 or 4 across

bool least_squares(Surface& surface, Shape shape, const std::vector<Sample>& samples,
                   const std::vector<double>& weights) {
  std::array<std::array<double, kTerms + 1>, kTerms> m{};
  double sum = 0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const auto row = basis(surface, samples[s].u, samples[s].z);
    for (std::size_t i = 0; i < kTerms; ++i) {
      for (std::size_t j = i; j < kTerms; ++j) m[i][j] += weights[s] * row[i] * row[j];
      m[i][kTerms] += weights[s] * row[i] * samples[s].depth;
    }
    sum += weights[s];
  }
  for (std::size_t i = 0; i < kTerms; ++i) {
    for (std::size_t j = 0; j < i; ++j) m[i][j] = m[j][i];
  }
  // A slight ridge regularisation keeps the gap below the body smooth.
  for (std::size_t i = 1; i < kTerms; ++i) m[i][i] += 1e-4 * sum;
  if (shape == Shape::kTrough) {
    for (const std::size_t i : {3, 4}) m[i][i] += 1e6 * sum;
  }
  return solve(m, surface.terms);
}

double error(const Surface& surface, const Sample& sample) {
  return sample.depth - surface.depth(sample.u, sample.z);
}

/// Refits the surface `kSteps` times to samples that are weighted by their errors.
template <typename Weight>
bool refit(Surface& surface, Shape shape, const std::vector<Sample>& samples, Weight weight) {
  constexpr int kSteps = 12;
  std::vector<double> weights(samples.size());
  for (int step = 0; step < kSteps; ++step) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      weights[i] = weight(error(surface, samples[i]));
    }
    if (!least_squares(surface, shape, samples, weights)) return false;
  }
  return true;
}

/// Returns the share of samples on the surface, or 0 if many lie in front of it, because then it is
/// the lower skin of a hollow table.
double quality(const Surface& surface, const std::vector<Sample>& samples) {
  double on = 0, before = 0;
  for (const Sample& sample : samples) {
    const double e = error(surface, sample);
    on += std::abs(e) <= kInlierMm ? 1 : 0;
    before += e < -kInlierMm ? 1 : 0;
  }
  const auto n = static_cast<double>(samples.size());
  return before > kMostBefore * n || on < kLeastColumns ? 0 : on / n;
}

/// Fits the surface robustly. The samples that do not fit are rails, the lower skin of a hollow
/// table below the body, or a body part that was not recognised.
bool robust_fit(Surface& surface, const std::vector<Sample>& samples) {
  Surface best = surface;
  double most = 0;
  for (const Shape shape : {Shape::kTrough, Shape::kAny}) {
    // Weights of the samples behind the surface, from a mean surface to the front of all samples.
    for (const double behind : {1.0, 0.2, 0.05}) {
      Surface next = surface;
      if (!least_squares(next, shape, samples, std::vector<double>(samples.size(), 1)) ||
          !refit(next, shape, samples,
                 [&](double e) { return (e > 0 ? behind : 1) / std::max(1.0, std::abs(e)); }) ||
          !refit(next, shape, samples,
                 [](double e) { return std::abs(e) <= 2 * kInlierMm ? 1.0 : 1e-6; })) {
        continue;
      }
      const double share = quality(next, samples);
      // Prefers the simpler shape, which is safer where the body hides the surface.
      if (share <= (shape == Shape::kAny ? 1.1 : 1) * most) continue;
      most = share;
      best = next;
    }
  }
  surface = best;
  return most >= kLeastInliers;
}

/// Reads voxels by their position along the patient's axes.
class PatientVoxels {
 public:
  PatientVoxels(const volume::Volume& volume, const Cells& cells) : volume_(volume) {
    const std::array<std::size_t, 3> strides{
        1, volume.header.size[0], std::size_t{volume.header.size[0]} * volume.header.size[1]};
    for (std::size_t p = 0; p < 3; ++p) {
      const std::size_t v = cells.axis[p];
      size_[p] = static_cast<int>(volume.header.size[v]);
      stride_[p] = static_cast<std::ptrdiff_t>(strides[v]);
      mm_[p] = volume.header.spacing[v];
      if (cells.flipped[p]) {
        first_ += stride_[p] * (size_[p] - 1);
        stride_[p] = -stride_[p];
      }
    }
  }
  int index(std::size_t p, double mm) const {
    return std::clamp(static_cast<int>(mm / mm_[p]), 0, size_[p] - 1);
  }
  int size(std::size_t p) const { return size_[p]; }
  double mm(std::size_t p) const { return mm_[p]; }
  int value(const std::array<int, 3>& i) const {
    return volume_.voxels[static_cast<std::size_t>(first_ + i[0] * stride_[0] + i[1] * stride_[1] +
                                                   i[2] * stride_[2])];
  }

 private:
  const volume::Volume& volume_;
  std::array<int, 3> size_{};
  std::array<std::ptrdiff_t, 3> stride_{};
  std::array<double, 3> mm_{};
  std::ptrdiff_t first_ = 0;
};

/// Returns the depth of the first voxel of matter at the front of a cell, in mm.
std::optional<double> front_of(const PatientVoxels& voxels, const Cells& cells, int threshold,
                               const Surface& surface, const std::array<int, 3>& place) {
  const std::size_t d = surface.deep;
  const int step = surface.sign > 0 ? 1 : -1;
  const auto middle = middle_of(cells, place);
  std::array<int, 3> at{voxels.index(0, middle[0]), voxels.index(1, middle[1]),
                        voxels.index(2, middle[2])};
  const int per = cells.voxels_per_cell[d];
  at[d] -= step * per;
  for (int i = 0; i <= 2 * per; ++i, at[d] += step) {
    if (at[d] < 0 || at[d] >= voxels.size(d) || voxels.value(at) < threshold) continue;
    // Returns the depth of the voxel's face towards the body.
    return surface.sign * (at[d] + (step > 0 ? 0 : 1)) * voxels.mm(d);
  }
  return std::nullopt;
}

void choose_direction(Surface& surface, const Cells& cells, const CellList& members,
                      const std::array<double, 3>& body_middle) {
  std::array<double, 2> from{};
  for (const std::size_t cell : members) {
    const auto at = middle_of(cells, cells.place(cell));
    for (std::size_t p = 0; p < 2; ++p) from[p] += at[p] - body_middle[p];
  }
  surface.deep = std::abs(from[0]) > 2 * std::abs(from[1]) ? 0 : 1;
  surface.across = 1 - surface.deep;
  surface.sign = from[surface.deep] > 0 ? 1 : -1;
}

}  // namespace

double Surface::depth(double u, double z) const {
  const auto row = basis(*this, u, z);
  double sum = 0;
  for (std::size_t i = 0; i < row.size(); ++i) sum += row[i] * terms[i];
  return sum;
}

double Surface::behind(const std::array<double, 3>& place) const {
  const double u = place[across];
  if (u < low || u > high) return -std::numeric_limits<double>::infinity();
  return sign * place[deep] - depth(u, place[2]);
}

CellsBehind::CellsBehind(const Surface& surface, const Cells& cells)
    : across_(surface.across),
      deep_(surface.deep),
      width_(static_cast<std::size_t>(cells.size[across_])),
      step_(surface.sign * cells.mm[deep_]),
      depths_(width_ * static_cast<std::size_t>(cells.size[2])) {
  for (std::size_t i = 0; i < depths_.size(); ++i) {
    const double u = (static_cast<double>(i % width_) + 0.5) * cells.mm[across_];
    const std::size_t row = i / width_;
    const double z = (static_cast<double>(row) + 0.5) * cells.mm[2];
    depths_[i] = u < surface.low || u > surface.high ? std::numeric_limits<double>::infinity()
                                                     : surface.depth(u, z);
  }
}

std::optional<Surface> fit_surface(const volume::Volume& volume, const Cells& cells, int threshold,
                                   const CellList& members,
                                   const std::array<double, 3>& body_middle) {
  Surface surface;
  choose_direction(surface, cells, members, body_middle);
  // Finds the first cell of each column from the body's side.
  std::map<std::pair<int, int>, int> fronts;
  for (const std::size_t cell : members) {
    const auto at = cells.place(cell);
    const int depth = at[surface.deep];
    const auto [entry, added] = fronts.try_emplace({at[surface.across], at[2]}, depth);
    if (!added && (depth - entry->second) * surface.sign < 0) entry->second = depth;
  }
  const PatientVoxels voxels(volume, cells);
  const std::size_t step = fronts.size() / kMostColumns + 1;
  std::vector<Sample> samples;
  std::size_t n = 0;
  for (const auto& [column, depth] : fronts) {
    if (n++ % step != 0) continue;
    std::array<int, 3> place{};
    place[surface.across] = column.first;
    place[surface.deep] = depth;
    place[2] = column.second;
    const auto at = middle_of(cells, place);
    const auto front = front_of(voxels, cells, threshold, surface, place);
    if (front) samples.push_back({at[surface.across], at[2], *front});
  }
  if (samples.size() < kLeastColumns) return std::nullopt;
  const auto [first, last] = std::minmax_element(
      samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.u < b.u; });
  surface.low = first->u;
  surface.high = last->u;
  surface.middle = (surface.low + surface.high) / 2;
  surface.half = std::max(1.0, (surface.high - surface.low) / 2);
  surface.along_middle = cells.size[2] * cells.mm[2] / 2;
  surface.along_half = std::max(1.0, surface.along_middle);
  if (!robust_fit(surface, samples)) return std::nullopt;
  return surface;
}

}  // namespace diaphane::ingest
