#include "common/postgres/connection.h"

#include <libpq-fe.h>

#include <map>

namespace diaphane::postgres {
namespace {

struct FreeParsed {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

std::string quoted(const std::string& value) {
  std::string text = "'";
  for (const char c : value) {
    if (c == '\'' || c == '\\') text += '\\';
    text += c;
  }
  return text + "'";
}

}  // namespace

std::string with_settings(const std::string& url,
                          std::initializer_list<std::pair<const char*, std::string>> settings) {
  const std::unique_ptr<PQconninfoOption, FreeParsed> parsed(PQconninfoParse(url.c_str(), nullptr));
  if (!parsed) return url;  // libpq reports the error when it connects
  std::map<std::string, std::string> all;
  for (const PQconninfoOption* option = parsed.get(); option->keyword; ++option) {
    if (option->val) all[option->keyword] = option->val;
  }
  for (const auto& [keyword, value] : settings) all[keyword] = value;
  std::string text;
  for (const auto& [keyword, value] : all) {
    text += (text.empty() ? "" : " ") + keyword + "=" + quoted(value);
  }
  return text;
}

std::unique_ptr<pqxx::connection> connect(const std::string& url, const std::string& program,
                                          const Patience& patience, SocketDeadlines& deadlines) {
  // Two seconds is libpq's minimum. The other settings detect a host that has disappeared.
  auto connection = std::make_unique<pqxx::connection>(
      with_settings(url, {{"application_name", "diaphane-" + program},
                          {"connect_timeout", "2"},
                          {"keepalives_idle", "5"},
                          {"keepalives_interval", "5"},
                          {"keepalives_count", "3"},
                          {"tcp_user_timeout", std::to_string(patience.answer.count())}}));
  // Without the call below, libpqxx 6 would silently reopen a lost connection. The call is
  // deprecated, because version 7 no longer does that.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  connection->inhibit_reactivation(true);
#pragma GCC diagnostic pop
  connection->set_verbosity(pqxx::connection_base::terse);
  const SocketDeadlines::Guard guard(deadlines, connection->sock(),
                                     std::chrono::steady_clock::now() + patience.answer);
  const auto ms = [](std::chrono::milliseconds time) { return std::to_string(time.count()); };
  pqxx::nontransaction(*connection)
      .exec("SET statement_timeout = " + ms(patience.statement) +
            "; SET lock_timeout = " + ms(patience.lock) +
            "; SET idle_in_transaction_session_timeout = '30s'; SET client_min_messages = error");
  return connection;
}

}  // namespace diaphane::postgres
