#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "api/shared/stills.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// A worker that renders every image at once, for tests. Thread-safe.
class FakeStills final : public Stills, public Fake {
 public:
  Result<std::string> render(const StillRequest& request) override {
    {
      const std::lock_guard lock(mutex_);
      requests_.push_back(request);
    }
    DIAPHANE_TRY(enter("render"));
    return "image of " + request.data_set_id + " " + request.preset + request.scene;
  }
  std::vector<StillRequest> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<StillRequest> requests_;
};

}  // namespace diaphane::api
