#include "operator/kube/access.h"

#include <fstream>
#include <iterator>

namespace diaphane::kube {
namespace {

std::string contents(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) {
    text.pop_back();
  }
  return text;
}

}  // namespace

Result<Access> access_of_pod(const std::map<std::string, std::string>& environment,
                             const std::string& account_dir) {
  const auto host = environment.find("KUBERNETES_SERVICE_HOST");
  const auto port = environment.find("KUBERNETES_SERVICE_PORT");
  if (host == environment.end() || host->second.empty()) {
    return fail(ErrorCode::kUnavailable,
                "not running in a pod: KUBERNETES_SERVICE_HOST is not set");
  }
  Access access;
  const bool v6 = host->second.find(':') != std::string::npos;
  access.server = "https://" + (v6 ? "[" + host->second + "]" : host->second) + ":" +
                  (port == environment.end() ? "443" : port->second);
  access.token_file = account_dir + "/token";
  access.ca_file = account_dir + "/ca.crt";
  access.name_space = contents(account_dir + "/namespace");
  return access;
}

std::string Token::at(Time now) {
  const std::lock_guard lock(mutex_);
  if (file_.empty()) return {};
  if (!read_ || now - *read_ >= kAge) {
    if (std::string token = contents(file_); !token.empty()) token_ = std::move(token);
    read_ = now;
  }
  return token_;
}

void Token::refused() {
  const std::lock_guard lock(mutex_);
  read_.reset();
}

}  // namespace diaphane::kube
