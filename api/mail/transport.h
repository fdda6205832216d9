#pragma once

#include <memory>
#include <string>

#include "api/service/housekeeping.h"
#include "common/result.h"

namespace diaphane::api {

/// The transport that a setting names: `file:DIRECTORY` (one .eml a mail, for one machine and for
/// tests) or `smtp://[user:password@]host:port` (STARTTLS when the server offers it) or
/// `smtps://…`. `from` is the sender's address. kInvalid for anything else; its message never
/// repeats a password.
Result<std::unique_ptr<MailTransport>> open_mail_transport(const std::string& setting,
                                                           const std::string& from);

/// The mail as RFC 5322 text with CRLF lines; its body in base64, so that any text passes any
/// server. A line break in an address or a subject becomes a blank. `date` is RFC 5322's.
std::string message_of(const Mail& mail, const std::string& from, const std::string& date,
                       const std::string& message_id);

}  // namespace diaphane::api
