#include "ingest/registration/register.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "common/try.h"
#include "ingest/registration/search.h"

namespace diaphane::ingest {
namespace {

/// Edges of the voxels of the levels, relative to those of the CoarseScan, and how many places are
/// compared.
struct Level {
  std::uint32_t factor;
  std::size_t places;
};
constexpr Level kCoarse{4, 6000}, kMiddle{2, 15000}, kFine{1, 40000};
constexpr double kLeastOverlap = 0.15;

tl::unexpected<Error> refused(const char* reason, const char* message) {
  return fail(ErrorCode::kUnsupported, message, reason);
}

double extent(const CoarseScan& scan, std::size_t axis) {
  return scan.spacing[axis] * scan.size[axis];
}
double box_of(const CoarseScan& scan) {
  return extent(scan, 0) * extent(scan, 1) * extent(scan, 2);
}

/// Returns a copy with fewer voxels.
CoarseScan shrunk(const CoarseScan& scan, std::uint32_t factor) {
  CoarseScan out = scan;
  std::array<std::uint32_t, 3> by{};
  const double least = *std::min_element(scan.spacing.begin(), scan.spacing.end());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double wanted = std::round(factor * least / scan.spacing[axis]);
    by[axis] = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, scan.size[axis] * 1.0));
    out.size[axis] = scan.size[axis] / by[axis];
    out.spacing[axis] = scan.spacing[axis] * by[axis];
  }
  out.origin = scan.point({(by[0] - 1) / 2.0, (by[1] - 1) / 2.0, (by[2] - 1) / 2.0});
  out.values.assign(std::size_t{out.size[0]} * out.size[1] * out.size[2], 0.0F);
  const float share = 1.0F / static_cast<float>(by[0] * by[1] * by[2]);
  for (std::uint32_t z = 0; z < out.size[2] * by[2]; ++z) {
    for (std::uint32_t y = 0; y < out.size[1] * by[1]; ++y) {
      const float* row = scan.values.data() + scan.size[0] * (y + std::size_t{scan.size[1]} * z);
      float* to =
          out.values.data() + out.size[0] * (y / by[1] + std::size_t{out.size[1]} * (z / by[2]));
      for (std::uint32_t x = 0; x < out.size[0] * by[0]; ++x) to[x / by[0]] += share * row[x];
    }
  }
  return out;
}

/// Limits the values to those of most voxels, so that the bins of the histogram are not spent on
/// metal and noise. Returns false if there is one value only.
bool limit_values(CoarseScan& scan) {
  std::vector<float> sorted = scan.values;
  const auto at = [&](double share) {
    const auto middle = sorted.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  };
  const float low = at(0.002), high = at(0.998);
  if (!(high > low)) return false;
  for (float& value : scan.values) value = std::clamp(value, low, high);
  return true;
}

Point centre_of_box(const CoarseScan& scan) {
  return scan.point({(scan.size[0] - 1) / 2.0, (scan.size[1] - 1) / 2.0, (scan.size[2] - 1) / 2.0});
}

/// Returns the centre of all that is above the mean value, which is the body in most scans.
Point centre_of_mass(const CoarseScan& scan) {
  double mean = 0;
  for (const float value : scan.values) mean += value;
  mean /= static_cast<double>(scan.values.size());
  std::array<double, 3> sum{};
  double count = 0;
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < scan.size[2]; ++z) {
    for (std::uint32_t y = 0; y < scan.size[1]; ++y) {
      for (std::uint32_t x = 0; x < scan.size[0]; ++x, ++i) {
        if (!(scan.values[i] > mean)) continue;
        sum = {sum[0] + x, sum[1] + y, sum[2] + z};
        count += 1;
      }
    }
  }
  if (count == 0) return centre_of_box(scan);
  return scan.point({sum[0] / count, sum[1] / count, sum[2] / count});
}

bool contains(const CoarseScan& scan, const Point& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double along = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      along += scan.direction[3 * row + axis] * (point[row] - scan.origin[row]);
    }
    if (along < 0 || along > scan.spacing[axis] * (scan.size[axis] - 1)) return false;
  }
  return true;
}

/// Returns random places in the box of a scan. Places between voxels, because a regular grid would
/// favour poses in which both grids coincide.
std::vector<Point> places_in(const CoarseScan& scan, std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point> places;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    places.push_back(
        scan.point({x * (scan.size[0] - 1), y * (scan.size[1] - 1), z * (scan.size[2] - 1)}));
  }
  return places;
}

/// Returns the places in every second cube of a chessboard, or in the others. Neighbouring voxels
/// are alike, so halves of single voxels would not be independent.
std::vector<Point> half_of(const std::vector<Point>& places, const CoarseScan& scan, int axis,
                           bool other) {
  constexpr double kCubes = 8;
  const double edge = std::cbrt(box_of(scan)) / kCubes;
  std::vector<Point> half;
  for (const Point& p : places) {
    long parity = axis;
    for (std::size_t i = 0; i < 3; ++i) {
      // The two chessboards are shifted by half a cube against each other.
      parity += std::lround(std::floor((p[i] - scan.origin[i]) / edge + 0.5 * axis));
    }
    if (((parity % 2) != 0) == other) half.push_back(p);
  }
  return half;
}

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The search for one pair of scans.
class Registration {
 public:
  Registration(const CoarseScan& fixed, const CoarseScan& moving, std::uint64_t seed)
      : fixed_(fixed), moving_(moving), random_(seed), centre_(centre_of_mass(fixed)) {
    // The mean distance of a place of a cube from its middle is 0.48 of its edge.
    radius_ = 0.48 * std::cbrt(std::min(box_of(fixed), box_of(moving)));
    step_ = std::cbrt(fixed.spacing[0] * fixed.spacing[1] * fixed.spacing[2]);
  }

  Result<RigidAlignment> run() {
    std::vector<Pose> best = coarse();
    const InformationSearch middle = search(kMiddle);
    Pose found = best.front();
    double most = -1;
    for (const Pose& start : best) {
      const Pose pose = middle.climb(start, 2 * step_);
      const double information = middle.information(pose);
      if (information > most) {
        most = information;
        found = pose;
      }
    }
    InformationSearch fine = search(kFine);
    RigidAlignment out;
    out.information_before = std::max(fine.information(Pose{}), 0.0);
    const Pose pose = fine.climb(found, step_);
    out.information = fine.information(pose);
    const volume::Matrix to_moving = matrix_of(pose, centre_);
    out.to_fixed = volume::inverse_of_rigid(to_moving);
    out.overlap = overlap(to_moving);
    if (out.overlap < kLeastOverlap) {
      return refused("little_overlap", "the two scans show too little of the same region");
    }
    out.residual_mm = residual(fine, pose, to_moving);
    const double smaller = std::cbrt(std::min(box_of(fixed_), box_of(moving_)));
    if (out.residual_mm > smaller / 20 || !stands_out(middle, pose)) {
      return refused("not_converged",
                     "no alignment of the two scans is clearly better than others");
    }
    return out;
  }

 private:
  InformationSearch search(const Level& level) {
    const CoarseScan fixed = shrunk(fixed_, level.factor);
    InformationSearch made(fixed, shrunk(moving_, level.factor), centre_, radius_);
    places_ = places_in(fixed, level.places, random_);
    made.set_places(places_);
    return made;
  }

  /// Climbs from all starts at the coarse level. Returns the best three.
  std::vector<Pose> coarse() {
    const InformationSearch search = this->search(kCoarse);
    std::vector<std::pair<double, Pose>> found;
    for (const Pose& start : starts()) {
      const Pose pose = search.climb(start, 4 * step_);
      found.emplace_back(search.information(pose), pose);
    }
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.first > b.first; });
    constexpr std::size_t kKept = 3;
    std::vector<Pose> best;
    for (std::size_t i = 0; i < std::min(kKept, found.size()); ++i) best.push_back(found[i].second);
    return best;
  }

  /// Returns the poses from which the search starts: first as the headers say.
  std::vector<Pose> starts() const {
    std::vector<Pose> poses{Pose{}};
    const auto add = [&](const Point& from, const Point& to, std::array<double, 3> versor) {
      // The rotation is about the centre, so its shift moves `from` to `to` if they are the
      // centres.
      poses.push_back(
          {versor[0], versor[1], versor[2], to[0] - from[0], to[1] - from[1], to[2] - from[2]});
    };
    add(centre_of_box(fixed_), centre_of_box(moving_), {});
    const Point mass = centre_of_mass(moving_);
    add(centre_, mass, {});
    const double tilt = std::sin(25 * std::numbers::pi / 180 / 2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        std::array<double, 3> versor{};
        versor[axis] = sign * tilt;
        add(centre_, mass, versor);
      }
    }
    return poses;
  }

  double overlap(const volume::Matrix& to_moving) const {
    const auto inside = std::count_if(places_.begin(), places_.end(), [&](const Point& p) {
      return contains(moving_, volume::moved(to_moving, p));
    });
    const double common =
        box_of(fixed_) * static_cast<double>(inside) / static_cast<double>(places_.size());
    return std::min(1.0, common / std::min(box_of(fixed_), box_of(moving_)));
  }

  double residual(InformationSearch& search, const Pose& whole, const volume::Matrix& to_moving) {
    double squares = 0;
    std::size_t count = 0;
    std::normal_distribution<double> push(0, step_ / std::sqrt(3.0));
    for (const int board : {0, 1}) {
      for (const bool other : {false, true}) {
        search.set_places(half_of(places_, fixed_, board, other));
        Pose start = whole;
        // The search must find its way back, or it would agree by not moving.
        for (std::size_t i = 0; i < 3; ++i) {
          start[i] += push(random_) / (2 * radius_);
          start[3 + i] += push(random_);
        }
        const volume::Matrix half = matrix_of(search.climb(start, step_), centre_);
        for (const Point& p : places_) {
          const Point q = volume::moved(to_moving, p);
          if (!contains(moving_, q)) continue;
          const double off = distance(volume::moved(half, p), q);
          squares += off * off;
          ++count;
        }
      }
    }
    return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 1e9;
  }

  /// Returns whether a pose has more information than poses far from it.
  bool stands_out(const InformationSearch& search, const Pose& pose) {
    const double here = search.information(pose);
    std::normal_distribution<double> gauss(0, 1);
    double most = 0;
    constexpr int kOthers = 24;
    for (int i = 0; i < kOthers; ++i) {
      Pose other = pose;
      std::array<double, 6> off{};
      double length = 0;
      for (double& o : off) {
        o = gauss(random_);
        length += o * o;
      }
      // Places move by about a third of the smaller scan.
      const double far = 2 * radius_ / 3 / std::sqrt(length);
      for (std::size_t k = 0; k < 6; ++k) other[k] += off[k] * far / (k < 3 ? 2 * radius_ : 1);
      most = std::max(most, search.information(other));
    }
    constexpr double kClearly = 1.1;
    return here > kClearly * most;
  }

  const CoarseScan& fixed_;
  const CoarseScan& moving_;
  std::mt19937_64 random_;
  Point centre_;
  double radius_ = 1, step_ = 1;
  std::vector<Point> places_;
};

}  // namespace

Result<RigidAlignment> register_rigid(const CoarseScan& fixed, const CoarseScan& moving,
                                      std::uint64_t seed) {
  CoarseScan a = fixed, b = moving;
  if (!limit_values(a) || !limit_values(b)) {
    return refused("no_structure", "a scan with one value only cannot be aligned");
  }
  return Registration(a, b, seed).run();
}

}  // namespace diaphane::ingest
