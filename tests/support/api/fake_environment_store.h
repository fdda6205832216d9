#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "api/environments/environments.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Environments in memory.
class FakeEnvironmentStore final : public EnvironmentStore, public Fake {
 public:
  std::vector<Environment> environments;

  Result<std::vector<Environment>> of(const std::string& owner_id) override {
    DIAPHANE_TRY(enter("of"));
    std::vector<Environment> found;
    std::ranges::copy_if(environments, std::back_inserter(found),
                         [&](const Environment& one) { return one.owner_id == owner_id; });
    return found;
  }
  Result<Environment> find(const std::string& id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = std::ranges::find(environments, id, &Environment::id);
    if (found == environments.end()) return fail(ErrorCode::kNotFound, "none");
    return *found;
  }
  Result<void> add(const Environment& environment, int most) override {
    DIAPHANE_TRY(enter("add"));
    if (std::ranges::count(environments, environment.owner_id, &Environment::owner_id) >= most) {
      return fail(ErrorCode::kTooMany, "too many");
    }
    environments.push_back(environment);
    environments.back().mine = false;
    return {};
  }
  Result<void> rename(const std::string& owner_id, const std::string& id,
                      const std::string& name) override {
    DIAPHANE_TRY(enter("rename"));
    for (Environment& one : environments) {
      if (one.owner_id != owner_id || one.id != id) continue;
      one.name = name;
      return {};
    }
    return fail(ErrorCode::kNotFound, "none");
  }
  Result<void> remove(const std::string& owner_id, const std::string& id) override {
    DIAPHANE_TRY(enter("remove"));
    const auto gone = std::erase_if(environments, [&](const Environment& one) {
      return one.owner_id == owner_id && one.id == id;
    });
    if (gone == 0) return fail(ErrorCode::kNotFound, "none");
    return {};
  }
};

/// Imports any file unchanged.
class FakeImporter final : public PanoramaImporter, public Fake {
 public:
  Result<ImportedPanorama> import(const std::string& file) override {
    DIAPHANE_TRY(enter("import"));
    return ImportedPanorama{file, "00"};
  }
};

}  // namespace diaphane::api
