#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace diaphane::wire {

/// The purpose of a certificate of Diaphane's CA. The certificate has one URI among its subject
/// alternative names for each of its roles.
enum class Role { kApi, kGateway, kRenderd, kOperator };

/// Returns the name of the role, such as "gateway".
std::string_view to_string(Role role);
/// Returns the URI of the role, such as "spiffe://diaphane/gateway".
std::string role_uri(Role role);

/// Returns whether one of a certificate's URIs is that of the role.
bool has_role(const std::vector<std::string>& uris, Role role);

/// Returns the roles among `uris`, in words for a message: "no role" or "the role api".
std::string describe_roles(const std::vector<std::string>& uris);

/// Returns the URIs among the subject alternative names of the first certificate of a PEM file.
/// Returns kInvalid if the file contains no certificate.
Result<std::vector<std::string>> uris_of(const std::string& certificate_file);

/// Checks that the certificate has the role. Returns kInvalid, with advice, if it lacks it.
Result<void> check_role(const std::string& certificate_file, Role role);

}  // namespace diaphane::wire
