#pragma once

#include <array>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// One --label: how to show a label, which is given by its name or number.
struct LabelOption {
  std::string name;
  std::optional<std::array<std::uint8_t, 3>> colour;  ///< sRGB
  std::optional<double> opacity;
  bool solo = false;
};

/// Parses "NAME=LOOK", where LOOK has one or more of "#rrggbb", an opacity from 0 to 1 and "solo",
/// separated by commas. Returns nullopt for anything else.
std::optional<LabelOption> parse_label(const std::string& text);

/// Adds looks to a scene: the colours of the set for labels that somebody has marked and that the
/// scene does not list, and then what the options say. Fails with kInvalid if the set has no label,
/// or several, of that name.
Result<void> show_labels(const volume::LabelSet& set, const std::vector<LabelOption>& options,
                         diaphane::v1::Scene& scene);

/// Prints number, colour, volume and name of each label, one per line.
void list_labels(const volume::LabelSet& set, const volume::Header& header, std::ostream& out);

}  // namespace diaphane::render::cli
