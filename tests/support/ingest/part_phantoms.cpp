#include "tests/support/ingest/part_phantoms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "tests/support/volume/test_shapes.h"

namespace diaphane::ingest {
namespace {

using volume::ellipse;
using volume::ellipsoid;
using volume::Label;
using Place = std::array<double, 3>;  // mm from the middle: to the left, to the back, to the head

struct Matter {
  int value = -1000;
  Label label = Label::kOutside;
};
using Anatomy = std::function<Matter(const Place&)>;

Matter soft(int value) { return {value, Label::kBody}; }
Matter bone(int value) { return {value, Label::kBone}; }

constexpr int kCortex = 700, kMuscle = 50, kFatHu = -100;
constexpr double kVertebra = 34, kDisc = 6;  // mm, heights

/// Vertebrae with a cortex and marrow, discs, and the bony arch around the spinal canal.
Matter spine(const Place& p, int marrow) {
  const double radius = std::hypot(p[0], p[1] - 50);
  const double along = p[2] - kVertebra * std::floor(p[2] / kVertebra);
  if (radius < 17) {
    if (along < kDisc) return soft(80);
    return bone(radius > 14.5 || along < kDisc + 2.5 || along > kVertebra - 2.5 ? kCortex : marrow);
  }
  const double arch = std::hypot(p[0], p[1] - 76);
  return arch > 8 && arch < 12 && along > 12 ? bone(kCortex) : Matter{};
}

/// Slanting ribs with a cortex and marrow. `skin` is below 1 inside the body.
Matter rib(const Place& p, double skin) {
  const double height = p[2] - 0.25 * p[1];
  const double along = height - 26 * std::round(height / 26);
  const double radius = std::hypot(along, 120 * (skin - 0.88));
  if (radius > 6 || p[1] > 80) return {};
  return bone(radius > 3.5 || p[1] > 77 ? kCortex : 90);
}

/// Returns the distance from a line between two places.
double from_line(const Place& p, const Place& a, const Place& b) {
  double along = 0, length = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    along += (p[i] - a[i]) * (b[i] - a[i]);
    length += (b[i] - a[i]) * (b[i] - a[i]);
  }
  const double t = std::clamp(along / length, 0.0, 1.0);
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += std::pow(p[i] - a[i] - t * (b[i] - a[i]), 2);
  return std::sqrt(sum);
}

/// Lungs with vessels that fan out from their roots, and around the bronchi.
Matter lung(const Place& p) {
  const double x = std::abs(p[0]);
  if (ellipsoid({x, p[1], p[2]}, {72, -5, -15}, {56, 72, 115}) >= 1 || x < 20) return {};
  const double up = std::atan2(p[2] + 15, x - 20), back = std::atan2(p[1], x - 20);
  const double reach = std::hypot(x - 20, p[1], p[2] + 15);
  const double radius = reach * std::hypot(std::remainder(up, 0.35), std::remainder(back, 0.35));
  if (radius < 2.2 && reach > 25) return soft(40);
  const double texture = std::sin(0.5 * p[0]) * std::sin(0.4 * p[1]) * std::sin(0.45 * p[2]);
  return {static_cast<int>(-860 + 40 * texture), Label::kLung};
}

Matter airway(const Place& p) {
  const Place carina{0, 8, 25};
  const double x = std::abs(p[0]);
  const double windpipe = from_line(p, {0, 0, 160}, carina);
  const double bronchus = from_line({x, p[1], p[2]}, carina, {48, 8, -20});
  if (windpipe < 8 || bronchus < 6) return {-1000, Label::kAirway};
  return windpipe < 10 || bronchus < 8 ? soft(kMuscle) : Matter{};
}

Matter blood_vessel(const Place& p, int blood) {
  const double heart = ellipsoid(p, {22, -35, -70}, {44, 36, 48});
  const double chamber = ellipsoid(p, {22, -35, -70}, {34, 26, 38});
  const double aorta = std::min(from_line(p, {24, 34, -160}, {24, 34, 50}),
                                from_line(p, {24, 34, 50}, {4, -30, 50}));
  const bool rising = from_line(p, {4, -30, 50}, {10, -32, -60}) < 12;
  if (chamber < 1 || aorta < 11 || rising) {
    return {blood, blood > 150 ? Label::kVessel : Label::kBody};
  }
  return heart < 1 || aorta < 13 ? soft(kMuscle) : Matter{};
}

Matter first_of(std::initializer_list<Matter> candidates) {
  for (const Matter& matter : candidates) {
    if (matter.label != Label::kOutside) return matter;
  }
  return {};
}

PartPhantom sampled(const Anatomy& anatomy, const Place& size_mm, const ChestOptions& options) {
  PartPhantom phantom;
  volume::Header& header = phantom.volume.header;
  header.modality = volume::Modality::kCt;
  header.spacing = options.spacing;
  header.direction = options.direction;
  for (std::size_t v = 0; v < 3; ++v) {
    double mm = 0;
    for (std::size_t p = 0; p < 3; ++p) mm += std::abs(header.direction[3 * p + v]) * size_mm[p];
    header.size[v] = static_cast<std::uint32_t>(mm / header.spacing[v]);
  }
  std::minstd_rand random(5);
  std::normal_distribution<double> noise(0, options.noise);
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x) {
        const std::array<std::uint32_t, 3> index{x, y, z};
        Place place{};
        for (std::size_t p = 0; p < 3; ++p) {
          for (std::size_t v = 0; v < 3; ++v) {
            place[p] += header.direction[3 * p + v] * header.spacing[v] *
                        (index[v] + 0.5 - header.size[v] / 2.0);
          }
        }
        const Matter matter = anatomy(place);
        phantom.volume.voxels.push_back(
            static_cast<std::int16_t>(std::max(-1024.0, matter.value + noise(random))));
        phantom.truth.push_back(matter.label);
      }
    }
  }
  volume::measure(phantom.volume);
  return phantom;
}

}  // namespace

PartPhantom chest(const ChestOptions& options) {
  const auto anatomy = [&](const Place& p) -> Matter {
    const double skin = ellipse(p[0], p[1], 155, 105);
    if (skin >= 1) return {};
    const Matter found =
        first_of({spine(p, options.marrow), rib(p, skin), airway(p), blood_vessel(p, options.blood),
                  skin < 0.82 ? lung(p) : Matter{}});
    if (found.label != Label::kOutside) return found;
    return soft(skin > 0.95 ? kFatHu : kMuscle);
  };
  return sampled(anatomy, {330, 230, 270}, options);
}

PartPhantom abdomen(int bowel) {
  const auto anatomy = [=](const Place& p) -> Matter {
    const double skin = ellipse(p[0], p[1], 150, 105);
    if (skin >= 1) return {};
    if (const Matter found = spine(p, 170); found.label != Label::kOutside) return found;
    const double colon = std::hypot(std::abs(p[0]) - 100, p[1]);
    if (colon < 24) return soft(p[0] > 0 ? -1000 : static_cast<int>(-560 + 30 * std::sin(p[2])));
    const double stomach = ellipsoid(p, {0, -30, 40}, {55, 40, 50});
    if (stomach < 1) return soft(p[1] < -38 ? -1000 : bowel);
    const bool duodenum = std::abs(p[0]) < 6 && p[1] > 0 && p[1] < 50 && std::abs(p[2] - 40) < 10;
    if (duodenum) return soft(bowel);
    return soft(skin > 0.9 ? kFatHu : kMuscle);
  };
  return sampled(anatomy, {330, 230, 210}, {});
}

double dice(const PartPhantom& phantom, const volume::Labels& labels, Label label) {
  double both = 0, all = 0;
  for (std::size_t i = 0; i < phantom.truth.size(); ++i) {
    const bool is_true = phantom.truth[i] == label;
    const bool is_found = labels.voxels[i] == static_cast<std::uint8_t>(label);
    both += is_true && is_found ? 1 : 0;
    all += (is_true ? 1 : 0) + (is_found ? 1 : 0);
  }
  return all > 0 ? 2 * both / all : 1;
}

}  // namespace diaphane::ingest
