#include "api/scans/alignments.h"

#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> not_yours() {
  return refuse(ProblemKind::kForbidden, "Only the owner of one of the two scans can align them.");
}

/// Returns where the origin of a volume's world coordinates, the middle of its box, is in the
/// patient's coordinates.
std::array<double, 3> middle_of(const volume::Header& header) {
  std::array<double, 3> middle = volume::first_voxel(header);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half = header.spacing[axis] * (static_cast<double>(header.size[axis]) - 1) / 2;
      middle[row] += header.direction[3 * row + axis] * half;
    }
  }
  return middle;
}

volume::Matrix shift_by(const std::array<double, 3>& by, double sign) {
  return {1, 0, 0, sign * by[0], 0, 1, 0, sign * by[1], 0, 0, 1, sign * by[2], 0, 0, 0, 1};
}

volume::Matrix between_pictures(const volume::Header& first, const volume::Header& second,
                                const volume::Matrix& matrix) {
  return volume::product(shift_by(middle_of(first), -1),
                         volume::product(matrix, shift_by(middle_of(second), 1)));
}

}  // namespace

Outcome<bool> Alignments::check(const Principal& who, const std::string& first,
                                const std::string& second) {
  const auto one = data_sets_.find_ready(who, first);
  DIAPHANE_TRY(one);
  const auto other = data_sets_.find_ready(who, second);
  DIAPHANE_TRY(other);
  if (first == second) {
    return refuse(ProblemKind::kConflict, "These are the same scan. Choose another one.");
  }
  return one->owned() || other->owned();
}

Outcome<Alignment> Alignments::find(const Principal& who, const std::string& first,
                                    const std::string& second) {
  const auto owned = check(who, first, second);
  DIAPHANE_TRY(owned);
  auto found = store_.find(first, second);
  if (!found) return refuse(found.error());
  found->may_align = *owned;
  if (found->state == "ready") {
    const auto one = header_(first), other = header_(second);
    if (one && other) found->scene_matrix = between_pictures(*one, *other, found->matrix);
  }
  return *std::move(found);
}

Outcome<Alignments::Requested> Alignments::request(const Principal& who, const std::string& first,
                                                   const std::string& second) {
  auto known = find(who, first, second);
  DIAPHANE_TRY(known);
  if (known->shares_frame || (known->state != "none" && known->state != "failed")) {
    return Requested{*std::move(known), false};
  }
  if (!known->may_align) return not_yours();
  const auto done = store_.request(who.user_id, first, second, kMostUnfinished, clock_.wall());
  if (!done) return refuse(done.error());
  if (*done == AlignmentStore::Request::kTooMany) {
    return refuse(ProblemKind::kTooMany,
                  "Other scans of yours are still being aligned. Wait until one of them is ready.",
                  std::chrono::seconds(10));
  }
  if (*done == AlignmentStore::Request::kNotReady) {
    return refuse(ProblemKind::kNotReady, "One of the scans is not ready.");
  }
  auto made = find(who, first, second);
  DIAPHANE_TRY(made);
  return Requested{*std::move(made), *done == AlignmentStore::Request::kMade};
}

Outcome<void> Alignments::remove(const Principal& who, const std::string& first,
                                 const std::string& second) {
  const auto owned = check(who, first, second);
  DIAPHANE_TRY(owned);
  if (!*owned) return not_yours();
  const auto done = store_.remove(first, second);
  if (!done) return refuse(done.error());
  if (!*done) return refuse(ProblemKind::kNotFound, "These scans have not been aligned.");
  return {};
}

Outcome<std::string> Alignments::motion(const Principal& who, const std::string& first,
                                        const std::string& second) {
  const auto found = find(who, first, second);
  DIAPHANE_TRY(found);
  if (found->shares_frame) return std::string();
  if (found->state != "ready") {
    return refuse(ProblemKind::kNotAligned,
                  "These scans have no common frame of reference. Align them first.");
  }
  return volume::text_of(found->matrix);
}

}  // namespace diaphane::api
