#include <algorithm>

#include "api/accounts/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kLongestTokenName = 60;

nlohmann::ordered_json to_json(const ApiToken& token) {
  nlohmann::ordered_json json{{"id", token.id},
                              {"name", token.name},
                              {"scopes", nlohmann::ordered_json::array()},
                              {"created_at", rfc3339(token.created_at)},
                              {"expires_at", rfc3339(token.expires_at)},
                              {"used_at", nullptr}};
  for (const TokenScope scope : token.scopes) json["scopes"].push_back(to_string(scope));
  if (token.used_at) json["used_at"] = rfc3339(*token.used_at);
  return json;
}

/// Reads a list of different scopes that is not empty, and reports any other value as an error.
std::vector<TokenScope> scopes_in(Fields& in) {
  std::vector<TokenScope> scopes;
  const nlohmann::json& given = in.any("scopes");
  bool right = given.is_array() && !given.empty();
  if (right) {
    for (const nlohmann::json& one : given) {
      const auto scope = one.is_string() ? token_scope_of(one.get<std::string>()) : std::nullopt;
      right = right && scope && std::find(scopes.begin(), scopes.end(), *scope) == scopes.end();
      if (right) scopes.push_back(*scope);
    }
  }
  if (!right) in.wrong("scopes", "must list read, write, share or archive, each at most once");
  return scopes;
}

Outcome<Response> create_token(ApiTokens& tokens, const Request& request, const Principal& who) {
  Fields in(request);
  ApiTokens::Request wanted;
  wanted.name = in.name("name", 1, kLongestTokenName);
  wanted.scopes = scopes_in(in);
  wanted.days = static_cast<int>(in.integer("days", 1, ApiTokens::kMostDays));
  wanted.password = in.secret("password", kPasswordBytes);
  wanted.code = in.text_or("code", "", kCodeCharacters);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto created = tokens.create(who, wanted);
  DIAPHANE_TRY(created);
  nlohmann::ordered_json json = to_json(created->token);
  json["token"] = created->secret;
  return json_response(201, json);
}

Outcome<Response> list_tokens(ApiTokens& tokens, const Principal& who) {
  const auto found = tokens.list(who);
  DIAPHANE_TRY(found);
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const ApiToken& token : *found) items.push_back(to_json(token));
  return json_response(200, {{"items", std::move(items)}});
}

}  // namespace

std::vector<Route> api_token_routes(ApiTokens& tokens) {
  const auto list = [&tokens](const Request&, const Principal& who) {
    return list_tokens(tokens, who);
  };
  const auto create = [&tokens](const Request& request, const Principal& who) {
    return create_token(tokens, request, who);
  };
  const auto revoke = [&tokens](const Request& request, const Principal& who) {
    return answer(tokens.revoke(who, request.parameter("token_id")));
  };
  const std::string all = "/v1/me/tokens";
  constexpr auto kOwn = Access::kOwnAccount;
  return {
      {"GET", all, "listApiTokens", kOwn, list, {}},
      // Requires the consent, because without it a token could only read and delete.
      {"POST", all, "createApiToken", Access::kPerson, create, {}},
      {"DELETE", all + "/{token_id}", "revokeApiToken", kOwn, revoke, {}},
  };
}

}  // namespace diaphane::api
