#include "ingest/build/image_axes.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

namespace diaphane::ingest {
namespace {

using Axes = std::array<double, 9>;

std::string trim(const std::string& text) {
  const auto is_space = [](unsigned char c) { return std::isspace(c) != 0; };
  const auto begin = std::find_if_not(text.begin(), text.end(), is_space);
  const auto end = std::find_if_not(text.rbegin(), text.rend(), is_space).base();
  return begin < end ? std::string(begin, end) : std::string();
}

/// The lines "key<separator>value" at the beginning of a file, up to `last_key` or an empty line.
class HeaderText {
 public:
  HeaderText(const std::string& path, char separator, const std::string& last_key) {
    std::ifstream in(path, std::ios::binary);
    std::string line;
    constexpr int kMostLines = 300;
    constexpr std::size_t kLongestLine = 4096;
    for (int n = 0; n < kMostLines && std::getline(in, line) && line.size() < kLongestLine; ++n) {
      if (trim(line).empty()) break;
      const std::size_t at = line.find(separator);
      if (at == std::string::npos) continue;
      const std::string key = trim(line.substr(0, at));
      lines_.emplace_back(key, trim(line.substr(at + 1)));
      if (key == last_key) break;
    }
  }
  std::optional<std::string> get(const std::string& key) const {
    for (const auto& [name, value] : lines_) {
      if (name == key) return value;
    }
    return std::nullopt;
  }

 private:
  std::vector<std::pair<std::string, std::string>> lines_;
};

/// Numbers between any of blanks, commas and brackets.
std::vector<double> numbers(std::string text) {
  for (char& c : text) {
    if (c == '(' || c == ')' || c == ',') c = ' ';
  }
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> values;
  for (double value = 0; in >> value;) values.push_back(value);
  return values;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

Axes ras_to_lps(Axes axes) {
  for (std::size_t i = 0; i < 6; ++i) axes[i] = -axes[i];
  return axes;
}

Result<std::optional<Axes>> meta_image_axes(const std::string& path) {
  const HeaderText header(path, '=', "ElementDataFile");
  const auto matrix = header.get("TransformMatrix") ? header.get("TransformMatrix")
                      : header.get("Rotation")      ? header.get("Rotation")
                                                    : header.get("Orientation");
  if (!matrix) return std::nullopt;
  const std::vector<double> m = numbers(*matrix);
  const auto spacing_text =
      header.get("ElementSpacing") ? header.get("ElementSpacing") : header.get("ElementSize");
  const std::vector<double> spacing = numbers(spacing_text.value_or("1 1 1"));
  if (m.size() != 9 || spacing.size() != 3 || !all_finite(m) || !all_finite(spacing)) {
    return fail(ErrorCode::kInvalid, "the axes of the image make no sense");
  }
  Axes axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // One axis after another, each a column of ours.
    for (std::size_t row = 0; row < 3; ++row) {
      axes[3 * row + axis] = m[3 * axis + row] * std::abs(spacing[axis]);
    }
  }
  return axes;
}

Result<std::optional<Axes>> nrrd_axes(const std::string& path) {
  const HeaderText header(path, ':', "");
  const auto directions = header.get("space directions");
  const auto space = header.get("space");
  if (!directions) {
    if (space) return fail(ErrorCode::kUnsupported, "the axes of the image are not given");
    return std::nullopt;
  }
  const std::vector<double> m = numbers(*directions);
  if (m.size() != 9 || !all_finite(m)) {
    return fail(ErrorCode::kUnsupported, "only images of three dimensions in space are read");
  }
  Axes axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) axes[3 * row + axis] = m[3 * axis + row];
  }
  const std::string name = space.value_or("");
  if (name == "left-posterior-superior" || name == "LPS") return axes;
  if (name == "right-anterior-superior" || name == "RAS") return ras_to_lps(axes);
  if (name.empty() || name == "3D-right-handed") return axes;
  return fail(ErrorCode::kUnsupported, "images in this space are not read; LPS and RAS are");
}

}  // namespace diaphane::ingest
