#include "api/scans/anonymise.h"

#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> not_ready(DataSetState state) {
  return refuse(ProblemKind::kNotReady,
                "This scan is not ready yet. Its state is " + std::string(to_string(state)) + ".");
}

}  // namespace

Outcome<Anonymise::View> Anonymise::get(const Principal& who, const std::string& id) {
  auto found = data_sets_.authorise(who, id, Action::kAnonymise);
  DIAPHANE_TRY(found);
  auto facts = store_.facts(id);
  if (!facts) return refuse(facts.error());
  View view{*std::move(found), *std::move(facts), {}};
  if (view.data_set.state == DataSetState::kReady) view.volume_hash = stored_hash_(id);
  return view;
}

Outcome<Anonymise::View> Anonymise::cut(const Principal& who, const std::string& id,
                                        const std::string& region, const std::string& volume_hash) {
  const auto view = get(who, id);
  if (!view) return view;
  if (view->data_set.state != DataSetState::kReady) return not_ready(view->data_set.state);
  if (view->volume_hash != volume_hash) {
    return refuse(ProblemKind::kPrecondition,
                  "The scan has changed since you reviewed it. Review it again first.");
  }
  const auto ordered = store_.order({id, region, volume_hash, who.user_id}, clock_.wall());
  if (!ordered && ordered.error().code == ErrorCode::kConflict) {
    return not_ready(DataSetState::kQueued);
  }
  if (!ordered) return refuse(ordered.error());
  // The data set can no longer be opened. Its sessions and thumbnails still show the old voxels, so
  // they are removed if possible. Workers detect the new volume, and older images are not served.
  if (const auto ended = placement_.end_all_of(id); !ended) {
    log::warning("failed to end the sessions of a scan that is to be anonymised",
                 {{"data_set", id}});
  }
  (void)thumbnails_.remove(id);
  signals_.raise(Signal::kDisposal);
  return get(who, id);
}

}  // namespace diaphane::api
