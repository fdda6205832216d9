#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace diaphane::api {

/// What an API token permits. No scope includes another.
enum class TokenScope {
  kRead,     ///< list, view and render scans
  kWrite,    ///< upload, edit and delete scans and what is saved with them
  kShare,    ///< decide who may see scans
  kArchive,  ///< search and fetch from the hospital's archives, and receive scans from them
};

inline constexpr std::array<TokenScope, 4> kTokenScopes{TokenScope::kRead, TokenScope::kWrite,
                                                        TokenScope::kShare, TokenScope::kArchive};

std::string_view to_string(TokenScope scope);
std::optional<TokenScope> token_scope_of(std::string_view text);

/// Converts between scopes and their stored form, "read write", in the order of kTokenScopes.
std::string join_scopes(const std::vector<TokenScope>& scopes);
std::vector<TokenScope> split_scopes(std::string_view text);

/// Returns the scope that a token needs for an operation of api/openapi.yaml. An operation that is
/// not listed, such as one of an account's security or of the administration, is never open to
/// tokens.
std::optional<TokenScope> scope_of_operation(std::string_view operation);

}  // namespace diaphane::api
