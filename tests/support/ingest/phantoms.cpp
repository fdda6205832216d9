#include "tests/support/ingest/phantoms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <span>

#include "tests/support/volume/test_shapes.h"
#include "volume/labels.h"

namespace diaphane::ingest {
namespace {

using volume::ellipse;
using volume::ellipsoid;
using Place = std::array<double, 3>;  // mm from the middle: to the left, to the back, to the head

constexpr int kAir = -1000, kFoam = -880, kFlesh = 40, kFat = -90, kBone = 900, kShell = 60;

struct Sample {
  int value = kAir;
  std::uint8_t truth = 0;
};
constexpr Sample kNothing{};
Sample body(int value) { return {value, 1}; }
Sample support(int value) { return {value, 2}; }

using Scene = std::function<Sample(const Place&)>;

/// A head with a skull, airways, a nose and thin ears.
Sample head(const Place& p) {
  const double x = std::abs(p[0]);
  const bool airway = ellipsoid(p, {0, -50, -40}, {9, 40, 12}) < 1 ||
                      (std::hypot(p[0], p[1] + 15) < 8 && p[2] < -40);
  const double skin = ellipsoid(p, {0, 0, 0}, {75, 92, 95});
  const bool neck = p[2] < -40 && ellipse(p[0], p[1] - 10, 58, 60) < 1;
  const bool nose = ellipsoid(p, {0, -92, -25}, {11, 18, 22}) < 1;
  const bool ear = ellipsoid({x - 0.5 * p[1], p[1], p[2]}, {78, 10, -15}, {16, 4, 28}) < 1;
  if (airway && (skin < 1 || neck)) return {kAir, 0};
  if (skin < 0.85) return body(35);
  if (skin < 0.92) return body(kBone);
  return skin < 1 || neck || nose || ear ? body(kFlesh) : kNothing;
}

/// A trough of a plastic shell, lined with foam on which the head lies.
Sample headrest(const Place& p) {
  const double radius = std::hypot(p[0], p[1] - 12);
  if (p[1] < 50) return kNothing;
  if (radius > 104 && radius < 108) return support(150);
  return radius > 90 && radius <= 104 ? support(kFoam) : kNothing;
}

Sample either(const Sample& first, const Sample& second) {
  return first.truth != 0 ? first : second;
}

Sample head_on_rest(const Place& p) { return either(head(p), headrest(p)); }

/// A trunk with lungs and a spine, flattened at the back, and two arms beside it.
Sample trunk(const Place& p) {
  const double x = std::abs(p[0]);
  if (p[1] > 90) return kNothing;
  const double arm = std::hypot(x - 200, p[1] - 52);
  if (arm < 12) return body(kBone);
  if (arm < 38) return body(arm < 32 ? kFlesh : kFat);
  const double skin = ellipse(p[0], p[1], 155, 108);
  if (skin >= 1) return kNothing;
  if (std::hypot(p[0], p[1] - 60) < 20) return body(500);
  if (ellipse(x - 70, p[1] + 10, 50, 65) < 1 && p[2] > -60) return body(-850);
  return body(skin < 0.9 ? kFlesh : kFat);
}

/// A hollow table with skins of 3 mm, on which the trunk lies.
Sample table(const Place& p) {
  const double x = std::abs(p[0]);
  if (x > 235 || p[1] <= 90 || p[1] > 130) return kNothing;
  const bool skin = x > 232 || p[1] <= 93 || p[1] > 127;
  return skin ? support(kShell) : kNothing;
}

Sample trunk_on_table(const Place& p) { return either(trunk(p), table(p)); }

/// A trough, such as the top of many tables, that bends up beside the trunk.
Sample trunk_in_trough(const Place& p) {
  const double depth = 92 - p[0] * p[0] / 1400;
  if (std::abs(p[0]) < 250 && p[1] > depth && p[1] < depth + 4) return support(kShell);
  return p[1] < depth ? trunk({p[0], p[1] + 2, p[2]}) : kNothing;
}

/// A forearm and a hand with spread fingers on a thin table.
Sample hand_on_table(const Place& p) {
  if (p[1] > 14) {
    const bool shell = p[1] < 17 || (p[1] > 37 && p[1] < 40);
    return shell && std::abs(p[0]) < 140 ? support(kShell) : kNothing;
  }
  const double palm = ellipsoid(p, {0, 0, 0}, {44, 14, 55});
  const double forearm = p[2] < -40 ? ellipse(p[0], p[1] + 8, 30, 22) : 2;
  if (p[2] < -40 && std::hypot(std::abs(p[0]) - 14, p[1] + 8) < 6) return body(kBone);
  for (int finger = -2; finger <= 2; ++finger) {
    const double along = p[2] * std::cos(0.25 * finger) + p[0] * std::sin(0.25 * finger);
    const double across = p[0] * std::cos(0.25 * finger) - p[2] * std::sin(0.25 * finger);
    const double radius = std::hypot(across, p[1] - 6);
    if (along < 0 || along > 115) continue;
    if (radius < 3) return body(kBone);
    if (radius < 8) return body(kFlesh);
  }
  return palm < 1 || forearm < 1 ? body(kFlesh) : kNothing;
}

/// A stereotactic ring that four pins hold at the head, with bars.
Sample frame(const Place& p) {
  const double radius = std::hypot(p[0], p[1]);
  const double x = std::abs(p[0]), y = std::abs(p[1]);
  if (radius > 124 && radius < 132 && std::abs(p[2] + 50) < 5) return support(700);
  if (std::hypot(x - 90.5, y - 90.5) < 5 && p[2] > -50) return support(700);
  const bool pin = std::abs(x - y) < 3 && std::abs(p[2] - 20) < 2 && x > 40 && x < 90;
  return pin ? support(1500) : kNothing;
}

Scene turned(const Scene& scene, double degrees) {
  const double a = degrees * 3.14159265358979 / 180;
  const double c = std::cos(a), s = std::sin(a);
  return [=](const Place& p) {
    const Place q{c * p[0] + s * p[1], -s * p[0] + c * p[1], p[2]};
    return scene({q[0], c * q[1] + s * q[2], -s * q[1] + c * q[2]});
  };
}

/// The scene at another size, with the table of a grown-up.
Scene small_trunk_on_table(double scale) {
  return [=](const Place& p) {
    const Sample trunk_sample = trunk({p[0] / scale, p[1] / scale, p[2] / scale});
    return either(trunk_sample, table({p[0], p[1] + 90 * (1 - scale), p[2]}));
  };
}

Scene turned_over(const Scene& scene) {
  return [=](const Place& p) { return scene({-p[0], -p[1], p[2]}); };
}

struct Grid {
  Place mm{2, 2, 2};  // spacing along patient axes
  Place size_mm{240, 280, 220};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

Phantom sampled(const Scene& scene, const Grid& grid, volume::Modality modality) {
  Phantom phantom;
  volume::Header& header = phantom.volume.header;
  header.modality = modality;
  header.direction = grid.direction;
  for (std::size_t v = 0; v < 3; ++v) {
    double size = 0;
    header.spacing[v] = 0;
    for (std::size_t p = 0; p < 3; ++p) {
      const double share = std::abs(grid.direction[3 * p + v]);
      header.spacing[v] += share * grid.mm[p];
      size += share * grid.size_mm[p];
    }
    header.size[v] = static_cast<std::uint32_t>(size / header.spacing[v] + 1e-6);
  }
  std::minstd_rand random(7);
  std::normal_distribution<double> noise(0, 10);
  phantom.volume.voxels.reserve(header.voxel_count());
  phantom.truth.reserve(header.voxel_count());
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
        const Sample sample = scene(place);
        const double value = std::max(-1024.0, sample.value + noise(random));
        phantom.volume.voxels.push_back(static_cast<std::int16_t>(value));
        phantom.truth.push_back(sample.truth);
      }
    }
  }
  volume::measure(phantom.volume);
  return phantom;
}

/// Makes MR of a CT: dark bone, the noise of a magnitude image, and a bias of `bias` from front to
/// back.
void become_mr(Phantom& phantom, double noise_level, double bias) {
  phantom.volume.header.modality = volume::Modality::kMr;
  const auto& size = phantom.volume.header.size;
  std::minstd_rand random(11);
  std::normal_distribution<double> noise(0, noise_level);
  for (std::size_t i = 0; i < phantom.volume.voxels.size(); ++i) {
    auto& value = phantom.volume.voxels[i];
    const bool bone = value > 600 && phantom.truth[i] == 1;
    const double signal = value < -700 ? 0 : bone ? 25 : 300;
    const double y = static_cast<double>(i / size[0] % size[1]) / size[1];
    const double biased = signal * (1 - bias * y);
    value = static_cast<std::int16_t>(std::hypot(biased + noise(random), noise(random)));
  }
  volume::measure(phantom.volume);
}

void become_bytes(Phantom& phantom) {
  for (auto& value : phantom.volume.voxels) {
    value = static_cast<std::int16_t>(std::clamp((value + 1000) / 8, 0, 255));
  }
  volume::measure(phantom.volume);
}

const Grid kHeadGrid{};
const Grid kTrunkGrid{{2, 2, 2.5}, {480, 290, 250}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};

Phantom ct(const Scene& scene, const Grid& grid) {
  return sampled(scene, grid, volume::Modality::kCt);
}

Phantom mr_in_frame() {
  Grid grid = kHeadGrid;
  grid.size_mm = {280, 280, 220};
  Phantom phantom = ct([](const Place& p) { return either(head(p), frame(p)); }, grid);
  become_mr(phantom, 12, 0.5);
  return phantom;
}

Phantom of_bytes(const Scene& scene, const Grid& grid) {
  Phantom phantom = ct(scene, grid);
  become_bytes(phantom);
  return phantom;
}

Grid with(Grid grid, const Place& size_mm) {
  grid.size_mm = size_mm;
  return grid;
}

struct Entry {
  const char* name;
  Phantom (*make)();
};

const Entry kEntries[] = {
    {"head on a headrest", [] { return ct(head_on_rest, kHeadGrid); }},
    {"head on a headrest, turned 5 degrees", [] { return ct(turned(head_on_rest, 5), kHeadGrid); }},
    {"head on a headrest, 8 bit", [] { return of_bytes(head_on_rest, kHeadGrid); }},
    {"head on a headrest, 0.5 x 0.5 x 5 mm",
     [] {
       return ct(head_on_rest, {{0.5, 0.5, 5}, kHeadGrid.size_mm, kHeadGrid.direction});
     }},
    {"trunk and arms on a table", [] { return ct(trunk_on_table, kTrunkGrid); }},
    {"trunk and arms on a table, turned 3 degrees",
     [] {
       return ct(turned(trunk_on_table, 3), with(kTrunkGrid, {500, 320, 250}));
     }},
    {"trunk and arms on a table, 8 bit", [] { return of_bytes(trunk_on_table, kTrunkGrid); }},
    {"trunk and arms on a table, coronal slices from the head",
     [] {
       return ct(trunk_on_table, {kTrunkGrid.mm, kTrunkGrid.size_mm, {1, 0, 0, 0, 0, 1, 0, -1, 0}});
     }},
    {"trunk and arms on a table, prone",
     [] { return ct(turned_over(trunk_on_table), kTrunkGrid); }},
    {"trunk and arms of a child on a table",
     [] {
       return ct(small_trunk_on_table(0.6), with(kTrunkGrid, {480, 220, 150}));
     }},
    {"hand on a table",
     [] {
       return ct(hand_on_table, {{1, 1, 1}, {160, 110, 240}, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
     }},
    {"trunk in a trough",
     [] {
       return ct(trunk_in_trough, with(kTrunkGrid, {520, 290, 250}));
     }},
    {"trunk on a table, cut by the field of view",
     [] {
       return ct(trunk_on_table, with(kTrunkGrid, {250, 240, 200}));
     }},
    {"trunk and arms without a table", [] { return ct(trunk, kTrunkGrid); }},
    {"head without a headrest", [] { return ct(head, kHeadGrid); }},
    {"MR head in a frame", mr_in_frame},
    {"MR head",
     [] {
       Phantom phantom = ct(head, kHeadGrid);
       become_mr(phantom, 12, 0.6);
       return phantom;
     }},
};

const Entry kLargeEntries[] = {
    {"trunk and arms on a table, 256 x 256 x 256",
     [] {
       return ct(trunk_on_table, {{1.9, 1.2, 1}, {486.4, 307.2, 256}, kTrunkGrid.direction});
     }},
    {"trunk and arms on a table, 512 x 512 x 400",
     [] {
       return ct(trunk_on_table, {{0.95, 0.95, 0.8}, {486.4, 486.4, 320}, kTrunkGrid.direction});
     }},
};

std::vector<std::string> names_of(std::span<const Entry> entries) {
  std::vector<std::string> names;
  for (const Entry& entry : entries) names.emplace_back(entry.name);
  return names;
}

}  // namespace

std::vector<std::string> phantom_names() { return names_of(kEntries); }

std::vector<std::string> large_phantom_names() { return names_of(kLargeEntries); }

Phantom make_phantom(const std::string& name) {
  for (const std::span<const Entry> entries :
       {std::span<const Entry>(kEntries), std::span<const Entry>(kLargeEntries)}) {
    for (const Entry& entry : entries) {
      if (entry.name != name) continue;
      Phantom phantom = entry.make();
      phantom.name = name;
      return phantom;
    }
  }
  return {};
}

Agreement agreement(const Phantom& phantom, const std::vector<std::uint8_t>& labels) {
  std::array<double, 3> all{}, hit{};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::uint8_t truth = phantom.truth[i];
    ++all[truth];
    hit[truth] += volume::is_body(labels[i]) == (truth == 1) ? 1 : 0;
  }
  return {all[1] > 0 ? hit[1] / all[1] : 1, all[2] > 0 ? hit[2] / all[2] : 1};
}

}  // namespace diaphane::ingest
