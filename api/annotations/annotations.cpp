#include "api/annotations/annotations.h"

#include <algorithm>
#include <utility>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_set() {
  return refuse(ProblemKind::kNotFound, "These marks no longer exist.");
}

tl::unexpected<Problem> changed_meanwhile() {
  return refuse(ProblemKind::kPrecondition,
                "These marks have changed in the meantime. Reload them before you change them.");
}

tl::unexpected<Problem> set_problem(const Error& error) {
  if (error.code == ErrorCode::kNotFound) return no_such_set();
  if (error.code == ErrorCode::kConflict) return changed_meanwhile();
  return refuse(error);
}

}  // namespace

std::string revision_of(const AnnotationSet& set) { return blake2b(set.content).substr(0, 32); }

Outcome<std::vector<AnnotationSet>> AnnotationSets::list(const Principal& who,
                                                         const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kLook));
  auto found = store_.list(data_set_id, who.user_id);
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<std::vector<AnnotationSet>> AnnotationSets::shared_of(const std::string& data_set_id) {
  auto found = store_.list(data_set_id, {});
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<AnnotationSet> AnnotationSets::find_own(const Principal& who,
                                                const std::string& data_set_id,
                                                const std::string& id) {
  auto found = list(who, data_set_id);
  DIAPHANE_TRY(found);
  const auto one = std::ranges::find(*found, id, &AnnotationSet::id);
  if (one == found->end()) return no_such_set();
  if (!one->mine) {
    return refuse(ProblemKind::kForbidden, "These marks belong to someone else.");
  }
  return std::move(*one);
}

Outcome<AnnotationSet> AnnotationSets::add(const Principal& who, const std::string& data_set_id,
                                           AnnotationSet set) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kSavePreset));
  if (set.shared) DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kDescribe));
  set.id = new_id();
  set.data_set_id = data_set_id;
  set.author_id = who.user_id;
  set.mine = true;
  set.created_at = set.updated_at = clock_.wall();
  const auto done = store_.add(set, kMostSets);
  if (!done && done.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kNotFound, "The scan has been deleted.");
  }
  if (!done) return set_problem(done.error());
  return set;
}

Outcome<AnnotationSet> AnnotationSets::change(const Principal& who, const std::string& data_set_id,
                                              const std::string& id, const AnnotationChange& what) {
  const auto set = find_own(who, data_set_id, id);
  if (!set) return set;
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kSavePreset));
  if (what.shared.value_or(false)) {
    DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kDescribe));
  }
  if (what.revision && *what.revision != revision_of(*set)) return changed_meanwhile();
  const auto done = store_.change(*set, what, clock_.wall());
  if (!done) return set_problem(done.error());
  return find_own(who, data_set_id, id);
}

Outcome<void> AnnotationSets::remove(const Principal& who, const std::string& data_set_id,
                                     const std::string& id) {
  const auto set = find_own(who, data_set_id, id);
  DIAPHANE_TRY(set);
  if (const auto done = store_.remove(*set); !done) return set_problem(done.error());
  return {};
}

}  // namespace diaphane::api
