#pragma once

#include <map>
#include <string>

#include "api/shared/error_curves.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Workers with curves in memory, for tests.
class FakeErrorCurves final : public ErrorCurves, public Fake {
 public:
  std::map<std::string, ErrorCurve> curves;  ///< by worker and session ID: "worker/session"

  Result<ErrorCurve> find(const std::string& worker_id, const std::string& session_id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = curves.find(worker_id + "/" + session_id);
    if (found == curves.end()) return fail(ErrorCode::kNotFound, "no session");
    return found->second;
  }
};

}  // namespace diaphane::api
