#include "bench/renderer/synthetic_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <vector>

#include "renderd/math/random.h"

namespace diaphane::render::bench {
namespace {

constexpr double kExtent = 244.992;                 // mm, along x and y
constexpr double kHeight = kExtent * 0.6612244898;  // along z

/// Returns 0 to 1 for a place in units of the volume's extent, from -1 to 1 along each axis.
double head(double x, double y, double z) {
  const double r = std::sqrt(x * x / 0.58 + y * y / 0.72 + z * z / 0.82);
  const double shell = 1 - std::abs(r - 0.9) / 0.07;
  const double opening = std::hypot(x - 0.3, z - 0.1) < 0.2 && y > 0 ? 1 : 0;
  const double jaw = z < -0.45 && r < 0.85 ? std::sin(38 * x) * std::sin(33 * y) * 2 - 0.7 : 0;
  const double vessel = 1 - std::abs(std::hypot(x - 0.3 * std::sin(5 * z), y - 0.25) - 0.35) / 0.02;
  const double lump = 1.2 - std::hypot(x + 0.25, y - 0.1, z) / 0.16;
  return std::max({shell * (1 - opening), jaw, r < 0.8 ? 0.5 * vessel : 0.0, lump, 0.0});
}

volume::Volume made(std::array<std::uint32_t, 3> size) {
  volume::Volume v;
  v.header.size = size;
  for (std::size_t i = 0; i < 3; ++i) {
    v.header.spacing[i] = (i == 2 ? kHeight : kExtent) / v.header.size[i];
  }
  v.voxels.resize(v.header.voxel_count());
  const auto along = [&](std::uint32_t i, std::size_t axis) {
    return 2 * (i + 0.5) / v.header.size[axis] - 1;
  };
  const auto fill_slice = [&](std::uint32_t z) {
    std::int16_t* to = v.voxels.data() + std::size_t{z} * size[1] * size[0];
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      Random random(1, y, z);
      for (std::uint32_t x = 0; x < size[0]; ++x) {
        const double solid = head(along(x, 0), along(y, 1), along(z, 2));
        const double noisy = solid > 0 ? solid * 1.6 + 0.2 * (random.one() - 0.5) : 0;
        *to++ = static_cast<std::int16_t>(std::lround(30000 * std::clamp(noisy, 0.0, 1.0)));
      }
    }
  };
  // 1024^3 takes a minute on one core. Each row has its own random numbers, so rows are
  // independent.
  const std::uint32_t workers = std::clamp(std::thread::hardware_concurrency(), 1u, size[2]);
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t w = 0; w < workers; ++w) {
      threads.emplace_back([&, w] {
        for (std::uint32_t z = w; z < size[2]; z += workers) fill_slice(z);
      });
    }
  }
  volume::measure(v);
  return v;
}

}  // namespace

volume::Volume synthetic_volume(std::uint32_t n) { return made({n, n, std::max(1u, n * 27 / 64)}); }

volume::Volume synthetic_cube(std::uint32_t n) { return made({n, n, n}); }

Result<volume::Volume> named_volume(const std::string& name) {
  if (name != "made" && !name.starts_with("made:")) return volume::read(name, false);
  const unsigned long n = name == "made" ? 128 : std::strtoul(name.c_str() + 5, nullptr, 10);
  if (n < 16 || n > 2048) {
    return fail(ErrorCode::kInvalid, "made:N has N from 16 to 2048", "--volume");
  }
  return synthetic_volume(static_cast<std::uint32_t>(n));
}

}  // namespace diaphane::render::bench
