#include "renderd/engine/cpu/denoise.h"

#include <algorithm>
#include <array>

#include "renderd/engine/cpu/denoise_pass.h"
#include "renderd/film/denoise.h"

namespace diaphane::render {
namespace {

using Plane = std::vector<float>;

class CpuDenoiser {
 public:
  CpuDenoiser(RendererThreads& threads, const DenoiseInput& input)
      : threads_(threads),
        input_(input),
        width_(input.size.width),
        height_(input.size.height),
        pixels_(std::size_t{width_} * height_) {
    for (auto* planes : {&raw_, &from_, &to_}) {
      for (Plane& plane : *planes) plane.resize(pixels_);
    }
    for (Plane& plane : steering_) plane.resize(pixels_);
  }

  std::vector<float> run() {
    by_rows([&](std::uint32_t y) { read_row(y); });
    if (input_.samples < 2) by_rows([&](std::uint32_t y) { deviate_from_neighbours(y); });
    by_rows([&](std::uint32_t y) { slope_row(y); });
    find_variance();
    from_ = raw_;
    for (std::uint32_t pass = 0; pass < kDenoisePasses; ++pass) {
      filter(1 << pass);
      std::swap(from_, to_);
    }
    sum_gains();
    std::vector<float> out(3 * pixels_);
    by_rows([&](std::uint32_t y) { blend_row(y, out); });
    return out;
  }

 private:
  using Smooth = std::array<Plane, DenoisePlanes::kSmoothed>;

  template <typename Row>
  void by_rows(const Row& row) {
    threads_.run(height_, row);
  }
  std::size_t at(std::uint32_t x, std::uint32_t y) const { return x + std::size_t{width_} * y; }

  static Smoothed smoothed_at(const Smooth& p, std::size_t i) {
    return {{p[0][i], p[1][i], p[2][i]}, p[3][i]};
  }
  Steering steering_at(std::size_t i) const {
    const auto& s = steering_;
    return {s[0][i], s[1][i], s[2][i], {s[4][i], s[5][i], s[6][i]}, {s[7][i], s[8][i], s[9][i]}};
  }

  void read_row(std::uint32_t y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      const std::size_t i = at(x, y);
      const PixelEstimate e = estimate_of(input_.film, i, input_.samples_of(y));
      const Smoothed m = to_be_smoothed(e, 1.0f / input_.white);
      const Guides g = unpack(input_.guides[i]);
      const Steering s =
          unpack(pack(steering_of(g, takes_part(input_.film, i, input_.samples_of(y), g))));
      const float smooth[] = {m.mean.x, m.mean.y, m.mean.z, m.deviation};
      for (std::size_t c = 0; c < 4; ++c) raw_[c][i] = smooth[c];
      const float steer[] = {s.takes_part, s.opacity,  s.depth,    0.0f,       s.albedo.x,
                             s.albedo.y,   s.albedo.z, s.normal.x, s.normal.y, s.normal.z};
      for (std::size_t c = 0; c < DenoisePlanes::kSteering; ++c) steering_[c][i] = steer[c];
    }
  }

  void deviate_from_neighbours(std::uint32_t y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      const std::size_t i = at(x, y);
      NeighbourDeviation deviation;
      const auto offer = [&](std::size_t j) {
        deviation.offer(smoothed_at(raw_, i), steering_at(i), smoothed_at(raw_, j), steering_at(j),
                        input_.voxel);
      };
      if (x + 1 < width_) offer(i + 1);
      if (y + 1 < height_) offer(i + width_);
      if (x > 0) offer(i - 1);
      if (y > 0) offer(i - width_);
      raw_[3][i] = deviation.value;
    }
  }

  void slope_row(std::uint32_t y) {
    const Plane& depth = steering_[2];
    for (std::uint32_t x = 0; x < width_; ++x) {
      const float here = depth[at(x, y)];
      const float across = slope_of(depth[at(x > 0            ? x - 1
                                             : x + 1 < width_ ? x + 1
                                                              : x,
                                             y)],
                                    here,
                                    depth[at(x + 1 < width_ ? x + 1
                                             : x > 0        ? x - 1
                                                            : x,
                                             y)]);
      const float down = slope_of(depth[at(x, y > 0             ? y - 1
                                              : y + 1 < height_ ? y + 1
                                                                : y)],
                                  here,
                                  depth[at(x, y + 1 < height_ ? y + 1
                                              : y > 0         ? y - 1
                                                              : y)]);
      steering_[3][at(x, y)] = across + down;
    }
  }

  void find_variance() {
    constexpr std::uint32_t kReach = kVarianceReach;
    Plane squares(pixels_), counts(pixels_);
    by_rows([&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        float sum = 0, count = 0;
        for (std::uint32_t k = x - std::min(x, kReach); k <= std::min(x + kReach, width_ - 1);
             ++k) {
          const float part = steering_[0][at(k, y)];
          sum += part * squared(raw_[3][at(k, y)]);
          count += part;
        }
        squares[at(x, y)] = sum;
        counts[at(x, y)] = count;
      }
    });
    by_rows([&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        float sum = 0, count = 0;
        for (std::uint32_t k = y - std::min(y, kReach); k <= std::min(y + kReach, height_ - 1);
             ++k) {
          sum += squares[at(x, k)];
          count += counts[at(x, k)];
        }
        raw_[4][at(x, y)] = count > 0 ? sum / count : 0.0f;
      }
    });
  }

  void filter(std::int32_t stride) {
    DenoisePlanes planes{width_, height_, {}, {}, {}};
    for (std::size_t c = 0; c < DenoisePlanes::kSmoothed; ++c) {
      planes.from[c] = from_[c].data();
      planes.to[c] = to_[c].data();
    }
    for (std::size_t c = 0; c < DenoisePlanes::kSteering; ++c) {
      planes.steering[c] = steering_[c].data();
    }
    const DenoiseRow row = denoise_row();
    by_rows([&](std::uint32_t y) {
      thread_local std::vector<float> scratch;
      scratch.resize((DenoisePlanes::kSmoothed + 1) * std::size_t{width_});
      row(planes, static_cast<std::int32_t>(y), stride, input_.voxel, scratch.data());
    });
  }

  void sum_gains() {
    tiles_x_ = (width_ + kGainTile - 1) / kGainTile;
    tiles_y_ = (height_ + kGainTile - 1) / kGainTile;
    gains_.assign(std::size_t{tiles_x_} * tiles_y_, Gain{0, 0});
    threads_.run(tiles_y_, [&](std::uint32_t ty) {
      for (std::uint32_t y = ty * kGainTile; y < std::min((ty + 1) * kGainTile, height_); ++y) {
        for (std::uint32_t x = 0; x < width_; ++x) {
          const std::size_t i = at(x, y);
          if (!(steering_[0][i] > 0)) continue;
          const Gain g = gain_of(smoothed_at(raw_, i), smoothed_at(from_, i));
          Gain& tile = gains_[x / kGainTile + std::size_t{tiles_x_} * ty];
          tile.less_noise += g.less_noise;
          tile.change += g.change;
        }
      }
    });
  }

  void blend_row(std::uint32_t y, std::vector<float>& out) const {
    const GainsView gains{gains_.data(), tiles_x_, tiles_y_};
    for (std::uint32_t x = 0; x < width_; ++x) {
      const std::size_t i = at(x, y);
      const Float3 raw = estimate_of(input_.film, i, input_.samples_of(y)).mean;
      const Float3 shown = steering_[0][i] > 0
                               ? blended(raw, smoothed_at(from_, i).mean * input_.white,
                                         input_.fade * share_of_filtered(gain_around(gains, x, y)))
                               : raw;
      out[3 * i] = shown.x;
      out[3 * i + 1] = shown.y;
      out[3 * i + 2] = shown.z;
    }
  }

  RendererThreads& threads_;
  const DenoiseInput input_;
  const std::uint32_t width_, height_;
  const std::size_t pixels_;
  Smooth raw_, from_, to_;
  std::array<Plane, DenoisePlanes::kSteering> steering_;
  std::vector<Gain> gains_;
  std::uint32_t tiles_x_ = 0, tiles_y_ = 0;
};

}  // namespace

std::vector<float> denoise(RendererThreads& threads, const DenoiseInput& input) {
  return CpuDenoiser(threads, input).run();
}

}  // namespace diaphane::render
