#pragma once

#include <string>

#include "api/pacs/archives.h"

namespace diaphane::api {

/// Sends requests to the PACS gateway with libcurl.
class GatewayClient final : public ArchiveGateway {
 public:
  /// `url` is the gateway's origin, or empty if there is none. `key` is the secret they share.
  GatewayClient(std::string url, std::string key) : url_(std::move(url)), key_(std::move(key)) {}
  bool installed() const override { return !url_.empty(); }
  Result<Answer> send(const std::string& path, const std::string& body) override;

 private:
  std::string url_, key_;
};

}  // namespace diaphane::api
