#include "api/scans/scan_labels.h"

#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> labels_busy() {
  return refuse(ProblemKind::kConflict,
                "Earlier labels of this scan are still being processed. Wait until they are done, "
                "then try again.");
}

std::string whole_megabytes(std::int64_t bytes) {
  constexpr std::int64_t kMegabyte = 1'000'000;
  return std::to_string((bytes + kMegabyte - 1) / kMegabyte) + " MB";
}

}  // namespace

Outcome<DataSet> ScanLabels::find(const Principal& who, const std::string& id) {
  auto found = data_sets_.authorise(who, id, Action::kDescribe);
  DIAPHANE_TRY(found);
  if (found->state != DataSetState::kReady) {
    return refuse(ProblemKind::kNotReady, "This scan is not ready yet. Its state is " +
                                              std::string(to_string(found->state)) + ".");
  }
  if (found->labels.placing) return labels_busy();
  return found;
}

Outcome<DataSet> ScanLabels::announce(const Principal& who, const std::string& id,
                                      std::int64_t bytes) {
  DIAPHANE_TRY(find(who, id));
  if (bytes > max_bytes_) {
    return refuse(ProblemKind::kUploadTooLarge,
                  "A file of labels can have at most " + whole_megabytes(max_bytes_) + ".");
  }
  const auto now = clock_.wall();
  const auto begun = store_.begin(
      {new_id(), id, {who.user_id}, bytes, now + data_sets_.options().upload_life}, now);
  if (!begun && begun.error().code == ErrorCode::kConflict) return labels_busy();
  if (!begun) return refuse(begun.error());
  if (const auto* over = std::get_if<OverQuota>(&*begun)) {
    return refuse(ProblemKind::kOverQuota,
                  "These labels need " + whole_megabytes(bytes) + ", but " +
                      whole_megabytes(over->quota.used) + " of your " +
                      whole_megabytes(over->quota.bytes) +
                      " of storage are already in use. Delete other scans first.");
  }
  signals_.raise(Signal::kDisposal);
  return data_sets_.find(who, id);
}

Outcome<void> ScanLabels::remove(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(find(who, id));
  const auto removed = store_.remove(
      {who.user_id}, id, [&] { return remove_file_(id); }, clock_.wall());
  if (!removed && removed.error().code == ErrorCode::kConflict) return labels_busy();
  if (!removed) return refuse(removed.error());
  signals_.raise(Signal::kDisposal);
  return {};
}

}  // namespace diaphane::api
