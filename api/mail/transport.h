#pragma once

#include <memory>
#include <string>

#include "api/accounts/mailer.h"
#include "common/result.h"

namespace diaphane::api {

/// Opens the transport of a setting: `file:DIRECTORY` (one .eml file per email, for single machines
/// and tests), `smtp://[user:password@]host:port` (STARTTLS if the server offers it) or
/// `smtps://…`. `from` is the sender's address. Returns kInvalid for anything else. The error
/// message never contains the password.
Result<std::unique_ptr<MailTransport>> open_mail_transport(const std::string& setting,
                                                           const std::string& from);

/// Returns the email as RFC 5322 text with CRLF line ends. Line breaks in an address or a subject
/// become spaces. `date` must be in RFC 5322 form.
std::string message_of(const Mail& mail, const std::string& from, const std::string& date,
                       const std::string& message_id);

}  // namespace diaphane::api
