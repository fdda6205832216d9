#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/shared/problem.h"
#include "tests/support/api/fake.h"

/// How tests of services read the errors.
namespace diaphane::api {

using Refusal = std::optional<ProblemKind>;

/// Returns nothing if the request succeeded.
template <typename T>
Refusal refusal(const Outcome<T>& outcome) {
  return outcome ? Refusal() : Refusal(outcome.error().kind);
}

/// Returns the name of the only invalid field, or an empty string for any other outcome.
template <typename T>
std::string invalid_field(const Outcome<T>& outcome) {
  const bool one = !outcome && outcome.error().kind == ProblemKind::kInvalid &&
                   outcome.error().fields.size() == 1;
  return one ? outcome.error().fields[0].field : "";
}

/// A function of a store that a request calls.
struct FailingStep {
  Fake& fake;
  std::string function;
  std::function<Refusal()> request;
};

/// Expects that a request fails as unavailable, and not in another way, if one of its steps does.
inline void expect_unavailable(const std::vector<FailingStep>& steps) {
  for (const FailingStep& step : steps) {
    const int before = step.fake.calls(step.function);
    step.fake.break_function(step.function);
    EXPECT_EQ(step.request(), ProblemKind::kUnavailable) << step.function;
    EXPECT_GT(step.fake.calls(step.function), before) << step.function;
    step.fake.repair(step.function);
  }
}

}  // namespace diaphane::api
