#include "api/accounts/attempts.h"

#include <algorithm>

#include "api/shared/secrets.h"

namespace diaphane::api {

std::string attempt_key(std::string_view what, std::string_view whose) {
  return blake2b(std::string(what) + ":" + std::string(whose));
}

tl::unexpected<Problem> too_many_attempts(std::chrono::seconds wait) {
  const auto minutes = std::chrono::ceil<std::chrono::minutes>(wait).count();
  return refuse(ProblemKind::kTooManyAttempts,
                "Too many attempts. Try again in " + std::to_string(std::max<long>(minutes, 1)) +
                    (minutes > 1 ? " minutes." : " minute."),
                std::max(wait, std::chrono::seconds(1)));
}

}  // namespace diaphane::api
