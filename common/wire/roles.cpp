#include "common/wire/roles.h"

#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "common/try.h"

namespace diaphane::wire {
namespace {

constexpr std::array kRoles{Role::kApi, Role::kGateway, Role::kRenderd, Role::kOperator};

}  // namespace

std::string_view to_string(Role role) {
  switch (role) {
    case Role::kApi:
      return "api";
    case Role::kGateway:
      return "gateway";
    case Role::kRenderd:
      return "renderd";
    case Role::kOperator:
      break;
  }
  return "operator";
}

std::string role_uri(Role role) { return "spiffe://diaphane/" + std::string(to_string(role)); }

bool has_role(const std::vector<std::string>& uris, Role role) {
  return std::find(uris.begin(), uris.end(), role_uri(role)) != uris.end();
}

std::string describe_roles(const std::vector<std::string>& uris) {
  std::string names;
  for (const Role role : kRoles) {
    if (!has_role(uris, role)) continue;
    names += (names.empty() ? "the role " : ", ") + std::string(to_string(role));
  }
  return names.empty() ? "no role" : names;
}

Result<std::vector<std::string>> uris_of(const std::string& certificate_file) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> file(BIO_new_file(certificate_file.c_str(), "r"),
                                                       &BIO_free);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      file ? PEM_read_bio_X509(file.get(), nullptr, nullptr, nullptr) : nullptr, &X509_free);
  if (!certificate) {
    return fail(ErrorCode::kInvalid, certificate_file + " contains no PEM certificate");
  }
  const std::unique_ptr<GENERAL_NAMES, decltype(&GENERAL_NAMES_free)> names(
      static_cast<GENERAL_NAMES*>(
          X509_get_ext_d2i(certificate.get(), NID_subject_alt_name, nullptr, nullptr)),
      &GENERAL_NAMES_free);
  std::vector<std::string> uris;
  for (int i = 0; i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type != GEN_URI) continue;
    const ASN1_IA5STRING* uri = name->d.uniformResourceIdentifier;
    uris.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(uri)),
                      static_cast<std::size_t>(ASN1_STRING_length(uri)));
  }
  return uris;
}

Result<void> check_role(const std::string& certificate_file, Role role) {
  const auto uris = uris_of(certificate_file);
  DIAPHANE_TRY(uris);
  if (has_role(*uris, role)) return {};
  return fail(ErrorCode::kInvalid,
              certificate_file + " has " + describe_roles(*uris) + ", but this program needs " +
                  "the role " + std::string(to_string(role)) + ". Issue it with the URI " +
                  role_uri(role) +
                  " among its subject alternative names, or set --inner-tls-roles 0 to accept "
                  "certificates without roles. See docs/security.md.");
}

}  // namespace diaphane::wire
