#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "api/annotations/annotations.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Saved marks in memory, for tests.
class FakeAnnotationStore final : public AnnotationStore, public Fake {
 public:
  std::vector<AnnotationSet> sets;

  Result<std::vector<AnnotationSet>> list(const std::string& data_set_id,
                                          const std::string& viewer_id) override {
    DIAPHANE_TRY(enter("list"));
    std::vector<AnnotationSet> found;
    for (AnnotationSet one : sets) {
      one.mine = one.author_id == viewer_id;
      if (one.data_set_id == data_set_id && (one.mine || one.shared)) found.push_back(one);
    }
    return found;
  }
  Result<void> add(const AnnotationSet& set, int most) override {
    DIAPHANE_TRY(enter("add"));
    if (std::ranges::count(sets, set.author_id, &AnnotationSet::author_id) >= most) {
      return fail(ErrorCode::kTooMany, "too many");
    }
    sets.push_back(set);
    return {};
  }
  Result<void> change(const AnnotationSet& set, const AnnotationChange& what, Time now) override {
    DIAPHANE_TRY(enter("change"));
    for (AnnotationSet& one : sets) {
      if (one.id != set.id || one.author_id != set.author_id) continue;
      if (what.revision && one.content != set.content) return fail(ErrorCode::kConflict, "changed");
      one.name = what.name.value_or(one.name);
      one.content = what.content.value_or(one.content);
      one.shown = what.shown.value_or(one.shown);
      one.shared = what.shared.value_or(one.shared);
      one.updated_at = now;
      return {};
    }
    return fail(ErrorCode::kNotFound, "none");
  }
  Result<void> remove(const AnnotationSet& set) override {
    DIAPHANE_TRY(enter("remove"));
    const auto gone = std::erase_if(sets, [&](const AnnotationSet& one) {
      return one.id == set.id && one.author_id == set.author_id;
    });
    return gone == 0 ? fail(ErrorCode::kNotFound, "none") : Result<void>();
  }
};

}  // namespace diaphane::api
