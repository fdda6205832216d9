#include "api/accounts/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

struct PasswordAndCode {
  std::string password, code;
};

Outcome<PasswordAndCode> read_both(const Request& request) {
  Fields in(request);
  PasswordAndCode given{in.secret("password", kPasswordBytes), in.text("code", 6, kCodeCharacters)};
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return given;
}

Outcome<Response> codes_response(const Outcome<std::vector<std::string>>& codes) {
  DIAPHANE_TRY(codes);
  return json_response(200, {{"recovery_codes", *codes}});
}

Outcome<Response> state_of(SecondFactors& factors, const Principal& who) {
  const auto state = factors.state(who);
  DIAPHANE_TRY(state);
  nlohmann::ordered_json json{{"set_up_at", nullptr},
                              {"recovery_codes", state->recovery_codes},
                              {"required", state->required}};
  if (state->set_up_at) json["set_up_at"] = rfc3339(*state->set_up_at);
  return json_response(200, json);
}

}  // namespace

std::vector<Route> second_factor_routes(SecondFactors& factors) {
  const auto get = [&factors](const Request&, const Principal& who) {
    return state_of(factors, who);
  };
  const auto begin = [&factors](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string password = in.secret("password", kPasswordBytes);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto made = factors.begin(who, password);
    DIAPHANE_TRY(made);
    return json_response(201, {{"secret", made->secret}, {"uri", made->uri}});
  };
  const auto confirm = [&factors](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string code = in.text("code", 6, kCodeCharacters);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return codes_response(factors.confirm(who, code));
  };
  const auto renew = [&factors](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto given = read_both(request);
    DIAPHANE_TRY(given);
    return codes_response(factors.renew_recovery_codes(who, given->password, given->code));
  };
  const auto remove = [&factors](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto given = read_both(request);
    DIAPHANE_TRY(given);
    const auto done = factors.remove(who, given->password, given->code);
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string all = "/v1/me/second-factor";
  constexpr auto kOwn = Access::kOwnAccount;
  return {
      {"GET", all, "getSecondFactor", kOwn, get, {}},
      {"POST", all, "beginSecondFactor", kOwn, begin, {}},
      {"POST", all + "/confirm", "confirmSecondFactor", kOwn, confirm, {}},
      {"POST", all + "/recovery-codes", "renewRecoveryCodes", kOwn, renew, {}},
      {"POST", all + "/removal", "removeSecondFactor", kOwn, remove, {}},
  };
}

}  // namespace diaphane::api
