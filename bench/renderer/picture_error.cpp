#include "bench/renderer/picture_error.h"

#include <algorithm>
#include <cmath>

namespace diaphane::render::bench {

double white_of(const std::vector<double>& mean, const std::vector<std::uint8_t>& contents) {
  std::vector<double> values;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    if (contents[i] != 0) values.insert(values.end(), &mean[3 * i], &mean[3 * i] + 3);
  }
  if (values.empty()) return 1;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at > 0 ? *at : 1;
}

double exact_tone(double x, bool filmic) {
  // The fit of ACES by Narkowicz.
  if (filmic && x > 0) x = (2.51 * x * x + 0.03 * x) / (2.43 * x * x + 0.59 * x + 0.14);
  return std::pow(std::clamp(x, 0.0, 1.0), 1 / 2.2);
}

PictureError error_against(const Reference& reference, const PictureRgbF& picture) {
  PictureError result;
  double squared = 0;
  std::uint64_t numbers = 0;
  for (std::size_t pixel = 0; pixel < reference.contents.size(); ++pixel) {
    result.pixels += reference.contents[pixel];
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const double x = static_cast<double>(picture.pixels[i]);
      if (!std::isfinite(x)) {
        ++result.non_finite;
      } else if (reference.contents[pixel] != 0) {
        const double off = exact_tone(x / reference.white, reference.filmic) -
                           exact_tone(reference.mean[i] / reference.white, reference.filmic);
        squared += off * off;
        ++numbers;
      }
    }
  }
  if (numbers > 0) result.rmse = std::sqrt(squared / static_cast<double>(numbers));
  return result;
}

double without_noise_of(const Reference& reference, double measured) {
  return std::sqrt(std::max(measured * measured - reference.error * reference.error, 0.0));
}

}  // namespace diaphane::render::bench
