#include "renderd/cli/labels.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "volume/labels.h"

namespace diaphane::render::cli {
namespace {

std::optional<std::array<std::uint8_t, 3>> parse_colour(std::string_view text) {
  std::array<std::uint8_t, 3> colour{};
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i) {
    const char* from = text.data() + 1 + 2 * i;
    const auto [end, error] = std::from_chars(from, from + 2, colour[i], 16);
    if (error != std::errc{} || end != from + 2) return std::nullopt;
  }
  return colour;
}

std::optional<double> parse_opacity(std::string_view text) {
  double opacity = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, opacity);
  if (error != std::errc{} || end != last || !(opacity >= 0 && opacity <= 1)) return std::nullopt;
  return opacity;
}

void set_colour(const std::array<std::uint8_t, 3>& colour, diaphane::v1::Rgb* to) {
  // The inverse of the display's gamma.
  const auto linear = [](std::uint8_t c) { return std::pow(c / 255.0, 2.2); };
  to->set_r(linear(colour[0]));
  to->set_g(linear(colour[1]));
  to->set_b(linear(colour[2]));
}

/// Returns the numbers that an option means: those of the labels of this name, or else this number.
std::vector<std::uint32_t> numbers_of(const volume::LabelSet& set, const std::string& name) {
  std::vector<std::uint32_t> found;
  for (const auto& entry : set.table) {
    if (volume::name_of(entry) == name) found.push_back(entry.number);
  }
  if (!found.empty()) return found;
  for (const auto& entry : set.table) {
    if (std::to_string(entry.number) == name) found.push_back(entry.number);
  }
  if (name == "0") found.push_back(0);
  return found;
}

diaphane::v1::LabelLook& look_of(diaphane::v1::Scene& scene, std::uint32_t number) {
  for (auto& look : *scene.mutable_labels()) {
    if (look.number() == number) return look;
  }
  auto& look = *scene.add_labels();
  look.set_number(number);
  return look;
}

}  // namespace

std::optional<LabelOption> parse_label(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return std::nullopt;
  LabelOption option{.name = text.substr(0, equals), .colour = {}, .opacity = {}};
  std::string_view rest = std::string_view(text).substr(equals + 1);
  while (true) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view part = rest.substr(0, comma);
    if (const auto colour = parse_colour(part)) {
      option.colour = colour;
    } else if (const auto opacity = parse_opacity(part)) {
      option.opacity = opacity;
    } else if (part == "solo") {
      option.solo = true;
    } else {
      return std::nullopt;
    }
    if (comma == rest.size()) return option;
    rest.remove_prefix(comma + 1);
  }
}

Result<void> show_labels(const volume::LabelSet& set, const std::vector<LabelOption>& options,
                         diaphane::v1::Scene& scene) {
  for (const auto& entry : set.table) {
    const auto is_listed =
        std::any_of(scene.labels().begin(), scene.labels().end(),
                    [&](const auto& look) { return look.number() == entry.number; });
    const bool is_marked = volume::found_part(entry.number) == nullptr;
    if (!is_listed && is_marked)
      set_colour(entry.colour, look_of(scene, entry.number).mutable_colour());
  }
  for (const LabelOption& option : options) {
    const auto numbers = numbers_of(set, option.name);
    if (numbers.size() != 1) {
      return fail(ErrorCode::kInvalid,
                  numbers.empty() ? "the labels have none called '" + option.name +
                                        "'; --list-labels prints their names and numbers"
                                  : "several labels are called '" + option.name +
                                        "'; give the number that --list-labels prints",
                  "--label");
    }
    auto& look = look_of(scene, numbers.front());
    if (option.colour) set_colour(*option.colour, look.mutable_colour());
    if (option.opacity) look.set_opacity(*option.opacity);
    if (option.solo) look.set_solo(true);
  }
  return {};
}

void list_labels(const volume::LabelSet& set, const volume::Header& header, std::ostream& out) {
  std::array<std::uint64_t, 256> counts{};
  for (const std::uint8_t label : set.labels.voxels) ++counts[label];
  const double millilitres = header.spacing[0] * header.spacing[1] * header.spacing[2] / 1000;
  for (std::size_t i = 0; i < set.table.size(); ++i) {
    const auto& entry = set.table[i];
    char text[64];
    std::snprintf(text, sizeof text, "%u\t#%02x%02x%02x\t%.1f ml\t", entry.number,
                  unsigned{entry.colour[0]}, unsigned{entry.colour[1]}, unsigned{entry.colour[2]},
                  static_cast<double>(counts[i + 1]) * millilitres);
    out << text << volume::name_of(entry) << '\n';
  }
}

}  // namespace diaphane::render::cli
