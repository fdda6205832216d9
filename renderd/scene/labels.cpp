#include "renderd/scene/labels.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>

#include "renderd/scene/frame.h"

namespace diaphane::render {
namespace {

const diaphane::v1::LabelLook* look_of(const diaphane::v1::Scene& scene, std::uint32_t number) {
  const auto found = std::find_if(scene.labels().begin(), scene.labels().end(),
                                  [number](const auto& look) { return look.number() == number; });
  return found == scene.labels().end() ? nullptr : &*found;
}

/// Returns whether any label or the voxels of no label are shown differently.
bool fill_looks(const diaphane::v1::Scene& scene, const LabelGrid& grid, PreparedLabels& out) {
  const bool alone =
      std::any_of(grid.numbers.begin(), grid.numbers.end(), [&](std::uint32_t number) {
        const auto* look = look_of(scene, number);
        return look != nullptr && look->solo();
      });
  out.looks.fill(kUnchangedLook);
  bool changes = false;
  for (std::size_t label = 0; label <= grid.numbers.size(); ++label) {
    const auto* given = look_of(scene, label == 0 ? 0 : grid.numbers[label - 1]);
    LabelLook& look = out.looks[label];
    if (given != nullptr && given->has_colour()) look.colour = colour_of(given->colour());
    if (given != nullptr && given->has_opacity()) {
      look.opacity = static_cast<float>(given->opacity());
    }
    if (alone && (given == nullptr || !given->solo())) look.opacity = 0;
    changes = changes || look.opacity != 1 || !(look.colour.x < 0);
  }
  return changes;
}

LabelRange range_of(const std::bitset<256>& set, const std::array<LabelLook, 256>& looks) {
  LabelRange range{1, 0};
  for (std::size_t label = 0; label < looks.size(); ++label) {
    if (!set.test(label)) continue;
    range.least = std::min(range.least, looks[label].opacity);
    range.most = std::max(range.most, looks[label].opacity);
  }
  return range;
}

}  // namespace

std::shared_ptr<const PreparedLabels> prepare_labels(const diaphane::v1::Scene& scene,
                                                     const PreparedTransfer& transfer,
                                                     const LabelGrid& grid, Int3 size,
                                                     Float3 spacing) {
  if (grid.empty() || scene.labels().empty()) return nullptr;
  auto out = std::make_shared<PreparedLabels>();
  if (!fill_looks(scene, grid, *out)) return nullptr;
  for (const auto& set : grid.sets) out->ranges.push_back(range_of(set, out->looks));
  if (transfer.bounds.empty()) return out;
  out->bounds = transfer.bounds;
  for (std::size_t cell = 0; cell < out->bounds.size(); ++cell) {
    const LabelRange range = out->ranges[grid.set_of_cell[cell]];
    out->bounds[cell].minorant *= range.least;
    out->bounds[cell].majorant *= range.most;
  }
  out->steep = is_steep(out->bounds, spacing);
  out->occupied = occupied_box(out->bounds, transfer.cells, size);
  return out;
}

bool have_same_labels(const diaphane::v1::Scene& a, const diaphane::v1::Scene& b) {
  return std::equal(a.labels().begin(), a.labels().end(), b.labels().begin(), b.labels().end(),
                    [](const auto& x, const auto& y) {
                      return google::protobuf::util::MessageDifferencer::Equals(x, y);
                    });
}

}  // namespace diaphane::render
