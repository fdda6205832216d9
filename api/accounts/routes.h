#pragma once

#include <vector>

#include "api/accounts/account_changes.h"
#include "api/accounts/accounts.h"
#include "api/accounts/api_tokens.h"
#include "api/accounts/second_factor.h"
#include "api/routing/request_router.h"
#include "api/sessions/render_time.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> account_routes(Accounts& accounts, RenderTime& render_time,
                                  const RequestRouter& router);
std::vector<Route> account_change_routes(AccountChanges& changes, const RequestRouter& router);
std::vector<Route> second_factor_routes(SecondFactors& factors);
std::vector<Route> api_token_routes(ApiTokens& tokens);

}  // namespace diaphane::api
